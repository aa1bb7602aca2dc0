#include "batch/pool.h"
#include "core/error.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>

namespace sightline {
namespace {

using testing::HasSubstr;

// A worker that does what the request says, in the shell's language.
WorkerPool shell_pool() {
    return WorkerPool({"/bin/sh", {"-c", "while read -r line; do eval \"$line\"; done"}});
}

WorkerResponse next_answer(WorkerPool& pool) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (std::chrono::steady_clock::now() < end)
        if (auto answers = pool.wait(0.1); !answers.empty()) return answers.at(0);
    ADD_FAILURE() << "no answer";
    return {};
}

TEST(WorkerPool, AWorkerIsUsedAgainWhileItBehaves) {
    WorkerPool pool = shell_pool();
    std::string first;
    for (size_t i = 0; i < 3; ++i) {
        pool.submit(i, "echo $$", 10);
        const WorkerResponse answer = next_answer(pool);
        EXPECT_EQ(answer.id, i);
        EXPECT_EQ(answer.verdict, TaskVerdict::ok);
        if (i == 0) first = answer.text;
        EXPECT_EQ(answer.text, first);
    }
    EXPECT_EQ(pool.processes().size(), 1u);
}

TEST(WorkerPool, ACrashIsTheVerdictOfItsTaskAloneWithItsLastWords) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "echo broken glass >&2; kill -SEGV $$", 10);
    const WorkerResponse bad = next_answer(pool);
    EXPECT_EQ(bad.id, 1u);
    EXPECT_EQ(bad.verdict, TaskVerdict::crashed);
    EXPECT_THAT(bad.text, HasSubstr("signal 11"));
    EXPECT_EQ(bad.log, "broken glass\n");
    pool.submit(2, "echo fine", 10);
    EXPECT_EQ(next_answer(pool).text, "fine");
}

TEST(WorkerPool, AnEndWithoutAnAnswerIsACrash) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "exit 7", 10);
    const WorkerResponse answer = next_answer(pool);
    EXPECT_EQ(answer.verdict, TaskVerdict::crashed);
    EXPECT_THAT(answer.text, HasSubstr("status 7"));
}

TEST(WorkerPool, AHangEndsAtItsTime) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "exec sleep 60", 0.3);
    const WorkerResponse answer = next_answer(pool);
    EXPECT_EQ(answer.verdict, TaskVerdict::timeout);
    EXPECT_LT(answer.seconds, 10);
    pool.submit(2, "echo fine", 10);
    EXPECT_EQ(next_answer(pool).text, "fine");
}

TEST(WorkerPool, AKillFromOutsideIsToldFromACrash) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "exec sleep 60", 0);
    kill(pool.processes().at(0), SIGKILL);
    EXPECT_EQ(next_answer(pool).verdict, TaskVerdict::killed);
}

TEST(WorkerPool, AWorkerThatIsKilledWhileIdleIsReplaced) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "echo fine", 10);
    next_answer(pool);
    kill(pool.processes().at(0), SIGKILL);
    while (!pool.processes().empty()) pool.wait(0.1);
    pool.submit(2, "echo fine", 10);
    EXPECT_EQ(next_answer(pool).text, "fine");
}

TEST(WorkerPool, LackOfMemoryIsRecognised) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "echo \"what():  std::bad_alloc\" >&2; kill -ABRT $$", 10);
    EXPECT_EQ(next_answer(pool).verdict, TaskVerdict::out_of_memory);
}

TEST(WorkerPool, OfAFloodOfWordsTheLastStay) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "i=0; while [ $i -lt 20000 ]; do echo line $i; i=$((i+1)); done >&2; exit 1",
                60);
    const WorkerResponse answer = next_answer(pool);
    EXPECT_LE(answer.log.size(), 4096u);
    EXPECT_THAT(answer.log, HasSubstr("line 19999\n"));
}

TEST(WorkerPool, WorkersRunSideBySide) {
    WorkerPool pool = shell_pool();
    for (size_t i = 0; i < 3; ++i) pool.submit(i, "sleep 0.2; echo fine", 10);
    EXPECT_EQ(pool.running(), 3u);
    // Several may answer at once.
    size_t answered = 0;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (pool.running() > 0 && std::chrono::steady_clock::now() < end) {
        for (const WorkerResponse& answer : pool.wait(0.1)) {
            EXPECT_EQ(answer.text, "fine");
            ++answered;
        }
    }
    EXPECT_EQ(answered, 3u);
}

TEST(WorkerPool, AProgramThatCannotStartIsAnError) {
    WorkerPool pool({"/nonexistent", {}});
    EXPECT_THROW(pool.submit(1, "", 1), Error);
}

}  // namespace
}  // namespace sightline
