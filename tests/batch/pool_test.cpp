#include "batch/pool.h"

#include "core/error.h"
#include "support/test_folder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>

#include <csignal>

namespace sightline {
namespace {

using testing::HasSubstr;

// Workers that run each request as a shell command; its output is the response.
WorkerPool shell_pool() {
    return WorkerPool({"/bin/sh", {"-c", "while read -r line; do eval \"$line\"; done"}});
}

WorkerResponse next_response(WorkerPool& pool) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (std::chrono::steady_clock::now() < end)
        if (auto responses = pool.wait(0.1); !responses.empty()) return responses.at(0);
    ADD_FAILURE() << "no response";
    return {};
}

TEST(WorkerPool, ReusesAWorkerUntilItFails) {
    WorkerPool pool = shell_pool();
    std::string first;
    for (size_t i = 0; i < 3; ++i) {
        pool.submit(i, "echo $$", 10);
        const WorkerResponse response = next_response(pool);
        EXPECT_EQ(response.id, i);
        EXPECT_EQ(response.verdict, TaskVerdict::ok);
        if (i == 0) first = response.text;
        EXPECT_EQ(response.text, first);
    }
    EXPECT_EQ(pool.processes().size(), 1u);
}

TEST(WorkerPool, ReportsACrashForItsTaskOnlyWithTheEndOfTheLog) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "echo broken glass >&2; kill -SEGV $$", 10);
    const WorkerResponse bad = next_response(pool);
    EXPECT_EQ(bad.id, 1u);
    EXPECT_EQ(bad.verdict, TaskVerdict::crashed);
    EXPECT_THAT(bad.text, HasSubstr("signal 11"));
    EXPECT_EQ(bad.log, "broken glass\n");
    pool.submit(2, "echo fine", 10);
    EXPECT_EQ(next_response(pool).text, "fine");
}

TEST(WorkerPool, ReportsAnExitWithoutResponseAsACrash) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "exit 7", 10);
    const WorkerResponse response = next_response(pool);
    EXPECT_EQ(response.verdict, TaskVerdict::crashed);
    EXPECT_THAT(response.text, HasSubstr("status 7"));
}

TEST(WorkerPool, KillsAHangingWorkerAtTheTimeLimit) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "exec tail -f /dev/null", 0.001);
    const WorkerResponse response = next_response(pool);
    EXPECT_EQ(response.verdict, TaskVerdict::timeout);
    EXPECT_GE(response.seconds, 0.001);
    pool.submit(2, "echo fine", 10);
    EXPECT_EQ(next_response(pool).text, "fine");
}

TEST(WorkerPool, DistinguishesAKillFromACrash) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "exec tail -f /dev/null", 0);
    kill(pool.processes().at(0), SIGKILL);
    EXPECT_EQ(next_response(pool).verdict, TaskVerdict::killed);
}

TEST(WorkerPool, ReplacesAWorkerThatWasKilledWhileIdle) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "echo fine", 10);
    next_response(pool);
    kill(pool.processes().at(0), SIGKILL);
    while (!pool.processes().empty()) pool.wait(0.1);
    pool.submit(2, "echo fine", 10);
    EXPECT_EQ(next_response(pool).text, "fine");
}

TEST(WorkerPool, RecognisesLackOfMemory) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "echo \"what():  std::bad_alloc\" >&2; kill -ABRT $$", 10);
    EXPECT_EQ(next_response(pool).verdict, TaskVerdict::out_of_memory);
}

TEST(WorkerPool, NamesTheMemoryLimitThatAWorkerMet) {
    for (const char* text : {"std::bad_alloc", "Resource temporarily unavailable"}) {
        WorkerPool pool({"/bin/sh", {"-c", "while read -r line; do eval \"$line\"; done"}, 500});
        pool.submit(1, fmt::format("echo 'what(): {}' >&2; kill -ABRT $$", text), 10);
        const WorkerResponse response = next_response(pool);
        EXPECT_EQ(response.verdict, TaskVerdict::out_of_memory);
        EXPECT_THAT(response.text, HasSubstr("500 MiB (--memory)"));
    }
}

