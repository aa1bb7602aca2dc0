#include "output/exr.h"
#include "support/test_folder.h"

#include "core/error.h"
#include "core/files.h"
#include "image/image.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <bit>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>

namespace sightline {
namespace {

std::string folder() { return test_folder().string() + "/"; }

/// A film of every channel type, whose window is a crop of the display.
Film sample_film() {
    Film film;
    film.display = {0, 0, 40, 30};
    film.window = {5, 7, 38, 29};
    const auto count = static_cast<size_t>(film.window.width() * film.window.height());
    using Type = Channel::Type;
    for (const auto& [name, type] : {std::pair("A", Type::half),
                                     {"B", Type::float32},
                                     {"G", Type::float32},
                                     {"R", Type::float32},
                                     {"depth.Z", Type::float32},
                                     {"object.id", Type::uint32}}) {
        Channel& channel = film.channels.emplace_back();
        channel.name = name;
        channel.type = type;
        for (size_t i = 0; i < count; ++i) {
            const float value =
                static_cast<float>(i % 100) + (name == std::string("R") ? 0.5f : 0.25f);
            if (type == Type::uint32) {
                channel.integers.push_back(static_cast<uint32_t>(i * 2654435761u));
            } else {
                channel.values.push_back(type == Type::half ? value : value / 3);
            }
        }
    }
    film.channels[4].values[3] = std::numeric_limits<float>::infinity();
    film.channels[4].values[4] = std::numeric_limits<float>::denorm_min();
    film.channels[4].values[5] = -0.0f;
    return film;
}

bool same_bits(const std::vector<float>& a, const std::vector<float>& b) {
    const auto bits = [](float x) { return std::bit_cast<uint32_t>(x); };
    return std::ranges::equal(a, b, {}, bits, bits);
}

TEST(Exr, ReadsBackBitEqualWithItsWindows) {
    const Film film = sample_film();
    const std::string path = folder() + "a.exr";
    write_exr(path, film, {});
    const Film back = read_exr(path);
    EXPECT_EQ(back.display.x1, 40);
    EXPECT_EQ(back.display.y1, 30);
    EXPECT_EQ(back.window.x0, 5);
    EXPECT_EQ(back.window.y0, 7);
    EXPECT_EQ(back.window.x1, 38);
    EXPECT_EQ(back.window.y1, 29);
    ASSERT_EQ(back.channels.size(), film.channels.size());
    for (size_t c = 0; c < film.channels.size(); ++c) {
        EXPECT_EQ(back.channels[c].name, film.channels[c].name);
        EXPECT_EQ(back.channels[c].type, film.channels[c].type);
        EXPECT_TRUE(same_bits(back.channels[c].values, film.channels[c].values)) << c;
        EXPECT_EQ(back.channels[c].integers, film.channels[c].integers);
    }
}

TEST(Exr, HalfChannelsClampFiniteValuesToTheirRange) {
    Film film;
    film.display = film.window = {0, 0, 3, 1};
    film.channels.emplace_back();
    film.channels[0].name = "R";
    film.channels[0].type = Channel::Type::half;
    film.channels[0].values = {1e9f, -1e9f, 1.0f / 3};
    write_exr(folder() + "half.exr", film, {});
    EXPECT_EQ(read_exr(folder() + "half.exr").channels[0].values,
              (std::vector<float>{65504, -65504, 0.33325195f}));
}

TEST(Exr, MetadataReadsBackUnchanged) {
    PictureMetadata metadata;
    metadata.world_to_camera[3][2] = -7;
    metadata.world_to_ndc[0][0] = 2;
    metadata.strings = {{"comments", "a \"picture\""}, {"software", "Sightline"}};
    metadata.numbers = {{"sightline/seconds", 0.25f}};
    write_exr(folder() + "info.exr", sample_film(), metadata);
    PictureMetadata back;
    read_exr(folder() + "info.exr", &back);
    EXPECT_EQ(back.world_to_camera, metadata.world_to_camera);
    EXPECT_EQ(back.world_to_ndc, metadata.world_to_ndc);
    EXPECT_EQ(back.strings, metadata.strings);
    EXPECT_EQ(back.numbers, metadata.numbers);
}

TEST(Exr, TheFileIsTheSameForAnyNumberOfThreads) {
    write_exr(folder() + "one.exr", sample_film(), {}, {.threads = 1});
    write_exr(folder() + "four.exr", sample_film(), {}, {.threads = 4});
    EXPECT_EQ(read_file(folder() + "one.exr", 1 << 20), read_file(folder() + "four.exr", 1 << 20));
}

// The film's rows from `y0` to `y1`.
Film rows_of(const Film& film, int y0, int y1) {
    Film rows = film;
    for (Channel& channel : rows.channels) channel.values.clear(), channel.integers.clear();
    rows.window = {film.window.x0, y0, film.window.x1, y0};
    for (int y = y0; y < y1; ++y) append_row(rows, film, y);
    return rows;
}

// Wider and higher than a tile, with a window that is not aligned with the picture's tiles.
Film large_film() {
    Film film = sample_film();
    film.display = {0, 0, 200, 180};
    film.window = {5, 7, 150, 160};
    const size_t count = 145 * 153;
    for (Channel& channel : film.channels) {
        const auto grow = [&](auto& values) {
            if (values.empty()) return;
            const auto period = values;
            values.resize(count);
            for (size_t i = 0; i < count; ++i) values[i] = period[i * i % period.size()];
        };
        grow(channel.values), grow(channel.integers);
    }
    return film;
}

TEST(Exr, EveryLayoutReadsBackBitEqualAndDoesNotDependOnTheBands) {
    const Film film = large_film();
    const std::string path = folder() + "bands.exr", at_once = folder() + "at_once.exr";
    for (const bool tiled : {false, true}) {
        for (const bool multipart : {false, true}) {
            for (const char* compression : exr_compressions) {
                SCOPED_TRACE(fmt::format("{} {} {}", tiled, multipart, compression));
                const ExrOptions options{tiled, multipart, compression, 2};
                PictureMetadata metadata;
                metadata.numbers["rays"] = 0;
                const auto writer = make_exr_writer(path, film, metadata, options);
                for (int y = 7; y < 160; y += 32)
                    writer->add(rows_of(film, y, std::min(y + 32, 160)));
                metadata.numbers["rays"] = 1e12;
                writer->finish(metadata, path);
                write_exr(at_once, film, metadata, options);
                EXPECT_TRUE(read_file(path, 1 << 24) == read_file(at_once, 1 << 24));
                PictureMetadata back;
                const Film read = read_exr(path, &back);
                EXPECT_EQ(back.numbers["rays"], 1e12);
                EXPECT_EQ(read.window.x1, 150);
                EXPECT_EQ(read.window.y1, 160);
                ASSERT_EQ(read.channels.size(), film.channels.size());
                for (const Channel& channel : film.channels) {
                    const Channel* found = read.find(channel.name);
                    ASSERT_TRUE(found) << channel.name;
                    EXPECT_EQ(found->type, channel.type);
                    EXPECT_TRUE(same_bits(found->values, channel.values));
                    EXPECT_EQ(found->integers, channel.integers);
                }
            }
        }
    }
}

TEST(Exr, AnUnfinishedWriterLeavesNoFile) {
    const std::string empty = folder() + "given_up/";
    std::filesystem::create_directories(empty);
    {
        const Film film = large_film();
        const auto writer = make_exr_writer(empty + "a.exr", film, {});
        writer->add(rows_of(film, 7, 50));
    }
    EXPECT_TRUE(std::filesystem::is_empty(empty));
}

TEST(Exr, OpenImageIoReadsTheCropInsideTheDisplayWindow) {
    const std::string path = folder() + "seen.exr";
    const Film film = sample_film();
    write_exr(path, film, {});
    const Image image = read_image(path);
    ASSERT_EQ(image.width, 40);
    ASSERT_EQ(image.height, 30);
    ASSERT_EQ(image.channels, 4);
    EXPECT_EQ(image.floats[0], 0);
    const size_t first = (7 * 40 + 5) * 4;
    EXPECT_EQ(image.floats[first], film.channels[3].values[0]);
    EXPECT_EQ(image.floats[first + 2], film.channels[1].values[0]);
    EXPECT_EQ(image.floats[first + 40 * 4], film.channels[3].values[33]);
}

TEST(Exr, AFullDiskGivesAnErrorAndLeavesNoFile) {
    const std::string empty = folder() + "full/";
    std::filesystem::remove_all(empty);
    std::filesystem::create_directories(empty);
    std::signal(SIGXFSZ, SIG_IGN);
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    for (const rlim_t size : {rlim_t{0}, rlim_t{100}, rlim_t{5000}}) {
        const rlimit full{size, before.rlim_max};
        setrlimit(RLIMIT_FSIZE, &full);
        EXPECT_THROW(write_exr(empty + "a.exr", sample_film(), {}), Error) << size;
        setrlimit(RLIMIT_FSIZE, &before);
    }
    EXPECT_TRUE(std::filesystem::is_empty(empty));
    EXPECT_THROW(write_exr("/nonexistent/a.exr", sample_film(), {}), Error);
}

TEST(Exr, EveryTruncationIsAnError) {
    const std::string path = folder() + "whole.exr";
    write_exr(path, sample_film(), {});
    const auto file = read_file(path, 1 << 20);
    for (size_t size = 0; size < file.size(); size += 1 + size / 16) {
        const std::string cut = folder() + "cut.exr";
        write_file(cut, std::span(file).first(size));
        EXPECT_THROW(read_exr(cut), Error) << size;
    }
    EXPECT_THROW(read_exr("/nonexistent.exr"), Error);
}

}  // namespace
}  // namespace sightline
