#include "core/error.h"
#include "core/files.h"
#include "scene/gltf/load.h"
#include "support/gltf.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <random>

namespace sightline {
namespace {

namespace fs = std::filesystem;

const fs::path valid_files = SIGHTLINE_SOURCE_DIR "/../shared/corpus/valid";
const fs::path duck = valid_files / "DRx3D_glTF-Sample-Assets/Models/Duck/glTF-Draco/Duck.gltf";
const fs::path box =
    valid_files / "donmccurdy_glTF-Transform/packages/extensions/test/in/BoxMeshopt.gltf";

Scene load(const fs::path& path, bool strict = true) {
    LoadOptions options;
    options.strict = strict;
    options.decode_images = false;
    return load_gltf(path, options);
}

std::string read_text(const fs::path& path) {
    const auto bytes = read_file(path, 1 << 30);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A modifiable copy of an asset and its .bin.
class Compression : public testing::Test {
  protected:
    void copy(const fs::path& asset) {
        if (!fs::exists(asset)) GTEST_SKIP() << "no corpus at " << valid_files;
        fs::create_directories(folder_);
        json_ = read_text(asset);
        bin_name_ = asset.stem().string() + ".bin";
        bin_ = read_text(asset.parent_path() / bin_name_);
    }
    void replace(const std::string& from, const std::string& to) {
        const size_t at = json_.find(from);
        ASSERT_NE(at, std::string::npos) << from;
        json_.replace(at, from.size(), to);
    }
    Scene load_copy(bool strict = true) {
        std::ofstream(folder_ / "a.gltf") << json_;
        std::ofstream(folder_ / bin_name_) << bin_;
        return load(folder_ / "a.gltf", strict);
    }
    void expect_error(const std::string& part) {
        try {
            load_copy();
            ADD_FAILURE() << "loads, instead of: " << part;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
        }
    }
    /// Damaged streams give an error or valid data.
    void damage_at_random(int times) {
        const std::string whole = bin_;
        std::mt19937 random(3);
        for (int i = 0; i < times; ++i) {
            bin_ = whole;
            for (int k = 0; k < 1 + i % 3; ++k) bin_[random() % bin_.size()] ^= char(random());
            try {
                load_copy(i % 2 == 0);
            } catch (const Error& error) {
                EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
            }
        }
    }

    fs::path folder_ = test_folder();
    std::string json_, bin_, bin_name_;
};

TEST_F(Compression, DracoGeometryHasTheFilesBounds) {
    copy(duck);
    if (IsSkipped()) return;
    const Scene scene = load(duck);
    ASSERT_EQ(scene.meshes.size(), 1u);
    const Mesh& mesh = scene.meshes[0];
    EXPECT_EQ(mesh.triangles.size(), 4212u);
    EXPECT_EQ(mesh.positions.size(), 2399u);
    EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
    EXPECT_EQ(mesh.texcoords.at(0).size(), mesh.positions.size());
    EXPECT_NEAR(scene.bounds.size().y, (164.090f - 9.8485f) * 0.01f, 2e-3f);
    Box3 uv;
    for (const Vec2& p : mesh.texcoords[0]) uv.extendBy(Vec3(p.x, p.y, 0));
    EXPECT_NEAR(uv.max.x, 0.98461f, 1e-3f);
    EXPECT_NEAR(uv.min.y, 0.01902f, 1e-3f);
    EXPECT_TRUE(scene.warnings.empty());
}

TEST_F(Compression, DracoRejectsDamagedStreams) {
    copy(duck);
    if (IsSkipped()) return;
    const std::string whole = bin_;
    bin_[0] = 'X';
    expect_error("bufferView: is not a Draco mesh");
    bin_ = whole;
    replace("\"POSITION\": 1,", "\"POSITION\": 77,");
    expect_error("attributes.POSITION: refers to an attribute that is not in the stream");
    replace("\"POSITION\": 77,", "\"POSITION\": 2,");
    expect_error("attributes.POSITION: has 2 components, but the accessor 3");
}

TEST_F(Compression, DracoRejectsCountsThatItsBytesCannotHold) {
    copy(duck);
    if (IsSkipped()) return;
    // Sequential: faces, points. Edgebreaker: traversal, vertices, faces, attributes, symbols,
    // split symbols.
    const std::string huge = "\xff\xff\xff\xff\x0f", head = "DRACO\2\2\1";
    for (const std::string& counts :
         {std::string("\0\0\0", 3) + huge + "\1", std::string("\0\0\0", 3) + "\1" + huge,
          std::string("\1\0\0\0\1", 5) + huge + std::string("\0\0\0", 3),
          std::string("\1\0\0\0\1\1\0\1", 8) + huge}) {
        bin_.replace(0, head.size() + counts.size(), head + counts);
        expect_error("cannot come from 10366 bytes");
    }
}

TEST_F(Compression, DracoSurvivesRandomDamage) {
    copy(duck);
    if (!IsSkipped()) damage_at_random(20);
}

TEST_F(Compression, MeshoptGeometryIsTheBox) {
    copy(box);
    if (IsSkipped()) return;
    const Scene scene = load(box);
    ASSERT_EQ(scene.meshes.size(), 1u);
    const Mesh& mesh = scene.meshes[0];
    EXPECT_EQ(mesh.triangles.size(), 12u);
    EXPECT_EQ(mesh.positions.size(), 24u);
    for (size_t v = 0; v < mesh.positions.size(); ++v) {
        // Each corner of a cube, each normal along the axis of its face.
        const Vec3 p = mesh.positions[v], n = mesh.normals[v], s = scene.bounds.size() * 0.5f;
        const Vec3 from_centre = p - scene.bounds.center();
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(std::abs(from_centre[i]), s[i], 1e-4f);
        EXPECT_NEAR(std::abs(n.x) + std::abs(n.y) + std::abs(n.z), 1, 0.02f);
        EXPECT_GT(dot(n, from_centre), 0.4f);
    }
}

/// Up to 16 elements of `stride` bytes as a stream of version 0: for each byte of an element the
/// zigzag differences between neighbours, stored as they are, and then the first element.
std::vector<uint8_t> meshopt_attributes(const std::vector<uint8_t>& elements, size_t stride) {
    std::vector<uint8_t> stream{0xa0};
    for (size_t byte = 0; byte < stride; ++byte) {
        stream.push_back(3);  // one group of 16 differences with 8 bits each
        for (size_t i = 0; i < 16; ++i) {
            const size_t at = std::min(i * stride + byte, elements.size() - stride + byte);
            const uint8_t before = elements[i == 0 ? byte : std::min(at, (i - 1) * stride + byte)];
            const auto difference = static_cast<int8_t>(elements[at] - before);
            stream.push_back(static_cast<uint8_t>(difference << 1 ^ difference >> 7));
        }
    }
    stream.resize(stream.size() + 32 - stride);
    stream.insert(stream.end(), elements.begin(), elements.begin() + std::ptrdiff_t(stride));
    return stream;
}

TEST(CompressionByMeshopt, IsReadByTheNameOfEitherExtension) {
    const std::vector<float> positions{0, 0, 0, 2, 0, 0, 0, 3, -1};
    std::vector<uint8_t> elements(36);
    std::memcpy(elements.data(), positions.data(), 36);
    for (const std::string name : {"KHR_meshopt_compression", "EXT_meshopt_compression"}) {
        SCOPED_TRACE(name);
        GltfBuilder file;
        const size_t data = file.view(meshopt_attributes(elements, 12));
        nlohmann::json view = file.json["bufferViews"][data], stream = view;
        stream.update({{"byteStride", 12}, {"count", 3}, {"mode", "ATTRIBUTES"}});
        view.update({{"byteLength", 36}, {"extensions", {{name, stream}}}});
        const size_t accessor = file.accessor(file.add("bufferViews", view), 5126, "VEC3", 3);
        file.mesh_node({{"attributes", {{"POSITION", accessor}}}});
        file.json["extensionsRequired"] = {name};
        const Scene scene = load(file.save());
        ASSERT_EQ(scene.meshes.size(), 1u);
        EXPECT_EQ(scene.meshes[0].positions,
                  (std::vector{Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(0, 3, -1)}));
        file.bin[0] = 'X';
        EXPECT_TRUE(fails(file.save(), "bufferViews[1].extensions." + name + ": is damaged"));
    }
}

TEST_F(Compression, MeshoptRejectsInconsistentSizes) {
    copy(box);
    if (IsSkipped()) return;
    const std::string whole = json_;
    const std::string place = "bufferViews[0].extensions.EXT_meshopt_compression";
    const std::string count = "\"byteStride\": 2,\n          \"count\": ";
    replace(count + "36", count + "36000000000");
    expect_error(place + ".count: 36000000000 elements cannot come from 29 bytes");
    json_ = whole;
    replace(count + "36", count + "33");
    expect_error(place + ".count: 33 elements of 2 bytes do not fill the view's 72");
    json_ = whole;
    replace("\"byteStride\": 2,", "\"byteStride\": 3,");
    expect_error(place + ".byteStride: cannot be 3");
    json_ = whole;
    replace("\"mode\": \"TRIANGLES\"", "\"mode\": \"ATTRIBUTES\"");
    expect_error(place + ".byteStride: cannot be 2");
    json_ = whole;
    replace("OCTAHEDRAL", "QUATERNION");
    expect_error("bufferViews[1].extensions.EXT_meshopt_compression.filter: QUATERNION does not");
    json_ = whole;
    replace("\"byteLength\": 29", "\"byteLength\": 290");
    expect_error(place + ": bytes 0 to 290 are not all in a buffer of 208");
    json_ = whole;
    bin_[0] = 'X';
    expect_error(place + ": is damaged");
}

TEST_F(Compression, MeshoptSurvivesRandomDamage) {
    copy(box);
    if (!IsSkipped()) damage_at_random(100);
}

}  // namespace
}  // namespace sightline
