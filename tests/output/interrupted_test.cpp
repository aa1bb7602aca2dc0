#include "core/error.h"
#include "output/asset.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

#include <fstream>

namespace sightline {
namespace {

// Stops in the middle: Render.AStopAfterTheFirstBand…, Render.ACheckpointOfAStoppedRender….
TEST(Interrupted, ARenderStoppedBeforeItsFirstTileKeepsTheOldPicture) {
    const auto picture = test_folder() / "picture.exr";
    std::ofstream(picture) << "an older picture";
    AssetOptions options;
    options.path = SIGHTLINE_SOURCE_DIR "/scenes/whitted.gltf";
    options.outputs = {picture.string()};
    options.width = options.height = 32;
    std::stop_source stop;
    stop.request_stop();
    EXPECT_THROW(render_asset(options, stop.get_token()), Error);
    std::string kept;
    std::getline(std::ifstream(picture), kept);
    EXPECT_EQ(kept, "an older picture");
}

}  // namespace
}  // namespace sightline
