#include "core/files.h"
#include "core/error.h"
#include "test_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

namespace sightline {
namespace {

TEST(Files, AFailedWriteLeavesTheOldFileAndNoTemporary) {
    const auto folder = test_folder();
    const std::string path = folder / "a.txt";
    write_atomically(path, [](const std::string& to) { std::ofstream(to) << "old"; });
    EXPECT_THROW(write_atomically(path,
                                  [](const std::string& to) {
                                      std::ofstream(to) << "half";
                                      throw Error("disk full");
                                  }),
                 Error);
    const auto data = read_file(path, 100);
    EXPECT_EQ(std::string(reinterpret_cast<const char*>(data.data()), data.size()), "old");
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
}

TEST(Files, APendingFileShowsWhenItIsCommittedAndNotBefore) {
    const auto folder = test_folder();
    const std::string path = folder / "a";
    {
        PendingFile file(path);
        std::ofstream(file.place()) << "whole";
        EXPECT_FALSE(std::filesystem::exists(path));
        file.commit();
        EXPECT_EQ(read_file(path, 100).size(), 5u);
    }
    { std::ofstream(PendingFile(path).place()) << "given up"; }
    EXPECT_EQ(read_file(path, 100).size(), 5u);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
    EXPECT_THROW(PendingFile("/nonexistent/a"), Error);
}

TEST(Files, ReadingRefusesDirectoriesAndFilesOverTheLimit) {
    EXPECT_THROW(read_file(testing::TempDir(), 100), Error);
    EXPECT_THROW(read_file("/nonexistent", 100), Error);
    EXPECT_THROW(read_file(SIGHTLINE_SOURCE_DIR "/CMakeLists.txt", 10), Error);
}

}  // namespace
}  // namespace sightline
