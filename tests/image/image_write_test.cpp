#include "core/error.h"
#include "image/write_image.h"
#include "support/images.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>

namespace sightline {
namespace {

Image grey(int size) {
    Image image;
    image.width = image.height = size;
    image.channels = 3;
    image.bytes.assign(size_t(size) * size_t(size) * 3, 128);
    return image;
}

TEST(ImageWriting, AReadOnlyFolderGivesAnErrorAndLeavesNothing) {
    EXPECT_THROW(write_image("/nonexistent/a.png", grey(1)), Error);
    EXPECT_THROW(write_image((test_folder() / "a.bmp").string(), grey(1)), Error);
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

TEST(ImageWriting, APngHoldsThePixelsThatWereWritten) {
    for (int channels = 1; channels <= 4; ++channels) {
        const Image image = pattern(13, 7, channels);
        const std::string path = (test_folder() / "pixels.png").string();
        write_image(path, image);
        const Image read = read_image(path);
        EXPECT_EQ(read.width, 13);
        EXPECT_EQ(read.height, 7);
        EXPECT_EQ(read.channels, channels);
        EXPECT_EQ(read.bytes, image.bytes) << channels;
        EXPECT_FALSE(read.damage);
    }
}

TEST(ImageWriting, AJpegHoldsAlmostTheColoursThatWereWritten) {
    for (const int channels : {1, 3}) {
        Image image = pattern(64, 48, channels);
        // Slow changes, which quality 95 keeps to the code value.
        for (size_t i = 0; i < image.bytes.size(); ++i)
            image.bytes[i] = uint8_t(i / size_t(channels) % 64 * 2 + i % size_t(channels) * 40);
        const std::string path = (test_folder() / "pixels.jpg").string();
        write_image(path, image);
        const Image read = read_image(path);
        ASSERT_EQ(read.bytes.size(), image.bytes.size());
        int largest = 0;
        for (size_t i = 0; i < image.bytes.size(); ++i)
            largest = std::max(largest, std::abs(int(read.bytes[i]) - int(image.bytes[i])));
        EXPECT_LE(largest, 4) << channels;
    }
}

TEST(ImageWriting, AJpegOfAlphaDropsIt) {
    write_image((test_folder() / "alpha.jpg").string(), pattern(8, 8, 4));
    EXPECT_EQ(read_image((test_folder() / "alpha.jpg").string()).channels, 3);
    write_image((test_folder() / "alpha.jpg").string(), pattern(8, 8, 2));
    EXPECT_EQ(read_image((test_folder() / "alpha.jpg").string()).channels, 1);
}

TEST(ImageWriting, ASideLongerThanAJpegCanHoldIsNamed) {
    try {
        write_image((test_folder() / "long.jpg").string(), pattern(65501, 1, 1));
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("65501 x 1 pixels, but a JPEG has at most 65500"),
                  std::string::npos);
    }
}

TEST(ImageWriting, AFullDiskGivesAnErrorAndLeavesNothing) {
    const std::string empty = (test_folder() / "full/").string();
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
