#include "batch/journal.h"
#include "core/error.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace sightline {
namespace {

namespace fs = std::filesystem;

std::string journal_path() {
    const fs::path folder =
        fs::path(testing::TempDir()) / fmt::format("batch_journal_{}", getpid());
    fs::remove_all(folder);
    fs::create_directories(folder);
    return folder / "journal.jsonl";
}

std::string read_text(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
}

Outcome full_outcome() {
    Outcome o;
    o.key = "0123";
    o.name = "a\n\"b\" ü";
    o.verdict = TaskVerdict::timeout;
    o.message = "not done";
    o.log = "x\ny";
    o.warnings = {"w1", "w2"};
    o.faults = {{"sampler-choice", "samplers[0].wrapS", "wrong: mended"}};
    o.fault_count = 201;
    o.inputs = {{"/a.glb", 0xfedcba9876543210u}};
    o.outputs = {{"a.png", 1}, {"t.jpg", 2}};
    o.seconds = 0.1;
    o.rays = 1ull << 60;
    o.memory = 7;
    o.change = {Change::Kind::changed, 0.25, "e.jpg", "why"};
    return o;
}

Outcome outcome(const std::string& key, TaskVerdict verdict) {
    Outcome o;
    o.key = o.name = key;
    o.verdict = verdict;
    return o;
}

TEST(Journal, ReadsBackAllFieldsOfAnOutcome) {
    const std::string path = journal_path();
    const Outcome before = full_outcome();
    Journal(path, false).append({before});
    const Journal journal(path, true);
    const Outcome* after = journal.find("0123");
    ASSERT_TRUE(after);
    EXPECT_EQ(after->name, before.name);
    EXPECT_EQ(after->verdict, before.verdict);
    EXPECT_EQ(after->message, before.message);
    EXPECT_EQ(after->log, before.log);
    EXPECT_EQ(after->warnings, before.warnings);
    EXPECT_EQ(after->faults, before.faults);
    EXPECT_EQ(after->fault_count, before.fault_count);
    EXPECT_EQ(after->inputs, before.inputs);
    EXPECT_EQ(after->outputs, before.outputs);
    EXPECT_EQ(after->seconds, before.seconds);
    EXPECT_EQ(after->rays, before.rays);
    EXPECT_EQ(after->memory, before.memory);
    EXPECT_EQ(after->change.kind, before.change.kind);
    EXPECT_EQ(after->change.flip, before.change.flip);
    EXPECT_EQ(journal.find("other"), nullptr);
}

TEST(Journal, FindsTheLastOutcomeOfATask) {
    const std::string path = journal_path();
    Journal(path, false)
        .append({outcome("a", TaskVerdict::failed), outcome("b", TaskVerdict::ok),
                 outcome("a", TaskVerdict::ok)});
    EXPECT_EQ(Journal(path, true).find("a")->verdict, TaskVerdict::ok);
    EXPECT_EQ(read_outcomes(path).size(), 3u);
}

TEST(Journal, KeepsCompleteLinesAndContinuesAfterACutAnywhere) {
    const std::string path = journal_path();
    Journal(path, false).append({outcome("a", TaskVerdict::ok), outcome("b", TaskVerdict::ok)});
    const std::string whole = read_text(path);
    const size_t first = whole.find('\n') + 1;
    for (size_t size = 0; size < whole.size(); size += 7) {
        std::ofstream(path) << whole.substr(0, size);
        Journal journal(path, true);
        EXPECT_EQ(journal.outcomes().size(), size >= first ? 1u : 0u) << size;
        journal.append({outcome("c", TaskVerdict::ok)});
        EXPECT_EQ(read_outcomes(path).size(), size >= first ? 2u : 1u) << size;
    }
}

TEST(Journal, SkipsLinesThatAreNotOutcomes) {
    const std::string path = journal_path();
    Journal(path, false).append({outcome("a", TaskVerdict::ok)});
    const std::string line = read_text(path);
    std::ofstream(path) << "{}\n[]\n\n{\"key\":3}\nnonsense\n"
                        << std::string(9, '\0') << "\n"
                        << line;
    EXPECT_EQ(Journal(path, true).outcomes().size(), 1u);
}

TEST(Journal, RefusesASecondBatchWhileTheFirstRuns) {
    const std::string path = journal_path();
    {
        const Journal first(path, false);
        EXPECT_THROW(Journal(path, true), Error);
    }
    EXPECT_NO_THROW(Journal(path, true));
}

TEST(Journal, RefusesToOverwriteAnEarlierBatch) {
    const std::string path = journal_path();
    Journal(path, false).append({outcome("a", TaskVerdict::ok)});
    EXPECT_THROW(Journal(path, false), Error);
}

TEST(Journal, ThrowsOnAFullDisk) {
    Journal journal(journal_path(), false);
    journal.append({outcome("a", TaskVerdict::ok)});
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit full{8, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &full);
    EXPECT_THROW(journal.append({outcome("b", TaskVerdict::ok)}), Error);
    setrlimit(RLIMIT_FSIZE, &before);
}

}  // namespace
}  // namespace sightline
