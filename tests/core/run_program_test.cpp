#include "core/run_program.h"

#include "core/error.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <string>
#include <thread>
#include <vector>

namespace sightline {
namespace {

ProgramEnd shell(const std::string& script, const ProgramInput& input = {},
                 std::stop_token stop = {}) {
    return run_program({"/bin/sh", "-c", script}, input, std::move(stop));
}

FileBytes bytes(size_t count) { return FileBytes(count, std::byte{'x'}); }

TEST(RunProgram, GivesWhatTheProgramWritesAndHowItEnds) {
    const ProgramEnd end = shell("echo out; echo first >&2; echo last >&2; exit 3");
    EXPECT_FALSE(end.succeeded());
    EXPECT_EQ(end.output, "out\n");
    EXPECT_EQ(last_line(end.errors), "last");
    EXPECT_EQ(end.status, 3);
    EXPECT_EQ(end.how, "exit status 3");
    EXPECT_TRUE(shell("exit 0").succeeded());
    const ProgramEnd killed = shell("kill -9 $$");
    EXPECT_EQ(killed.status, std::nullopt);
    EXPECT_EQ(killed.how, "signal 9 (Killed)");
}

TEST(RunProgram, FeedsMoreThanAPipeHoldsAndReadsMoreThanAPipeHolds) {
    int left = 10;
    const auto input = [&] { return left-- > 0 ? bytes(100'000) : FileBytes(); };
    EXPECT_EQ(shell("cat", input).output.size(), 1'000'000U);
}

TEST(RunProgram, StopsFeedingAProgramThatReadsNoMore) {
    std::signal(SIGPIPE, SIG_IGN);
    size_t given = 0;
    const auto input = [&] { return ++given > 100 ? FileBytes() : bytes(100'000); };
    EXPECT_TRUE(shell("exec <&-; sleep 0.2", input).succeeded());
    EXPECT_LT(given, 100U);
}

TEST(RunProgram, KillsTheProgramAfterAStopRequest) {
    std::stop_source stop;
    std::jthread later([&] {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        stop.request_stop();
    });
    EXPECT_EQ(shell("exec sleep 100", {}, stop.get_token()).how, "signal 9 (Killed)");
}

TEST(RunProgram, SaysWhatCannotBeStarted) {
    EXPECT_THROW(run_program({"/nonexistent/program"}), Error);
    EXPECT_EQ(find_program("a program that does not exist"), "");
    EXPECT_EQ(find_program("sh").back(), 'h');
}

TEST(FindProgram, TakesAPathAsItIs) {
    EXPECT_EQ(find_program("/bin/sh"), "/bin/sh");
    EXPECT_EQ(find_program("/bin/a program that does not exist"), "");
    EXPECT_EQ(find_program("/etc/passwd"), "") << "nobody may run it";
}

TEST(RunProgram, FindsTheLastLineThatIsNotBlank) {
    EXPECT_EQ(last_line(""), "");
    EXPECT_EQ(last_line("a\nb\n \n\n"), "b");
}

}  // namespace
}  // namespace sightline
