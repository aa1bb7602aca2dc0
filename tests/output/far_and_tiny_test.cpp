// Assets far from the origin, tiny and huge: from the file to the picture's layers.
#include "core/error.h"
#include "output/exr.h"
#include "output/render_asset.h"
#include "scene/mesh_makers.h"
#include "support/gltf.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

/// Where and how large an asset is.
struct Place {
    json translation = {0, 0, 0};  ///< of everything
    double node_scale = 1;         ///< of everything
    double unit = 1;               ///< of the numbers within the nodes
    int uses = 1;                  ///< of the ball
};

constexpr double ball_radius = 0.75;

/// A ball over a floor, a glass ball that absorbs, a lamp, a spot and a camera.
std::string write_asset(const Place& place, const std::string& name) {
    GltfBuilder file;
    const auto u = static_cast<float>(place.unit);
    const auto mesh = [&](const Mesh& source, const json& material) {
        std::vector<float> positions, normals;
        std::vector<uint16_t> indices;
        for (const Vec3& p : source.positions)
            positions.insert(positions.end(), {p.x * u, p.y * u, p.z * u});
        for (const Vec3& n : source.normals) normals.insert(normals.end(), {n.x, n.y, n.z});
        for (const auto& t : source.triangles)
            for (const uint32_t v : t) indices.push_back(static_cast<uint16_t>(v));
        json attributes = {{"POSITION", file.floats(positions, "VEC3")}};
        if (!normals.empty()) attributes["NORMAL"] = file.floats(normals, "VEC3");
        const size_t number = file.add("materials", material);
        file.mesh_node(
            {{"attributes", attributes}, {"indices", file.indices(indices)}, {"material", number}});
    };
    const double lengths = place.unit * place.node_scale;
    mesh(sphere_mesh(16, 32, {0, 0, 0}, static_cast<float>(ball_radius)), json::object());
    mesh(quad_mesh({-2, -1, 2}, {4, 0, 0}, {0, 0, -4}), {{"doubleSided", true}});
    mesh(sphere_mesh(16, 32, {1.25f, 0, 1}, 0.5f),
         {{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 0}}},
          {"extensions",
           {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
            {"KHR_materials_volume",
             {{"thicknessFactor", 1},
              {"attenuationDistance", 0.5 * lengths},
              {"attenuationColor", {0.2, 0.5, 0.9}}}}}}});
    const double intensity = 40 * lengths * lengths;
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}, {"intensity", intensity}, {"range", 20 * lengths}},
        {{"type", "directional"}, {"intensity", 1}}};
    file.json["cameras"] = {
        {{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.01 * lengths}}}}};
    const auto at = [&](double x, double y, double z) {
        return json{x * place.unit, y * place.unit, z * place.unit};
    };
    file.add("nodes", {{"translation", at(2, 3, 2)},
                       {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    file.add("nodes", {{"rotation", {-0.6, 0, 0, 0.8}},
                       {"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}});
    file.add("nodes", {{"translation", at(0, 0, 6)}, {"camera", 0}});
    for (int i = 1; i < place.uses; ++i)
        file.add("nodes", {{"mesh", 0}, {"translation", at(-1.5 * i, 0.5, 0)}});
    json children = json::array();
    for (size_t i = 0; i < file.json["nodes"].size(); ++i) children.push_back(i);
    const double s = place.node_scale;
    file.add("nodes",
             {{"children", children}, {"translation", place.translation}, {"scale", {s, s, s}}});
    return write_file(test_folder() / (name + ".glb"), file.glb());
}

struct Picture {
    Film film;
    PictureMetadata metadata;
};

Picture render_file(const std::string& asset, const ViewOptions& view = {}) {
    RenderCommand command;
    command.asset = asset;
    command.view = view;
    command.light.env = "none";
    command.light.background = Background::transparent;
    command.settings.width = command.settings.height = 32;
    command.settings.samples = 4;
    command.run.threads = 1;
    command.output.pictures = {asset + ".exr"};
    render_asset(command);
    Picture picture;
    picture.film = read_exr(command.output.pictures[0], &picture.metadata);
    return picture;
}

/// The channels of one layer are those of `right`, bit by bit, times `factor`.
void expect_equal(const Film& film, const Film& right, std::initializer_list<const char*> names,
                  float factor = 1) {
    for (const char* name : names) {
        SCOPED_TRACE(name);
        const auto &a = film.find(name)->values, &b = right.find(name)->values;
        ASSERT_EQ(a.size(), b.size());
        size_t different = 0;
        for (size_t i = 0; i < a.size(); ++i) different += a[i] != b[i] * factor;
        EXPECT_EQ(different, 0u);
    }
}

const std::initializer_list<const char*> colors = {"R", "G", "B", "A", "normal.X", "normal.Y"};

/// Some part of the ball is lit, so that equal pictures are not equally black.
void expect_lit(const Film& film) {
    const auto& g = film.find("G")->values;
    EXPECT_GT(std::ranges::count_if(g, [](float v) { return v > 0.1f; }), 100);
}

// On multiples of the frame's grid nothing is rounded otherwise than at the origin.
TEST(FarAndTiny, AFarAssetLooksAsAtTheOriginAndItsPositionsAreRelative) {
    for (const int uses : {1, 3}) {
        const Picture right = render_file(write_asset({.uses = uses}, "near"));
        expect_lit(right.film);
        EXPECT_FALSE(right.metadata.origin);
        const Picture far = render_file(
            write_asset({.translation = {4198400, 1171456, -4646912}, .uses = uses}, "far"));
        expect_equal(far.film, right.film, colors);
        ASSERT_TRUE(far.metadata.origin);
        EXPECT_EQ(*far.metadata.origin, Vec3d(4198400, 1171456, -4646912));
        expect_equal(far.film, right.film, {"position.X", "position.Y", "position.Z", "depth.Z"});
        EXPECT_EQ(far.metadata.world_to_camera, right.metadata.world_to_camera);
        EXPECT_EQ(far.metadata.world_to_ndc, right.metadata.world_to_ndc);
    }
}

TEST(FarAndTiny, AFreeCameraIsPlacedInDouble) {
    const auto view_of = [](const Vec3d& asset) {
        ViewOptions view;
        view.look_from = asset + Vec3d(1.0625, 2.5, 5);
        view.look_at = asset + Vec3d(0, 0.25, 0);
        return view;
    };
    const Picture right = render_file(write_asset({}, "near"), view_of({0, 0, 0}));
    expect_lit(right.film);
    const Vec3d there(4198400, 1171456, -4646912);
    const std::string asset = write_asset({.translation = {there.x, there.y, there.z}}, "far");
    expect_equal(render_file(asset, view_of(there)).film, right.film, colors);
}

// All numbers differ by a power of two, and so do all results: lengths are reported in world units.
TEST(FarAndTiny, ATinyAssetLooksAsAtUnitScale) {
    constexpr double tiny = 0x1p-50;
    for (const int uses : {1, 3}) {
        SCOPED_TRACE(uses);
        const Picture right = render_file(write_asset({.uses = uses}, "unit"));
        for (const Place& place :
             {Place{.unit = tiny, .uses = uses}, Place{.node_scale = tiny, .uses = uses},
              Place{.node_scale = 0x1p-70, .unit = 0x1p20, .uses = uses}}) {
            const Picture picture = render_file(write_asset(place, "tiny"));
            expect_equal(picture.film, right.film, colors);
            expect_equal(picture.film, right.film,
                         {"position.X", "position.Y", "position.Z", "depth.Z"}, float(tiny));
        }
    }
}

TEST(FarAndTiny, AHugeAssetLooksAsAtUnitScale) {
    const Picture right = render_file(write_asset({}, "unit"));
    const Picture huge = render_file(write_asset({.node_scale = 0x1p44}, "huge"));
    expect_equal(huge.film, right.film, {"A"});
    const auto &a = huge.film.find("G")->values, &b = right.film.find("G")->values;
    for (size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-4f);
}

const fs::path reported = fs::path(SIGHTLINE_SOURCE_DIR) / ".." / "shared" / "corpus" / "reported";

/// The mean of alpha: the share of the picture that the asset covers.
double coverage(const fs::path& file) {
    const fs::path copy = test_folder() / file.filename();
    fs::copy_file(file, copy, fs::copy_options::overwrite_existing);
    const Picture picture = render_file(copy.string());
    const auto& alpha = picture.film.find("A")->values;
    double sum = 0;
    for (const float a : alpha) sum += double(a);
    return sum / double(alpha.size());
}

TEST(FarAndTiny, TheReportedBallsCoverWhatABallCovers) {
    if (!fs::exists(reported)) GTEST_SKIP() << "no corpus beside the checkout";
    for (const char* file : {"geo-offset/at_origin.glb", "geo-offset/ecef.glb",
                             "geo-offset/mercator_z17.glb", "tiny-model/radius_1e-15.glb"})
        // 48 meridians within 0.9 of the picture: pi/4 0.9² sin(2pi/48) / (2pi/48).
        EXPECT_NEAR(coverage(reported / file), 0.6344, 0.003) << file;  // 4 samples a pixel
}

}  // namespace
}  // namespace sightline
