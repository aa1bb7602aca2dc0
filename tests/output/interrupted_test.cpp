#include "core/error.h"
#include "output/render_asset.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

#include <fstream>

namespace sightline {
namespace {

// Stops in the middle: Render.AStopAfterTheFirstBand…, Render.ACheckpointOfAStoppedRender….
TEST(Interrupted, ARenderStoppedBeforeItsFirstTileKeepsTheOldPicture) {
    const auto picture = test_folder() / "picture.exr";
    std::ofstream(picture) << "an older picture";
    RenderCommand command;
    command.asset = SIGHTLINE_SOURCE_DIR "/scenes/whitted.gltf";
    command.output.pictures = {picture.string()};
    command.settings.width = command.settings.height = 32;
    std::stop_source stop;
    stop.request_stop();
    EXPECT_THROW(render_asset(command, stop.get_token()), Error);
    std::string kept;
    std::getline(std::ifstream(picture), kept);
    EXPECT_EQ(kept, "an older picture");
}

}  // namespace
}  // namespace sightline
