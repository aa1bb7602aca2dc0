#include "core/error.h"
#include "image/write_image.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>

namespace sightline {
namespace {

std::string folder() { return test_folder().string() + "/"; }

Image grey(int size) {
    Image image;
    image.width = image.height = size;
    image.channels = 3;
    image.bytes.assign(size_t(size) * size_t(size) * 3, 128);
    return image;
}

TEST(ImageWriting, AReadOnlyFolderGivesAnErrorAndLeavesNothing) {
    EXPECT_THROW(write_image("/nonexistent/a.png", grey(1)), Error);
    EXPECT_THROW(write_image(folder() + "a.bmp", grey(1)), Error);
}

/// Makes writes past `bytes` of any file fail, as on a full disk, until the end of the scope.
class FullDisk {
  public:
    explicit FullDisk(rlim_t bytes) {
        getrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, SIG_IGN);
        const rlimit full{bytes, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &full);
    }
    ~FullDisk() { setrlimit(RLIMIT_FSIZE, &before_); }
    FullDisk(const FullDisk&) = delete;

  private:
    rlimit before_{};
};

TEST(ImageWriting, AFullDiskGivesAnErrorAndLeavesNothing) {
    const std::string empty = folder() + "full/";
    std::filesystem::remove_all(empty);
    std::filesystem::create_directories(empty);
    {
        const FullDisk full(16);
        for (const char* ending : {".png", ".tif", ".jpg", ".webp"}) {
            EXPECT_THROW(write_image(empty + "a" + ending, grey(64)), Error) << ending;
        }
    }
    EXPECT_TRUE(std::filesystem::is_empty(empty));
}

}  // namespace
}  // namespace sightline
