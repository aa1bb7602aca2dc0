// One asset in memory for several pictures.
#include "core/error.h"
#include "core/files.h"
#include "image/compare.h"
#include "output/render_asset.h"
#include "render/texture_levels.h"
#include "support/gltf.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <future>
#include <limits>
#include <optional>

namespace sightline {
namespace {

namespace fs = std::filesystem;

const std::string scenes = SIGHTLINE_SOURCE_DIR "/scenes/";

RenderCommand command_for(const std::string& asset, const std::string& camera,
                          const std::string& picture) {
    RenderCommand command;
    command.asset = asset;
    command.view.camera = camera;
    command.settings.width = command.settings.height = 24;
    command.settings.samples = 1;
    command.output.pictures = {picture};
    return command;
}

TEST(Asset, ItsPicturesHaveTheBitsOfPicturesRenderedAlone) {
    const std::string folder = test_folder().string() + "/";
    const std::string file = scenes + "table.gltf";
    Asset asset(command_for(file, "", folder + "a.png"));
    for (const char* camera : {"fit", "front", "", "top", "fit"}) {
        const RenderCommand shared = command_for(file, camera, folder + "shared.png");
        ASSERT_TRUE(asset.serves(shared));
        asset.render(shared);
        render_asset(command_for(file, camera, folder + "alone.png"));
        EXPECT_EQ(read_file(folder + "shared.png", 1 << 20),
                  read_file(folder + "alone.png", 1 << 20))
            << camera;
    }
}

TEST(Asset, ItsPicturesShareTheirBackdropOnlyWhereItIsTheSame) {
    const std::string folder = test_folder().string() + "/";
    const auto command_of = [&](GroundKind ground, float blur, const std::string& picture) {
        RenderCommand command = command_for(scenes + "table.gltf", "iso", folder + picture);
        command.light.env = "studio";
        command.light.background = Background::environment;
        command.light.env_blur = blur;
        command.ground.kind = ground;
        command.ground.color = {0.6f, 0.2f, 0.1f};
        return command;
    };
    Asset asset(command_of(GroundKind::shadow, 0, "a.png"));
    for (const GroundKind ground : {GroundKind::shadow, GroundKind::matte, GroundKind::nothing})
        for (const float blur : {0.0f, 20.0f, 20.0f, 0.0f}) {
            const RenderCommand shared = command_of(ground, blur, "shared.png");
            ASSERT_TRUE(asset.serves(shared));
            asset.render(shared);
            render_asset(command_of(ground, blur, "alone.png"));
            EXPECT_EQ(read_file(folder + "shared.png", 1 << 20),
                      read_file(folder + "alone.png", 1 << 20))
                << static_cast<int>(ground) << " " << blur;
        }
}

TEST(Asset, IsReadAndBuiltOnce) {
    const std::string folder = test_folder().string() + "/";
    const RenderCommand command = command_for(scenes + "table.gltf", "fit", folder + "a.png");
    Asset asset(command);
    const AssetResult first = asset.render(command), second = asset.render(command);
    EXPECT_GT(first.seconds.load(), 0);
    EXPECT_GT(first.bytes.files, 0u);
    EXPECT_EQ(second.seconds.load(), 0);
    EXPECT_EQ(second.bytes.files, 0u);
    EXPECT_EQ(first.inputs.size(), second.inputs.size());
}

TEST(Asset, ServesNothingElse) {
    const std::string folder = test_folder().string() + "/";
    const RenderCommand command = command_for(scenes + "table.gltf", "fit", folder + "a.png");
    const Asset asset(command);
    RenderCommand other = command;
    other.settings.samples = 4;
    other.view.orbit = 30;
    EXPECT_TRUE(asset.serves(other));
    other = command;
    other.asset = scenes + "whitted.gltf";
    EXPECT_FALSE(asset.serves(other));
    other = command;
    other.load.strict = true;
    EXPECT_FALSE(asset.serves(other));
    other = command;
    other.light.env = "none";
    EXPECT_FALSE(asset.serves(other));
}

TEST(Asset, IsReadAgainOnceItsFileHasChanged) {
    const std::string file = test_folder().string() + "/changing.gltf";
    fs::copy_file(scenes + "table.gltf", file, fs::copy_options::overwrite_existing);
    const auto long_ago = fs::file_time_type::clock::now() - std::chrono::hours(1);
    fs::last_write_time(file, long_ago);
    const RenderCommand command = command_for(file, "fit", test_folder().string() + "/a.png");
    // The time of the last change of the inode cannot be set: a fresh file is never kept.
    EXPECT_FALSE(Asset(command).serves(command));
}

/// A triangle's primitive with a red and a green pixel on it, before `z`.
nlohmann::json textured_triangle(GltfBuilder& file, float z, size_t material) {
    return {{"attributes",
             {{"POSITION", file.floats({0, 0, z, 1, 0, z, 0, 1, z}, "VEC3")},
              {"TEXCOORD_0", file.floats({0, 0, 1, 0, 0, 1}, "VEC2")}}},
            {"material", material}};
}

void animate(GltfBuilder& file, size_t node, const char* path, const std::vector<float>& values,
             const char* type, const char* how = "LINEAR") {
    nlohmann::json& animation = file.json["animations"][0];
    const size_t times = file.floats({0, 1}, "SCALAR");
    animation["samplers"].push_back(
        {{"input", times}, {"output", file.floats(values, type)}, {"interpolation", how}});
    animation["channels"].push_back({{"sampler", animation["samplers"].size() - 1},
                                     {"target", {{"node", node}, {"path", path}}}});
}

/// Everything that can move, and what stays: a node, two instances, a skin, a morphed mesh, a lamp
/// that leaves the scene in the dark, and meshes that show and hide a texture, one of which is
/// missing; at time 1, a node has no finite matrix.
std::string moving_file() {
    const std::string png =
        "iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAIAAAB7QOjdAAAAD0lEQVR4nGP4z8DA8J8BAAf/Af8Bf4mn"
        "AAAAAElFTkSuQmCC";
    GltfBuilder file;
    file.json["images"] = {{{"uri", "data:;base64," + png}}, {{"uri", "missing.png"}}};
    file.json["textures"] = {{{"source", 0}}, {{"source", 1}}};
    for (const int texture : {0, 1})
        file.add("materials",
                 {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}},
                  {"doubleSided", true}});
    file.json["materials"][0]["emissiveFactor"] = {1, 0.5, 0.25};
    const size_t still = file.mesh_node(textured_triangle(file, -0.5f, 0));
    file.json["nodes"][still]["scale"] = {3, 2, 1};
    for (const float x : {0.0f, 1.0f}) {
        const size_t node = file.mesh_node(textured_triangle(file, 0.1f + x, size_t(x)));
        animate(file, node, "translation", {x, 0, 0, x, 1, 0}, "VEC3");
        if (x == 1) animate(file, node, "scale", {0, 0, 0, 1, 1, 1}, "VEC3", "STEP");
    }
    for (const float y : {1.0f, 2.0f}) {
        const size_t instance = file.add("nodes", {{"mesh", 0}, {"translation", {-1, y, 0}}});
        if (y == 1) animate(file, instance, "scale", {1, 1, 1, 2, 2, 2}, "VEC3");
    }
    nlohmann::json skinned = textured_triangle(file, 0.2f, 0);
    skinned["attributes"]["JOINTS_0"] =
        file.accessor(file.view<uint8_t>(std::vector<uint8_t>(12, 0)), 5121, "VEC4", 3);
    skinned["attributes"]["WEIGHTS_0"] = file.floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4");
    const size_t puppet = file.mesh_node(skinned);
    const size_t joint = file.add("nodes", {{"name", "joint"}});
    file.json["nodes"][puppet]["skin"] = 0;
    file.json["skins"] = {{{"joints", {joint}}}};
    animate(file, joint, "rotation", {0, 0, 0, 1, 0, 0, 1, 0}, "VEC4");
    nlohmann::json morphed = textured_triangle(file, 0.3f, 0);
    morphed["targets"] = {{{"POSITION", file.floats({1, 0, 0, 1, 0, 0, 1, 1, 0}, "VEC3")}}};
    animate(file, file.mesh_node(morphed), "weights", {0, 1}, "SCALAR");
    const size_t lost = file.triangle();
    file.json["nodes"][lost]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    animate(file, lost, "scale", {1, 1, 1, std::numeric_limits<float>::infinity(), 1, 1}, "VEC3",
            "STEP");
    file.json["extensionsUsed"] = {"KHR_lights_punctual"};
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}, {"intensity", 100}}};
    const size_t lamp = file.add(
        "nodes",
        {{"translation", {0, 0, 3}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    animate(file, lamp, "translation", {0, 0, 3, 0, 0, 3000}, "VEC3", "STEP");
    return file.save();
}

TEST(Asset, PosedAtAnotherTimeIsThatReadAtThatTime) {
    const std::string folder = test_folder().string() + "/";
    const auto at = [&](const std::string& file, float time, const std::string& picture) {
        RenderCommand command = command_for(file, "", folder + picture);
        command.load.time = time;
        return command;
    };
    std::vector<std::string> files = {moving_file()};
    const std::string models =
        SIGHTLINE_SOURCE_DIR "/../shared/corpus/valid/DRx3D_glTF-Sample-Assets/Models/";
    for (const char* model :
         {"CesiumMan/glTF-Binary/CesiumMan.glb", "SimpleMorph/glTF/SimpleMorph.gltf"})
        if (fs::exists(models + model)) files.push_back(models + model);
    for (const std::string& file : files) {
        Asset asset(at(file, 0, "a.png"));
        bool is_first = true;
        for (const float time : {0.0f, 0.25f, 1.0f, 0.75f, 0.0f}) {
            SCOPED_TRACE(file + " at " + std::to_string(time));
            ASSERT_TRUE(asset.has_loaded(at(file, time, "posed.png")));
            const AssetResult posed = asset.render(at(file, time, "posed.png"));
            const AssetResult alone = render_asset(at(file, time, "alone.png"));
            const FileBytes picture = read_file(folder + "posed.png", 1 << 20);
            EXPECT_EQ(picture, read_file(folder + "alone.png", 1 << 20));
            EXPECT_EQ(posed.warnings, alone.warnings);
            EXPECT_EQ(posed.fault_count, alone.fault_count);
            EXPECT_EQ(posed.seconds.parse > 0, is_first);
            is_first = false;
        }
    }
}

TEST(Asset, IsNotNeededByAPictureThatIsWrittenLater) {
    const std::string folder = test_folder().string() + "/", file = moving_file();
    const auto at = [&](float time, const std::string& name) {
        RenderCommand command = command_for(file, "", folder + name + ".png");
        command.output.pictures.push_back(folder + name + ".exr");
        command.output.data = {"depth", "object"};
        command.load.time = time;
        return command;
    };
    const std::vector<std::string> endings = {".png", ".exr", ".depth.png", ".object.png"};
    std::optional<RenderedPicture> early;
    {
        Asset asset(at(0, "later"));
        early.emplace(asset.render_unwritten(at(0, "later")));
        asset.render(at(0.5f, "between"));
    }
    for (const std::string& ending : endings) EXPECT_FALSE(fs::exists(folder + "later" + ending));
    const AssetResult later = early->write(), alone = render_asset(at(0, "alone"));
    EXPECT_EQ(later.data_scales.size(), 2u);
    EXPECT_EQ(later.warnings, alone.warnings);
    for (const std::string& ending : endings)
        EXPECT_EQ(read_file(folder + "later" + ending, 1 << 20),
                  read_file(folder + "alone" + ending, 1 << 20))
            << ending;
}

TEST(Asset, RendersWhileThePictureBeforeIsWritten) {
    const std::string folder = test_folder().string() + "/";
    const RenderCommand first = command_for(scenes + "table.gltf", "fit", folder + "first.png");
    const RenderCommand second = command_for(scenes + "table.gltf", "top", folder + "second.png");
    Asset asset(first);
    constexpr std::chrono::seconds limit(20);
    std::promise<void> begun, rendered;
    bool has_waited = false;
    std::future<AssetResult> writing =
        write_beside(asset.render_unwritten(first), [&](const AssetResult& result) {
            EXPECT_GT(result.seconds.write, 0);
            begun.set_value();
            has_waited = rendered.get_future().wait_for(limit) == std::future_status::ready;
        });
    EXPECT_EQ(begun.get_future().wait_for(limit), std::future_status::ready);
    asset.render(second);
    rendered.set_value();
    writing.get();
    EXPECT_TRUE(has_waited);
}

TEST(Asset, TellsThatAPictureCannotBeWrittenWhenThatIsTaken) {
    const fs::path folder = fs::path(test_folder().string()) / "gone";
    fs::create_directory(folder);
    const RenderCommand command = command_for(scenes + "table.gltf", "fit", folder / "a.png");
    Asset asset(command);
    RenderedPicture picture = asset.render_unwritten(command);
    fs::remove(folder);
    std::future<AssetResult> writing = write_beside(std::move(picture));
    EXPECT_THROW(writing.get(), Error);
}

// One sample a pixel has the widest footprints, so that most levels are left out.
TEST(Asset, OfTheCorpusIsDrawnFromReducedTexturesAsFromWholeOnes) {
    const fs::path corpus = fs::path(SIGHTLINE_SOURCE_DIR) / ".." / "shared" / "corpus" / "valid";
    if (!fs::exists(corpus)) GTEST_SKIP() << "no corpus beside the checkout";
    int reduced = 0;
    uint64_t finer = 0, rays = 0;
    for (const auto& entry : fs::recursive_directory_iterator(corpus)) {
        const std::string extension = entry.path().extension().string();
        if (extension != ".gltf" && extension != ".glb") continue;
        SCOPED_TRACE(entry.path());
        RenderCommand command = command_for(entry.path().string(), "", "");
        command.settings.width = command.settings.height = 48;
        command.output.pictures.clear();
        command.output.preview = true;
        const AssetResult picture = render_asset(command);
        finer += picture.finer_lookups;
        for (const uint64_t count : picture.picture.counters.rays) rays += count;
        if (picture.bytes.images == picture.bytes.whole_images) continue;
        ++reduced;
        command.settings.full_textures = true;
        const AssetResult whole = render_asset(command);
        EXPECT_LE(compare_images(whole.preview, picture.preview).flip_mean, 0.005);
    }
    EXPECT_GT(reduced, 0);
    EXPECT_LE(double(finer), TextureLevels::ignored_share * double(rays));
}

}  // namespace
}  // namespace sightline
