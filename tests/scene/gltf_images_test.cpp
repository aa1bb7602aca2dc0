// Which images are read, how often, and what takes the place of those that cannot be.
#include "image/png.h"
#include "support/gltf.h"
#include "support/png.h"

#include <unistd.h>

#include <functional>
#include <thread>

namespace sightline {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

std::string text_of(const Bytes& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// A triangle with texture coordinates whose material is `material`; textures[i] shows images[i].
GltfBuilder textured(const json& material, const json& images) {
    GltfBuilder file;
    const json attributes = {{"POSITION", file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3")},
                             {"NORMAL", file.floats({0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3")},
                             {"TEXCOORD_0", file.floats({0, 0, 1, 0, 0, 1}, "VEC2")}};
    file.mesh_node({{"attributes", attributes}, {"material", 0}});
    file.json["materials"] = json::array({material});
    file.json["images"] = images;
    for (size_t i = 0; i < images.size(); ++i) file.add("textures", {{"source", i}});
    return file;
}

json base_color(size_t texture) {
    return {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}};
}

json uris(std::initializer_list<const char*> names) {
    json images = json::array();
    for (const char* name : names) images.push_back({{"uri", name}});
    return images;
}

std::string fault_of(const Scene& scene) {
    return scene.faults.empty() ? "" : scene.faults[0].key + " " + scene.faults[0].place;
}

LoadOptions strict() {
    LoadOptions options;
    options.strict = true;
    return options;
}

TEST(GltfImages, AMissingImageCostsTheTextureAlone) {
    GltfBuilder file = textured(base_color(0), uris({"missing.png"}));
    const Scene scene = load_gltf(file.save());
    EXPECT_EQ(scene.fault_count, 1u);
    EXPECT_EQ(fault_of(scene), "missing-texture images[0].uri");
    EXPECT_FALSE(scene.materials.at(1).base_color_texture);
    EXPECT_EQ(scene.instances.size(), 1u);
    EXPECT_TRUE(
        fails(file.save(), "images[0].uri: 'missing.png' is not an existing file", strict()));
}

TEST(GltfImages, AnImageWithoutUriOrViewIsMissing) {
    GltfBuilder file = textured(base_color(0), json::array({json::object()}));
    EXPECT_EQ(fault_of(load_gltf(file.save())), "missing-texture images[0]");
    EXPECT_TRUE(fails(file.save(), "images[0]: has neither uri nor bufferView", strict()));
}

TEST(GltfImages, AnUnreadableImageCostsTheTextureAlone) {
    const Bytes whole = plain_png(4, 200);
    for (const Bytes& content : {bytes({'n', 'o', ' ', 'p', 'i', 'c', 't', 'u', 'r', 'e'}),
                                 Bytes(whole.begin(), whole.begin() + 60)}) {
        GltfBuilder file = textured(base_color(0), {});
        file.json["images"] = json::array({{{"bufferView", file.view(content)}}});
        file.json["textures"] = json::array({{{"source", 0}}});
        const Scene scene = load_gltf(file.save());
        EXPECT_EQ(fault_of(scene), "unreadable-texture images[0]");
        EXPECT_FALSE(scene.materials.at(1).base_color_texture);
        EXPECT_TRUE(fails(file.save(), "images[0]: ", strict()));
    }
}

TEST(GltfImages, ACheckerStandsForALostBaseColourOnly) {
    json material = base_color(0);
    material["normalTexture"] = {{"index", 0}};
    GltfBuilder file = textured(material, uris({"missing.png"}));
    LoadOptions options;
    options.missing_texture = MissingTexture::checker;
    const Scene scene = load_gltf(file.save(), options);
    ASSERT_TRUE(scene.materials.at(1).base_color_texture);
    EXPECT_FALSE(scene.materials[1].normal_texture);
    const std::vector<uint8_t>& texels = scene.images.at(0).bytes;
    ASSERT_EQ(texels.size(), 64u * 64 * 3);
    EXPECT_EQ(std::vector(texels.begin(), texels.begin() + 3), (std::vector<uint8_t>{255, 0, 255}));
    EXPECT_EQ(std::vector(texels.begin() + 24, texels.begin() + 27), std::vector<uint8_t>(3));
}

TEST(GltfImages, DamageThatCostsNoPixelIsAFault) {
    Bytes without_end = plain_png(4, 200);
    without_end.resize(without_end.size() - 12);
    Bytes wrong_sum = plain_png(4, 200);
    wrong_sum.resize(wrong_sum.size() - 12);
    append_chunk(wrong_sum, "tEXt", bytes({'a', 0, 'b'}));
    wrong_sum.back() ^= std::byte{1};
    append_chunk(wrong_sum, "IEND", {});
    for (const auto& [content, fault] : {std::pair(without_end, "png-end images[0]"),
                                         std::pair(wrong_sum, "png-checksum images[0]")}) {
        GltfBuilder file = textured(base_color(0), {});
        file.json["images"] = json::array({{{"bufferView", file.view(content)}}});
        file.json["textures"] = json::array({{{"source", 0}}});
        const Scene scene = load_gltf(file.save());
        EXPECT_EQ(fault_of(scene), fault);
        EXPECT_EQ(scene.images.at(0).bytes.at(0), 200);
        EXPECT_TRUE(fails(file.save(), "images[0]: ", strict()));
    }
}

TEST(GltfImages, ImagesThatNoPixelReadsNeedNotExist) {
    const auto extension = [](const char* name, const json& content) {
        return json{{"extensions", {{std::string("KHR_materials_") + name, content}}}};
    };
    const json texture = {{"index", 0}};
    json unlit = extension("unlit", json::object());
    unlit["normalTexture"] = texture;
    for (const json& material : {
             unlit,
             json{{"emissiveTexture", texture}},
             json{{"occlusionTexture", texture}},
             json{{"pbrMetallicRoughness",
                   {{"metallicRoughnessTexture", texture},
                    {"metallicFactor", 0},
                    {"roughnessFactor", 0}}}},
             extension("clearcoat",
                       {{"clearcoatTexture", texture}, {"clearcoatNormalTexture", texture}}),
             extension("transmission", {{"transmissionTexture", texture}}),
             extension("sheen", {{"sheenColorTexture", texture}, {"sheenRoughnessFactor", 1}}),
             extension("specular", {{"specularFactor", 0}, {"specularTexture", texture}}),
             extension("iridescence", {{"iridescenceThicknessTexture", texture}}),
             extension("anisotropy", {{"anisotropyTexture", texture}}),
             extension("diffuse_transmission", {{"diffuseTransmissionColorTexture", texture}}),
         }) {
        GltfBuilder file = textured(material, uris({"missing.png"}));
        const Scene scene = load_gltf(file.save(), strict());
        EXPECT_EQ(scene.fault_count, 0u) << material;
    }
    // Each of them is read with a factor of its own.
    for (const json& material :
         {json{{"emissiveTexture", texture}, {"emissiveFactor", {1, 0, 0}}},
          json{{"normalTexture", texture}},
          extension("clearcoat", {{"clearcoatTexture", texture}, {"clearcoatFactor", 1}}),
          extension("transmission",
                    {{"transmissionTexture", texture}, {"transmissionFactor", 1}})}) {
        GltfBuilder file = textured(material, uris({"missing.png"}));
        EXPECT_EQ(load_gltf(file.save()).fault_count, 1u) << material;
    }
}

TEST(GltfImages, AnImageNamedSeveralTimesIsDecodedOnce) {
    const std::string content = text_of(plain_png(4, 200));
    write_file(test_folder() / "a.png", content);
    write_file(test_folder() / "b.png", content);
    write_file(test_folder() / "c.png", text_of(plain_png(4, 100)));
    json material = base_color(0);
    material["normalTexture"] = {{"index", 1}};
    material["emissiveTexture"] = {{"index", 2}};
    material["emissiveFactor"] = {1, 1, 1};
    material["pbrMetallicRoughness"]["metallicRoughnessTexture"] = {{"index", 3}};
    GltfBuilder file = textured(material, uris({"a.png", "b.png", "./a.png", "c.png"}));
    const Scene scene = load_gltf(file.save());
    EXPECT_EQ(scene.images.at(0).bytes.at(0), 200);
    EXPECT_TRUE(scene.images.at(1).empty());
    EXPECT_TRUE(scene.images.at(2).empty());
    EXPECT_EQ(scene.images.at(3).bytes.at(0), 100);
    for (const auto& [texture, image] : {std::pair(0, 0u), {1, 0u}, {2, 0u}, {3, 3u}})
        EXPECT_EQ(scene.textures.at(static_cast<size_t>(texture)).image, image);
}

TEST(GltfImages, TheSumOfDecodedTexturesIsLimited) {
    write_file(test_folder() / "a.png", text_of(plain_png(140, 1)));
    write_file(test_folder() / "b.png", text_of(plain_png(140, 2)));
    json material = base_color(0);
    material["normalTexture"] = {{"index", 1}};
    LoadOptions options;
    options.max_texture_memory = 1;  // MiB: far more than 140² texels of 4 bytes
    GltfBuilder twice = textured(material, uris({"a.png", "b.png"}));
    EXPECT_EQ(load_gltf(twice.save(), options).fault_count, 0u);
    // 600² texels of 4 bytes are 1.4 MiB.
    Bytes large = plain_png(1, 1);
    large[8 + 8 + 2] = large[8 + 12 + 2] = std::byte{2};
    large[8 + 8 + 3] = large[8 + 12 + 3] = std::byte{88};
    write_file(test_folder() / "c.png", text_of(large));
    GltfBuilder huge = textured(base_color(0), uris({"c.png"}));
    EXPECT_TRUE(fails(huge.save(), "more than the limit of 1 MiB (--max-texture-memory)", options));
}

void decode_level(GltfAsset& asset, int level) {
    const WantedLevel wanted{level, true};
    asset.file->decode_images({&wanted, 1}, asset.scene);
    EXPECT_EQ(asset.scene.images.at(0).level, level);
    EXPECT_EQ(asset.scene.fault_count, 0u);
}

TEST(GltfImages, CoarseLevelsAreKeptForLaterViewsWithinTheLimit) {
    Image image;
    image.width = image.height = 1024;
    image.channels = 3;
    image.bytes.assign(3u << 20, 200);
    GltfBuilder file = textured(base_color(0), {});
    file.json["images"] = json::array({{{"bufferView", file.view(encode_png(image))}}});
    file.json["textures"] = json::array({{{"source", 0}}});
    for (const uint64_t limit : {5, 4}) {  // MiB; levels 0, 1 and 2 take 3.9
        LoadOptions options;
        options.max_texture_memory = limit;
        GltfAsset asset = read_gltf(file.save(), options, GltfFile::Times::any);
        for (const int level : {1, 2}) {
            decode_level(asset, level);
            asset.scene.images[0].bytes[0] = 7;
        }
        decode_level(asset, 0);
        for (const int level : {2, 1}) {
            decode_level(asset, level);
            EXPECT_EQ(asset.scene.images[0].bytes[0], limit == 5 ? 7 : 200) << level;
        }
    }
}

TEST(GltfImages, AnImageAboveALimitIsAnErrorAndNoFault) {
    write_file(test_folder() / "a.png", text_of(plain_png(4, 1)));
    GltfBuilder file = textured(base_color(0), uris({"a.png"}));
    LoadOptions options;
    options.images.max_pixels = 15;
    EXPECT_TRUE(fails(file.save(), "--max-image-pixels", options));
}

TEST(GltfImages, UrisOutsideTheFolderAreNotRead) {
    fs::create_directories(test_folder() / "in");
    write_file(test_folder() / "secret.png", text_of(plain_png(4, 99)));
    write_file(test_folder() / "in/real.png", text_of(plain_png(4, 7)));
    fs::create_symlink("../secret.png", test_folder() / "in/out.png");
    fs::create_symlink("..", test_folder() / "in/up");
    fs::create_symlink(test_folder() / "secret.png", test_folder() / "in/absolute.png");
    fs::create_symlink("real.png", test_folder() / "in/link.png");
    for (const char* uri : {"../secret.png", "out.png", "up/secret.png", "absolute.png",
                            "%2e%2e/secret.png", "x/../../secret.png"}) {
        GltfBuilder file = textured(base_color(0), uris({uri}));
        const std::string path = write_file(test_folder() / "in/a.glb", file.glb());
        EXPECT_EQ(fault_of(load_gltf(path)), "missing-texture images[0].uri") << uri;
        EXPECT_TRUE(fails(path, uri, strict())) << uri;
    }
    GltfBuilder outside = textured(base_color(0), uris({"out.png"}));
    const std::string path = write_file(test_folder() / "in/a.glb", outside.glb());
    LoadOptions options;
    options.allow_outside = true;
    EXPECT_EQ(load_gltf(path, options).images.at(0).bytes.at(0), 99);
    GltfBuilder link = textured(base_color(0), uris({"link.png"}));
    write_file(test_folder() / "in/a.glb", link.glb());
    EXPECT_EQ(load_gltf(path).images.at(0).bytes.at(0), 7);
}

}  // namespace
}  // namespace sightline
