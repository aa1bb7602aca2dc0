// Malicious images: each must give an Error or an image, quickly and with little memory. Each is
// decoded in its own process, so that a crash is one failed file.
#include "core/error.h"
#include "core/files.h"
#include "image/write_image.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <vector>

namespace sightline {
namespace {

constexpr bool sanitized = SIGHTLINE_SANITIZED;
constexpr unsigned max_seconds = sanitized ? 60 : 5;
constexpr long max_kibibytes = 1 << 20;

/// How a child process that runs `work` failed; empty if it succeeded within the limits.
std::string complaint(const std::function<void()>& work) {
    const pid_t child = fork();
    if (child == 0) {
        // CPU seconds: wall-clock time would include other processes.
        const rlimit seconds = {max_seconds, max_seconds};
        setrlimit(RLIMIT_CPU, &seconds);
        alarm(20 * max_seconds);
        try {
            work();
        } catch (const Error&) {
            // As good as an image.
        } catch (...) {
            _exit(2);
        }
        _exit(0);
    }
    int status = 0;
    rusage usage{};
    if (wait4(child, &status, 0, &usage) != child) return "lost";
    if (WIFSIGNALED(status)) return "signal " + std::to_string(WTERMSIG(status));
    if (WEXITSTATUS(status) != 0) return "exit code " + std::to_string(WEXITSTATUS(status));
    if (!sanitized && usage.ru_maxrss > max_kibibytes) {
        return std::to_string(usage.ru_maxrss) + " KiB of memory";
    }
    return {};
}

std::vector<std::string> files_in(const std::string& folder) {
    std::vector<std::string> files;
    std::error_code ignored;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder, ignored)) {
        if (entry.is_regular_file()) files.push_back(entry.path().string());
    }
    return files;
}

/// Loads the module in the parent, so that the children need not.
void load_module() {
    const std::string hdr = "#?RADIANCE\n\n-Y 1 +X 1\n";
    EXPECT_THROW(decode_image(std::as_bytes(std::span(hdr)), "no pixels"), Error);
}

TEST(HostileImage, TheChildReportsCrashesAndExcessiveMemory) {
    EXPECT_EQ(complaint([] { throw Error("expected"); }), "");
    EXPECT_EQ(complaint([] { raise(SIGKILL); }), "signal 9");
    EXPECT_EQ(complaint([] { throw 1; }), "exit code 2");
    if (!sanitized) {
        EXPECT_NE(complaint([] {
                      const std::vector<char> greedy(size_t{max_kibibytes + 1024} << 10, 1);
                      if (greedy.back() != 1) throw Error("never");
                  }).find("KiB"),
                  std::string::npos);
    }
}

TEST(HostileImage, EveryFileOfTheCorpusGivesAnImageOrAnError) {
    const auto files = files_in(SIGHTLINE_SOURCE_DIR "/../shared/corpus/hostile-image");
    if (files.empty()) GTEST_SKIP() << "shared/corpus/hostile-image is not here";
    load_module();
    for (const std::string& file : files) {
        EXPECT_EQ(complaint([&] { read_image(file); }), "") << file;
        EXPECT_EQ(
            complaint([&] {
                decode_image(read_file(file, ImageLimits{}.max_file_bytes), file, {}, {5, true});
            }),
            "")
            << file;
    }
}

/// Decodes copies of a valid image with some bytes changed by a fixed pseudo-random sequence.
void expect_damage_is_survived(const FileBytes& good, const std::string& name) {
    load_module();
    EXPECT_EQ(complaint([&] {
                  uint32_t state = 1;
                  const auto next = [&](size_t below) {
                      state = state * 1664525u + 1013904223u;
                      return static_cast<size_t>(state >> 8) % below;
                  };
                  for (int round = 0; round < 300; ++round) {
                      FileBytes bad = good;
                      for (int k = 0; k < 1 + round % 8; ++k) {
                          bad[next(bad.size())] = static_cast<std::byte>(next(256));
                      }
                      try {
                          const WantedLevel wanted{round % 5, round % 2 == 0};
                          decode_image(bad, name, {.max_pixels = 1 << 22}, wanted);
                      } catch (const Error&) {
                          continue;
                      }
                  }
              }),
              "")
        << name;
}

