#include "core/files.h"
#include "core/error.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

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

TEST(Files, APendingFileAppearsOnCommitOnly) {
    const auto folder = test_folder();
    const std::string path = folder / "a";
    {
        PendingFile file(path);
        std::ofstream(file.writable_path()) << "whole";
        EXPECT_FALSE(std::filesystem::exists(path));
        file.commit();
        EXPECT_EQ(read_file(path, 100).size(), 5u);
    }
    { std::ofstream(PendingFile(path).writable_path()) << "given up"; }
    EXPECT_EQ(read_file(path, 100).size(), 5u);
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
    EXPECT_THROW(PendingFile("/nonexistent/a"), Error);
}

TEST(Files, WritingFollowsLinksAndReplacesNoFolderDeviceOrPipe) {
    namespace fs = std::filesystem;
    const fs::path folder = test_folder();
    fs::create_directory(folder / "far");
    write_text(folder / "far" / "a", "old");
    fs::create_symlink(folder / "far" / "a", folder / "link");
    write_text(folder / "link", "newer");
    EXPECT_TRUE(fs::is_symlink(folder / "link"));
    EXPECT_EQ(read_file(folder / "far" / "a", 100).size(), 5u);
    ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0600), 0);
    fs::create_symlink(folder / "pipe", folder / "to_pipe");
    for (const fs::path& path : {folder / "far", folder / "pipe", folder / "to_pipe"}) {
        EXPECT_THROW(write_text(path, "text"), Error) << path;
        EXPECT_FALSE(fs::is_regular_file(path));
    }
}

TEST(Files, ExtensionsAreInLowerCase) {
    EXPECT_EQ(extension_of("A.dir/b.GLTF"), ".gltf");
    EXPECT_EQ(extension_of("A.dir/b"), "");
}

TEST(Files, ReadingDoesNotWaitForAPipe) {
    const std::string pipe = test_folder() / "pipe";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_THROW(read_file(pipe, 100), Error);
}

TEST(Files, ReadingRejectsDirectoriesAndFilesAboveTheLimit) {
    EXPECT_THROW(read_file(testing::TempDir(), 100), Error);
    EXPECT_THROW(read_file("/nonexistent", 100), Error);
    EXPECT_THROW(read_file(SIGHTLINE_SOURCE_DIR "/CMakeLists.txt", 10), Error);
}

TEST(Files, StandardInputIsReadToItsEndOrToTheLimit) {
    const int kept = dup(STDIN_FILENO);
    const auto read = [](uint64_t limit) {
        int ends[2];
        EXPECT_EQ(pipe(ends), 0);
        EXPECT_EQ(write(ends[1], "hello", 5), 5);
        close(ends[1]);
        dup2(ends[0], STDIN_FILENO);
        close(ends[0]);
        return read_standard_input(limit).size();
    };
    EXPECT_EQ(read(5), 5U);
    EXPECT_THROW(read(4), LimitError);
    dup2(kept, STDIN_FILENO);
    close(kept);
}

}  // namespace
}  // namespace sightline
