// What compressed data may expand to.
#include "support/gltf.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

// Views of 4096 bytes, each decoded from the same 97 bytes: a stream of zeros by meshoptimizer.
std::string views_of_one_stream(int count) {
    GltfBuilder file;
    file.triangle();
    std::vector<uint8_t> stream(97, 0);
    stream[0] = 0xa0;
    const size_t offset = file.bin.size();
    file.bin.append(stream.begin(), stream.end());
    for (int i = 0; i < count; ++i) {
        file.add("bufferViews", {{"buffer", 0},
                                 {"byteLength", 4096},
                                 {"extensions",
                                  {{"EXT_meshopt_compression",
                                    {{"buffer", 0},
                                     {"byteOffset", offset},
                                     {"byteLength", stream.size()},
                                     {"byteStride", 4},
                                     {"count", 1024},
                                     {"mode", "ATTRIBUTES"}}}}}});
    }
    return file.save();
}

TEST(CompressionLimits, ManyViewsOfTheSameStreamExhaustTheBudget) {
    const std::string path = views_of_one_stream(10);
    LoadOptions options;
    options.max_accessor_values = 10 * 1024 + 9;  // and the triangle's
    EXPECT_EQ(load_gltf(path, options).instances.size(), 1u);
    options.max_accessor_values = 10 * 1024 - 1;
    EXPECT_TRUE(fails(path, "bufferViews[10]", options));
}

}  // namespace
}  // namespace sightline
