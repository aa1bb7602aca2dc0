// One asset in memory for several pictures.
#include "core/files.h"
#include "image/compare.h"
#include "output/render_asset.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

#include <filesystem>

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

// One sample a pixel has the widest footprints, so that most levels are left out.
TEST(Asset, OfTheCorpusIsDrawnFromReducedTexturesAsFromWholeOnes) {
    const fs::path corpus = fs::path(SIGHTLINE_SOURCE_DIR) / ".." / "shared" / "corpus" / "valid";
    if (!fs::exists(corpus)) GTEST_SKIP() << "no corpus beside the checkout";
    int reduced = 0;
    for (const auto& entry : fs::recursive_directory_iterator(corpus)) {
        const std::string extension = entry.path().extension().string();
        if (extension != ".gltf" && extension != ".glb") continue;
        SCOPED_TRACE(entry.path());
        RenderCommand command = command_for(entry.path().string(), "", "");
        command.settings.width = command.settings.height = 48;
        command.output.pictures.clear();
        command.output.preview = true;
        const AssetResult picture = render_asset(command);
        EXPECT_EQ(picture.finer_lookups, 0u);
        if (picture.bytes.images == picture.bytes.whole_images) continue;
        ++reduced;
        command.settings.full_textures = true;
        const AssetResult whole = render_asset(command);
        EXPECT_LE(compare_images(whole.preview, picture.preview).flip_mean, 0.005);
    }
    EXPECT_GT(reduced, 0);
}

}  // namespace
}  // namespace sightline
