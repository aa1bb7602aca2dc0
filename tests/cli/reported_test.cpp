// Small files made after public bug reports about other programs, each with the right value in the
// README beside it. They are not part of the project: tests are skipped where they are missing.
#include "core/text.h"
#include "image/image.h"
#include "output/exr.h"
#include "support/test_folder.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <numeric>

namespace sightline {
namespace {

namespace fs = std::filesystem;

const fs::path reported = SIGHTLINE_SOURCE_DIR "/../shared/corpus/reported";
constexpr const char* dark = "--env none --background 0,0,0 ";

class Reported : public testing::Test {
  protected:
    void SetUp() override {
        if (!fs::exists(reported)) GTEST_SKIP() << "no files of bug reports beside the checkout";
        if (SIGHTLINE_SANITIZED) GTEST_SKIP() << "measured values; release builds check them";
    }
};

std::string render(const std::string& file, const std::string& options, const char* picture) {
    std::string path = (test_folder() / picture).string();
    const std::string command =
        fmt::format("{} render {} -o {} --quiet {} 2>/dev/null", SIGHTLINE_PROGRAM,
                    shell_quoted((reported / file).string()), path, options);
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return path;
}

Film render_film(const std::string& file, const std::string& options) {
    return read_exr(render(file, options, "picture.exr"));
}

// The values of a channel in the middle: `part` of the width and of the height.
std::vector<double> middle(const Film& film, const char* channel, double part) {
    const int width = film.window.width(), height = film.window.height();
    const auto first = [&](int size) {
        return static_cast<int>(std::floor(size * (1 - part) / 2));
    };
    std::vector<double> values;
    for (int y = first(height); y < height - first(height); ++y)
        for (int x = first(width); x < width - first(width); ++x)
            values.push_back(static_cast<double>(
                film.find(channel)->values[static_cast<size_t>(y) * static_cast<size_t>(width) +
                                           static_cast<size_t>(x)]));
    return values;
}

double mean(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

double deviation(const std::vector<double>& values) {
    const double m = mean(values);
    double sum = 0;
    for (const double v : values) sum += (v - m) * (v - m);
    return std::sqrt(sum / static_cast<double>(values.size()));
}

double middle_mean(const std::string& file, const std::string& options, double part = 0.34,
                   const char* channel = "G") {
    return mean(middle(render_film(file, options), channel, part));
}

// The number of black pixels that lie between others both in their row and in their column: those
// along an outline may miss all of its samples.
int holes(const Film& film) {
    const auto width = static_cast<size_t>(film.window.width());
    const auto height = static_cast<size_t>(film.window.height());
    const auto lit = [&](size_t x, size_t y) {
        float sum = 0;
        for (const char* channel : {"R", "G", "B"})
            sum += film.find(channel)->values[y * width + x];
        return sum > 0;
    };
    const auto any = [](size_t begin, size_t end, auto is_lit) {
        while (begin < end && !is_lit(begin)) ++begin;
        return begin < end;
    };
    int count = 0;
    for (size_t y = 0; y < height; ++y)
        for (size_t x = 0; x < width; ++x) {
            const auto in_row = [&](size_t i) { return lit(i, y); };
            const auto in_column = [&](size_t i) { return lit(x, i); };
            count += !lit(x, y) && any(0, x, in_row) && any(x, width, in_row) &&
                     any(0, y, in_column) && any(y, height, in_column);
        }
    return count;
}

TEST_F(Reported, SurfacesInOnePlaceHideNothing) {
    const std::string options = std::string(dark) + "--size 80x80 --samples 4 --intersector ";
    for (const char* engine : {"auto", "embree", "exact"}) {
        SCOPED_TRACE(engine);
        for (const char* file : {"front-back/front_first", "front-back/back_first",
                                 "cutout-over-opaque/sphere_overlay_first",
                                 "cutout-over-opaque/wall_and_coplanar_decal",
                                 "cutout-over-opaque/wall_and_coplanar_decal_2tri",
                                 "cutout-over-opaque/wall_and_coplanar_decal_blend"}) {
            const Film film = render_film(fmt::format("coincident-{}.glb", file), options + engine);
            EXPECT_EQ(holes(film), 0) << file;
            EXPECT_GT(mean(middle(film, "R", 0.2)), 0.05) << file;
        }
        for (const char* file : {"leaves", "leaves_from_behind"})
            EXPECT_GT(mean(middle(render_film(fmt::format("coincident-front-back/{}.glb", file),
                                              options + engine),
                                  "G", 1)),
                      0.05)
                << file;
    }
    for (const char* file : {"touching", "gap"}) {
        const Film film = render_film(fmt::format("coincident-glass-faces/{}.glb", file),
                                      std::string(dark) + "--size 32x32 --samples 16");
        EXPECT_NEAR(mean(middle(film, "R", 0.2)), 0.5, 0.005) << file;
        EXPECT_NEAR(mean(middle(film, "G", 0.2)), 0.5, 0.005) << file;
        EXPECT_NEAR(mean(middle(film, "B", 0.2)), 1, 0.005) << file;
    }
}

TEST_F(Reported, LightPassesTheBacksThatTheViewLooksThrough) {
    const std::string folder = "culled-faces-cast-shadows/", options = "--size 96x96 --samples 16";
    const std::string lit = dark + options;
    EXPECT_GT(middle_mean(folder + "inside_out.glb", options), 0.3);
    EXPECT_NEAR(middle_mean(folder + "outline_hull.glb", lit, 0.1), 0.52, 0.026);
    // The back wall is in the middle of the view.
    EXPECT_NEAR(middle_mean(folder + "room_sun.glb", lit, 0.1), 0.33, 0.0165);
    // What remains are reflections of the floor in the wall.
    EXPECT_LT(middle_mean(folder + "room_sun_without_near_wall.glb", lit, 0.1), 0.01);
    EXPECT_LT(middle_mean(folder + "room_sun_camera_inside.glb", lit), 0.01);
}

TEST_F(Reported, APaneOfIor1ChangesNoLight) {
    const std::string options =
        std::string(dark) +
        "--look-from 0,0.5,0.4 --look-at 0,0,0 --fov 40 --size 24x24 --samples 1024";
    for (const char* floor : {"metal", "white"}) {
        const auto below = [&](const char* pane) {
            return middle_mean(fmt::format("light-through-a-pane/{}_area_{}.glb", floor, pane),
                               options);
        };
        const double open = below("open");
        for (const char* pane : {"alpha0", "thin1", "rough1"})
            EXPECT_NEAR(below(pane) / open, 1, 0.005) << floor << ' ' << pane;
    }
}

TEST_F(Reported, WhiteMaterialsReturnAllLight) {
    const std::string options =
        fmt::format("--env {} --size 48x48 --samples 256 --depth 32",
                    shell_quoted((reported / "furnace/white.hdr").string()));
    for (const auto& entry : fs::directory_iterator(reported / "furnace")) {
        if (entry.path().extension() != ".glb") continue;
        const std::string name = entry.path().stem().string();
        SCOPED_TRACE(name);
        const Film film = render_film("furnace/" + name + ".glb", options);
        const bool absorbs = name.starts_with("sheen_0") || name == "iridescent";
        for (const double part : {0.1, 0.4, 1.0}) {
            const auto values = middle(film, "G", part);
            const double error = deviation(values) / std::sqrt(static_cast<double>(values.size()));
            EXPECT_LT(mean(values), 1.001 + 3 * error) << part;
            if (!absorbs) {
                EXPECT_GT(mean(values), 0.97) << part;
            }
        }
    }
}

TEST_F(Reported, TexturesAreAsSharpAsTheSamplesAllow) {
    const auto contrast = [](int size, int samples) {
        const Film film =
            render_film("texture-sharpness/noise_mipmapped.glb",
                        fmt::format("{} --size {}x{} --samples {}", dark, size, size, samples));
        return deviation(middle(film, "R", 1 - 8.0 / size));
    };
    EXPECT_NEAR(contrast(64, 64), 0.114, 0.03 * 0.114);
    EXPECT_NEAR(contrast(128, 64), 0.173, 0.03 * 0.173);
    EXPECT_LT(contrast(64, 1), 0.1445 * 1.001);
}

TEST_F(Reported, FarTinyAndFlatModelsLookAsOthersDo) {
    const std::string options = "--size 64x64 --samples 16 --background transparent";
    const double right = middle_mean("geo-offset/at_origin.glb", options, 1, "A");
    // A ball of 48 meridians that spans 0.9 of the picture: pi/4 0.9² sin(2pi/48) / (2pi/48).
    constexpr double ball = 0.6344;
    EXPECT_NEAR(right, ball, 0.001);
    for (const char* file : {"geo-offset/ecef.glb", "geo-offset/mercator_z17.glb"})
        EXPECT_NEAR(middle_mean(file, options, 1, "A"), right, 1e-4) << file;
    EXPECT_NEAR(middle_mean("tiny-model/radius_1e-15.glb", options, 1, "A"), ball, 0.001);
    for (const char* file : {"one_node", "two_nodes"})
        EXPECT_NEAR(middle_mean(fmt::format("flat-instances/{}.glb", file),
                                std::string(dark) + "--size 64x64 --samples 1", 0.05),
                    0.5, 0.025)
            << file;
}

TEST_F(Reported, SurfacesShineByWhatTheyCover) {
    const std::string options =
        std::string(dark) + "--look-from 0,0.2,5 --look-at 0,-1,0 --fov 0.5 --size 8x8 ";
    const auto floor = [&](const char* file, const char* samples) {
        return middle_mean(file, options + "--samples " + samples, 1);
    };
    const double opaque = floor("emissive-alpha/opaque.glb", "4096");
    EXPECT_NEAR(opaque, 1.84, 0.092);
    EXPECT_NEAR(floor("emissive-alpha/blend_half.glb", "4096") / opaque, 0.5, 0.005);
    EXPECT_EQ(floor("emissive-alpha/blend_zero.glb", "4096"), 0);
    for (const char* file : {"linear", "mipmapped"})
        EXPECT_NEAR(
            floor(fmt::format("emissive-texture-without-mipmaps/{}.glb", file).c_str(), "1024"),
            0.70, 0.035)
            << file;
}

TEST_F(Reported, EnvironmentsAreReadAsTheyAreMeant) {
    const auto env = [](const char* file) {
        return " --env " + shell_quoted((reported / file).string());
    };
    const std::string sphere = "environment-inf-sun/sphere.glb";
    const double finite = middle_mean(
        sphere, "--size 32x32 --samples 64" + env("environment-inf-sun/sun_65504.exr"), 1);
    EXPECT_GT(finite, 1);
    EXPECT_EQ(middle_mean(sphere,
                          "--size 32x32 --samples 64" + env("environment-inf-sun/sun_inf.exr"), 1),
              finite);
    const std::string look = "--look-from 0,0,0 --fov 4 --size 16x16 --samples 1 --look-at ";
    for (const char* file : {"hdr-orientation/upright.hdr", "hdr-orientation/plus_y.hdr"}) {
        const Film up = render_film("hdr-orientation/tiny.glb", look + "0.001,1,0" + env(file));
        EXPECT_NEAR(mean(middle(up, "G", 0.5)), 4, 0.04) << file;
        const Film towards_z = render_film("hdr-orientation/tiny.glb", look + "0,0,1" + env(file));
        EXPECT_NEAR(mean(middle(towards_z, "G", 0.5)), 1, 0.01) << file;
        EXPECT_NEAR(mean(middle(towards_z, "R", 0.5)), 0, 0.01) << file;
    }
}

TEST_F(Reported, AFaintPathToABrightLampIsSeenInEveryFormat) {
    const std::string options =
        std::string(dark) + "--look-from -2,2,0 --look-at 0,0,0 --fov 5 --size 16x16 --samples 4";
    const std::string file = "faint-path-to-a-bright-lamp/two_mirrors.glb";
    EXPECT_NEAR(middle_mean(file, options), 7.6, 0.38);
    const Image png = read_image(render(file, options, "picture.png"));
    EXPECT_GT(png.bytes[png.bytes.size() / 2], 250);
}

TEST_F(Reported, OldAndTurnedMaterialsLookAsMeant) {
    for (const char* file : {"baked", "transform"}) {
        const Film film =
            render_film(fmt::format("normal-map-under-texture-transform/{}.glb", file),
                        "--env none --size 16x16 --samples 1");
        EXPECT_NEAR(mean(middle(film, "normal.X", 0.2)), -0.5, 0.005) << file;
        EXPECT_NEAR(mean(middle(film, "normal.Y", 0.2)), 0, 0.005) << file;
        EXPECT_NEAR(mean(middle(film, "normal.Z", 0.2)), 0.867, 0.005) << file;
    }
    const Film film = render_film("spec-gloss-texture/specgloss.glb",
                                  "--env studio --background 0,0,0 --size 96x96 --samples 64");
    double left = 0, right = 0;
    for (size_t i = 0; i < film.find("G")->values.size(); ++i)
        (i % 96 < 48 ? left : right) += static_cast<double>(film.find("G")->values[i]);
    EXPECT_NEAR(right / left, 1, 0.03);
}

}  // namespace
}  // namespace sightline