TEST(WorkerPool, TakesAKillByTheKernelForLackOfMemory) {
    constexpr uint64_t mebibyte = 1 << 20;
    // The status of a process that a signal has ended is the signal.
    const WorkerEnd killed{SIGKILL, 100 * mebibyte, 1, ""};
    EXPECT_TRUE(ended_for_memory(killed, 0));
    EXPECT_TRUE(ended_for_memory(killed, 500));
    EXPECT_FALSE(ended_for_memory({SIGKILL, 100 * mebibyte, 0, ""}, 0));
    EXPECT_FALSE(ended_for_memory({SIGKILL, 100 * mebibyte, 0, ""}, 500));
    EXPECT_FALSE(ended_for_memory({SIGSEGV, 100 * mebibyte, 1, ""}, 500));
}

TEST(WorkerPool, TakesACrashAtTheLimitForLackOfMemory) {
    constexpr uint64_t mebibyte = 1 << 20;
    for (const int signal : {SIGKILL, SIGSEGV, SIGABRT, SIGBUS}) {
        EXPECT_TRUE(ended_for_memory({signal, 451 * mebibyte, 0, ""}, 500)) << signal;
        EXPECT_FALSE(ended_for_memory({signal, 449 * mebibyte, 0, ""}, 500)) << signal;
        EXPECT_FALSE(ended_for_memory({signal, 451 * mebibyte, 0, ""}, 0)) << signal;
    }
    constexpr int exit_7 = 7 << 8;
    EXPECT_FALSE(ended_for_memory({exit_7, 499 * mebibyte, 0, ""}, 500));
}

// A shell takes more than a mebibyte and less than 500.
TEST(WorkerPool, JudgesTheEndOfAWorkerByItsPeakAndItsLimit) {
    for (const char* signal : {"KILL", "SEGV"}) {
        for (const uint64_t limit : {1, 500}) {
            WorkerPool pool(
                {"/bin/sh", {"-c", "while read -r line; do eval \"$line\"; done"}, limit});
            pool.submit(1, fmt::format("kill -{} $$", signal), 10);
            const WorkerResponse response = next_response(pool);
            EXPECT_EQ(response.verdict == TaskVerdict::out_of_memory, limit == 1) << signal;
            if (limit > 1) continue;
            EXPECT_THAT(response.text, HasSubstr("1 MiB (--memory)"));
        }
    }
}

TEST(WorkerPool, ReportsThePeakOfAWorkerThatDied) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "exit 7", 10);
    EXPECT_GT(next_response(pool).memory, 0u);
}

TEST(WorkerPool, KeepsTheEndOfALongLog) {
    WorkerPool pool = shell_pool();
    pool.submit(1, "i=0; while [ $i -lt 20000 ]; do echo line $i; i=$((i+1)); done >&2; exit 1",
                60);
    const WorkerResponse response = next_response(pool);
    EXPECT_LE(response.log.size(), 4096u);
    EXPECT_THAT(response.log, HasSubstr("line 19999\n"));
}

// Each worker blocks on a pipe until another, which must be running at the same time, uses it.
TEST(WorkerPool, RunsWorkersConcurrently) {
    const std::string pipe = (test_folder() / "pipe").string();
    for (const char* name : {"0", "1", "2"}) ASSERT_EQ(mkfifo((pipe + name).c_str(), 0600), 0);
    const auto send = [&](const char* to) { return "echo go > '" + pipe + to + "'; "; };
    const auto receive = [&](const char* from) { return "read -r x < '" + pipe + from + "'; "; };
    WorkerPool pool = shell_pool();
    pool.submit(0, send("1") + receive("0") + "echo fine", 0);
    pool.submit(1, receive("1") + send("2") + "echo fine", 0);
    pool.submit(2, receive("2") + send("0") + "echo fine", 0);
    EXPECT_EQ(pool.running(), 3u);
    // Several responses may come at once.
    size_t count = 0;
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (pool.running() > 0 && std::chrono::steady_clock::now() < end) {
        for (const WorkerResponse& response : pool.wait(0.1)) {
            EXPECT_EQ(response.text, "fine");
            ++count;
        }
    }
    EXPECT_EQ(count, 3u);
}

TEST(WorkerPool, ThrowsIfTheProgramCannotStart) {
    WorkerPool pool({"/nonexistent", {}});
    EXPECT_THROW(pool.submit(1, "", 1), Error);
}

}  // namespace
}  // namespace sightline
