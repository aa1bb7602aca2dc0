#include "core/hash.h"
#include "core/error.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <thread>

namespace sightline {
namespace {

void write_filled(const std::string& path, char fill) {
    std::ofstream(path, std::ios::binary) << std::string(1 << 20, fill);
}

// How many bytes this process has read from files.
uint64_t bytes_read() {
    std::ifstream io("/proc/self/io");
    std::string name;
    uint64_t count = 0;
    while (io >> name >> count)
        if (name == "rchar:") return count;
    return 0;
}

TEST(Hash, OfAFileIsThatOfItsBytes) {
    const std::string path = (test_folder() / "a").string();
    write_filled(path, 'x');
    EXPECT_EQ(hash_file(path), hash_text(std::string(1 << 20, 'x')));
    EXPECT_EQ(hash_file(path, 1 << 20), hash_file(path));
    EXPECT_THROW(hash_file(path, (1 << 20) - 1), LimitError);
    EXPECT_THROW(hash_file(path + "b"), Error);
}

// A file of the kernel's is longer than its size says, as one that grows is.
TEST(Hash, StopsAtTheLimitEvenIfTheFileGrows) {
    EXPECT_NO_THROW(hash_file("/proc/self/status"));
    EXPECT_THROW(hash_file("/proc/self/status", 10), LimitError);
}

TEST(Hash, OfASharedFileIsReadAgainOnlyIfTheFileChanges) {
    const std::string path = (test_folder() / "shared").string();
    write_filled(path, 'x');
    // A file that has just been written may change again without a change of its times.
    const uint64_t first = hash_shared_file(path);
    write_filled(path, 'y');
    const uint64_t second = hash_shared_file(path);
    EXPECT_NE(second, first);
    std::this_thread::sleep_for(std::chrono::milliseconds(2100));
    EXPECT_EQ(hash_shared_file(path), second);
    const uint64_t before = bytes_read();
    EXPECT_EQ(hash_shared_file(path), second);
    EXPECT_LT(bytes_read() - before, 10000u);
    EXPECT_THROW(hash_shared_file(path, 1000), LimitError);
    write_filled(path, 'x');
    EXPECT_EQ(hash_shared_file(path), first);
}

}  // namespace
}  // namespace sightline