TEST(HostileImage, DamagedImagesGiveAnImageOrAnError) {
    const std::string folder = test_folder().string() + "/";
    Image image;
    image.width = image.height = 24;
    image.channels = 3;
    for (int i = 0; i < 24 * 24 * 3; ++i) image.bytes.push_back(static_cast<uint8_t>(i * i % 253));
    for (const char* ending : {".jpg", ".png", ".tif", ".webp"}) {
        const std::string path = folder + "good" + ending;
        write_image(path, image);
        expect_damage_is_survived(read_file(path, 1 << 20), ending);
    }
    image.floats.assign(image.bytes.begin(), image.bytes.end());
    image.bytes.clear();
    write_image(folder + "good.hdr", image);
    expect_damage_is_survived(read_file(folder + "good.hdr", 1 << 20), ".hdr");
}

TEST(HostileImage, DamagedExrsGiveAnImageOrAnError) {
    const std::string path = SIGHTLINE_SOURCE_DIR
        "/../shared/corpus/hostile-image/AcademySoftwareFoundation_OpenImageIO/src/fuzz/corpora/"
        "openexr/seed.exr";
    if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
    expect_damage_is_survived(read_file(path, 1 << 20), ".exr");
}

void append(std::vector<std::byte>& file, std::initializer_list<int> values) {
    for (const int value : values) file.push_back(static_cast<std::byte>(value));
}

/// A grey progressive JPEG in as few bytes as its scans allow: the first scan has a bit for each
/// block, the others have a code for 16384 blocks without coefficients.
std::vector<std::byte> jpeg_of_scans(int side, int scans) {
    std::vector<std::byte> file;
    append(file, {0xff, 0xd8, 0xff, 0xdb, 0, 67, 0});
    file.resize(file.size() + 64, std::byte{1});  // the quantisers
    append(file,
           {0xff, 0xc2, 0, 11, 8, side >> 8, side & 255, side >> 8, side & 255, 1, 1, 0x11, 0});
    for (const int table : {0x00, 0x10}) {  // a code of one bit, 0, for a value
        append(file, {0xff, 0xc4, 0, 20, table, 1});
        file.resize(file.size() + 15);
        append(file, {table == 0 ? 0 : 0xe0});
    }
    append(file, {0xff, 0xda, 0, 8, 1, 1, 0, 0, 0, 0});
    const int blocks = side / 8 * (side / 8);
    file.resize(file.size() + static_cast<size_t>(blocks + 7) / 8);
    for (int scan = 1; scan < scans; ++scan) {
        const int coefficient = 1 + (scan - 1) % 63, bit = 13 - (scan - 1) / 63;
        append(file, {0xff, 0xda, 0, 8, 1, 1, 0, coefficient, coefficient,
                      (bit == 13 ? 0 : bit + 1) << 4 | bit});
        uint64_t bits = 0;  // 0 and 14 bits that add to 2¹⁴
        int count = 0;
        const auto put = [&](uint64_t value, int width) {
            bits = bits << width | value;
            for (count += width; count >= 8; count -= 8) {
                const int byte = static_cast<int>(bits >> (count - 8) & 255);
                append(file, {byte});
                if (byte == 255) append(file, {0});
            }
        };
        for (int left = blocks; left > 0; left -= 1 << 14) put(0, 15);
        put(127, 7);
    }
    append(file, {0xff, 0xd9});
    return file;
}

TEST(HostileImage, AJpegOfAsManyScansAsAreReadIsDecodedInItsSeconds) {
    // 5.4 s of processor time for 8192² pixels in 200 scans, 1.1 s in one.
    constexpr int side = sanitized ? 1024 : 8192, scans = sanitized ? 200 : 50;
    const auto file = jpeg_of_scans(side, scans);
    EXPECT_EQ(complaint([&] {
                  const Image image = decode_image(file, "many scans", {});
                  if (image.width != side || image.bytes.at(0) != 128) _exit(3);
              }),
              "");
    EXPECT_THROW(decode_image(jpeg_of_scans(8192, 51), "51 scans", {}), Error);
    EXPECT_THROW(decode_image(jpeg_of_scans(16, 201), "201 scans", {}), Error);
    EXPECT_NO_THROW(decode_image(jpeg_of_scans(16, 200), "200 scans", {}));
}

}  // namespace
}  // namespace sightline
