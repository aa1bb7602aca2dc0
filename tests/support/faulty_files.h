#pragma once
// Files each with one fault, beside a sound triangle.
#include "core/files.h"
#include "image/write_image.h"
#include "support/gltf.h"
#include "support/png.h"

#include <functional>
#include <limits>
#include <map>

namespace sightline {

/// For each kind of fault, a function that writes such a file and returns its path.
using FaultInputs = std::map<Fault, std::function<std::string()>>;

using Change = std::function<void(GltfBuilder&)>;

inline constexpr float nan = std::numeric_limits<float>::quiet_NaN();

/// A file with a sound triangle and something else.
inline std::string triangle_and(const Change& change) {
    GltfBuilder file;
    file.triangle();
    change(file);
    return file.save();
}

/// The same, with the properties of a JSON text.
inline std::string triangle_and(const char* text) {
    return triangle_and(
        [&](GltfBuilder& file) { file.json.merge_patch(nlohmann::json::parse(text)); });
}

/// A .gltf of one triangle whose buffer is the data URI `head` + base64.
inline std::string text_file(const std::string& before, const std::string& head) {
    GltfBuilder file;
    file.triangle();
    file.json["buffers"] = {{{"byteLength", 36}, {"uri", head + std::string(48, 'A')}}};
    return write_file(test_folder() / "test.gltf", before + file.json.dump());
}

/// A buffer of zeros for one triangle.
inline std::string triangle_buffer() {
    return "data:application/octet-stream;base64," + std::string(48, 'A');
}

/// A .gltf of one triangle in the first of these buffers.
inline std::string text_buffers(const nlohmann::json& buffers) {
    GltfBuilder file;
    file.triangle();
    file.json["buffers"] = buffers;
    return write_file(test_folder() / "test.gltf", file.json.dump());
}

/// A GLB of one triangle with `more` bytes at its end, within the length in its header or not.
inline std::string glb_with(const std::string& more, bool counted) {
    GltfBuilder file;
    file.triangle();
    std::string glb = file.glb() + more;
    const auto length = static_cast<uint32_t>(glb.size() - (counted ? 0 : more.size()));
    std::memcpy(&glb[8], &length, sizeof length);
    return write_file(test_folder() / "test.glb", glb);
}

/// A triangle with further attributes or properties.
inline nlohmann::json primitive_with(GltfBuilder& file, const nlohmann::json& more) {
    nlohmann::json primitive = {
        {"attributes", {{"POSITION", file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3")}}}};
    primitive.merge_patch(more);
    return primitive;
}

/// A skinned triangle with one joint at (5, 0, 0), and with `joints` and `weights` for each vertex.
inline void add_skinned(GltfBuilder& file, const std::vector<uint8_t>& joints,
                        const std::vector<float>& weights) {
    std::vector<uint8_t> all_joints;
    std::vector<float> all_weights;
    for (int v = 0; v < 3; ++v) {
        all_joints.insert(all_joints.end(), joints.begin(), joints.end());
        all_weights.insert(all_weights.end(), weights.begin(), weights.end());
    }
    const size_t node = file.mesh_node(
        primitive_with(file, {{"attributes",
                               {{"JOINTS_0", file.accessor(file.view(all_joints), 5121, "VEC4", 3)},
                                {"WEIGHTS_0", file.floats(all_weights, "VEC4")}}}}));
    file.json["nodes"][node]["skin"] = 0;
    file.json["skins"] = {{{"joints", {file.add("nodes", {{"translation", {5, 0, 0}}})}}}};
}

/// An animation that moves node 0 along x.
inline void add_motion(GltfBuilder& file, const std::vector<float>& times,
                       const std::vector<float>& positions, const char* interpolation = "LINEAR") {
    file.add(
        "animations",
        {{"samplers",
          {{{"input", file.floats(times, "SCALAR")},
            {"output", file.floats(positions, "VEC3")},
            {"interpolation", interpolation}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}});
}

/// A triangle in instances at `translations`, of a `type`.
inline std::string instanced(const std::vector<float>& translations, const char* type) {
    return triangle_and([&](GltfBuilder& file) {
        file.json["nodes"][0]["extensions"] = {
            {"EXT_mesh_gpu_instancing",
             {{"attributes", {{"TRANSLATION", file.floats(translations, type)}}}}}};
    });
}

inline void add_compressed_view(GltfBuilder& file) {
    const size_t data = file.view(std::vector<uint8_t>(64, 7));
    nlohmann::json view = file.json["bufferViews"][data];
    nlohmann::json extension = view;
    extension.update({{"byteStride", 4}, {"count", 4}, {"mode", "ATTRIBUTES"}});
    view["byteLength"] = 16;
    view["extensions"]["EXT_meshopt_compression"] = extension;
    file.add("bufferViews", view);
}

inline void add_draco_primitive(GltfBuilder& file) {
    const nlohmann::json empty = {{"componentType", 5126}, {"type", "VEC3"}, {"count", 3}};
    file.mesh_node({{"attributes", {{"POSITION", file.add("accessors", empty)}}},
                    {"extensions",
                     {{"KHR_draco_mesh_compression",
                       {{"bufferView", file.view(std::vector<uint8_t>(64, 7))},
                        {"attributes", {{"POSITION", 0}}}}}}}});
}

inline FaultInputs container_inputs() {
    const std::string base64 = "data:application/octet-stream;base64,";
    return {
        {Fault::byte_order_mark, [=] { return text_file("\xEF\xBB\xBF", base64); }},
        {Fault::glb_chunk, [] { return glb_with("rest", false); }},
        {Fault::glb_padding, [] { return glb_with(std::string("\1\0\0\0ABCDx", 9), true); }},
        {Fault::data_uri_form, [] { return text_file("", "data:;BASE64, "); }},
        {Fault::buffer, [] { return text_file("", "missing.bin?"); }},
        {Fault::unneeded_buffer,
         [] {
             return text_buffers({{{"byteLength", 36}, {"uri", triangle_buffer()}},
                                  {{"byteLength", 9}, {"uri", "missing.bin"}}});
         }},
        {Fault::gltf_1, [] { return triangle_and(R"({"asset": {"version": "1.0"}})"); }},
        {Fault::newer_version, [] { return triangle_and(R"({"asset": {"version": "2.1"}})"); }},
        {Fault::minimum_version,
         [] { return triangle_and(R"({"asset": {"version": "2.1", "minVersion": "2.1"}})"); }},
        {Fault::required_extension,
         [] { return triangle_and(R"({"extensionsRequired": ["KHR_materials_velvet"]})"); }},
        {Fault::required_geometry_extension,
         [] { return triangle_and(R"({"extensionsRequired": ["ACME_geometry"]})"); }},
        {Fault::unknown_extension,
         [] { return triangle_and(R"({"extensionsUsed": ["ACME_rockets"]})"); }},
        {Fault::too_many_faults,
         [] {
             return triangle_and(
                 [](GltfBuilder& file) { file.json["materials"] = std::vector<int>(65537, 0); });
         }},
    };
}

inline FaultInputs object_inputs() {
    return {
        {Fault::property, [] { return triangle_and(R"({"materials": [{"name": 5}]})"); }},
        {Fault::list_entry, [] { return triangle_and(R"({"scenes": [{"nodes": [0, 9]}]})"); }},
        {Fault::color_length,
         [] {
             return triangle_and(
                 R"({"materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1]}}]})");
         }},
        {Fault::sampler_choice, [] { return triangle_and(R"({"samplers": [{"wrapS": 10496}]})"); }},
        {Fault::object, [] { return triangle_and(R"({"textures": [5]})"); }},
        {Fault::material_extension,
         [] {
             return triangle_and(R"({"materials": [{"extensions": {"KHR_materials_ior": 5}}]})");
         }},
        {Fault::buffer_view,
         [] {
             return triangle_and([](GltfBuilder& file) {
                 file.add("bufferViews", {{"buffer", 0}, {"byteLength", 1000}});
             });
         }},
        {Fault::accessor,
         [] { return triangle_and([](GltfBuilder& file) { file.accessor(0, 5126, "VEC3", 4); }); }},
    };
}

inline FaultInputs node_inputs() {
    return {
        {Fault::node_cycle,
         [] { return triangle_and(R"({"nodes": [{"mesh": 0}, {"children": [1]}]})"); }},
        {Fault::second_parent,
         [] {
             return triangle_and(
                 R"({"nodes": [{"mesh": 0}, {"children": [0]}, {"children": [0]}]})");
         }},
        {Fault::matrix_not_finite,
         [] {
             return triangle_and([](GltfBuilder& file) {
                 for (int i = 1; i < 10; ++i) {
                     nlohmann::json node = {{"scale", {1e38, 1, 1}}};
                     if (i < 9) node["children"].push_back(i + 1);
                     file.add("nodes", node);
                 }
             });
         }},
        {Fault::instances,
         [] {
             return instanced({1, 2}, "SCALAR");
         }},
        {Fault::instance,
         [] {
             return instanced({0, 0, 0, nan, 0, 0, 2, 0, 0}, "VEC3");
         }},
        {Fault::camera,
         [] {
             return triangle_and(R"({
                 "cameras": [{"type": "perspective", "perspective": {"yfov": 0, "znear": 1}}],
                 "nodes": [{"mesh": 0}, {"camera": 0}]})");
         }},
        {Fault::light,
         [] {
             return triangle_and(
                 R"({"extensions": {"KHR_lights_punctual": {"lights": [{"type": "sun"}]}}})");
         }},
        {Fault::shape,
         [] {
             return triangle_and(R"({
                 "extensions": {"KHR_implicit_shapes":
                     {"shapes": [{"type": "sphere", "sphere": {"radius": -1}}]}},
                 "nodes": [{"mesh": 0},
                     {"extensions": {"SIGHTLINE_implicit_shapes": {"shape": 0}}}]})");
         }},
    };
}

/// A sound triangle and one with further attributes or properties.
inline std::string two_primitives(const std::function<nlohmann::json(GltfBuilder&)>& more) {
    return triangle_and(
        [&](GltfBuilder& file) { file.mesh_node(primitive_with(file, more(file))); });
}

inline FaultInputs mesh_inputs() {
    return {
        {Fault::primitive,
         [] {
             return two_primitives([](GltfBuilder& f) {
                 return nlohmann::json::object({{"indices", f.indices({0, 1, 9})}});
             });
         }},
        {Fault::attribute,
         [] {
             return two_primitives([](GltfBuilder& f) {
                 return nlohmann::json::object(
                     {{"attributes", {{"TEXCOORD_0", f.floats({0, 0, 0}, "SCALAR")}}}});
             });
         }},
        {Fault::draco_stream, [] { return triangle_and(add_draco_primitive); }},
        {Fault::meshopt_stream, [] { return triangle_and(add_compressed_view); }},
    };
}

inline FaultInputs deformed_inputs() {
    return {
        {Fault::morph_weights,
         [] {
             return triangle_and([](GltfBuilder& file) {
                 const nlohmann::json morphed = primitive_with(
                     file, {{"targets", {{{"POSITION", file.json["meshes"].size() - 1}}}}});
                 file.mesh_node(morphed);
                 file.json["meshes"][1]["weights"] = {0.5, 0.5};
             });
         }},
        {Fault::unused_joint,
         [] {
             return triangle_and([](GltfBuilder& file) {
                 add_skinned(file, {0, 9, 0, 0}, {1, 0, 0, 0});
             });
         }},
        {Fault::skin,
         [] {
             return triangle_and([](GltfBuilder& file) {
                 add_skinned(file, {0, 0, 0, 0}, {1, 0, 0, 0});
                 file.json["skins"][0]["joints"] = nlohmann::json::array();
             });
         }},
        {Fault::unskinned_primitive,
         [] {
             return triangle_and([](GltfBuilder& file) {
                 add_skinned(file, {0, 0, 0, 0}, {1, 0, 0, 0});
                 file.json["meshes"][1]["primitives"][0]["attributes"].erase("JOINTS_0");
             });
         }},
    };
}

inline FaultInputs undrawn_inputs() {
    const auto primitive = [](const char* text) {
        return two_primitives([&](GltfBuilder&) { return nlohmann::json::parse(text); });
    };
    return {
        {Fault::ktx2_texture,
         [] {
             return triangle_and(R"({"textures": [{"extensions": {"KHR_texture_basisu": {}}}]})");
         }},
        {Fault::points_and_lines, [=] { return primitive(R"({"mode": 0})"); }},
        {Fault::splats,
         [=] { return primitive(R"({"mode": 0, "extensions": {"KHR_gaussian_splatting": {}}})"); }},
        {Fault::image_based_light,
         [] {
             return triangle_and(R"({"scenes": [
                 {"nodes": [0], "extensions": {"EXT_lights_image_based": {"light": 0}}}]})");
         }},
    };
}

inline FaultInputs animation_inputs() {
    const auto moved = [](const std::vector<float>& times, const std::vector<float>& positions,
                          const char* interpolation = "LINEAR") {
        return triangle_and(
            [&](GltfBuilder& file) { add_motion(file, times, positions, interpolation); });
    };
    return {
        {Fault::channel,
         [=] {
             return moved({0, 1}, {0, 0, 0});
         }},
        {Fault::duplicate_channel,
         [] {
             return triangle_and([](GltfBuilder& file) {
                 add_motion(file, {0, 1}, {0, 0, 0, 1, 0, 0});
                 nlohmann::json& channels = file.json["animations"][0]["channels"];
                 const nlohmann::json first = channels[0];
                 channels.push_back(first);
             });
         }},
        {Fault::equal_key_times,
         [=] {
             return moved({0, 0.5, 0.5, 1}, {0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0});
         }},
        {Fault::negative_key_time,
         [=] {
             return moved({-1, 1}, {0, 0, 0, 1, 0, 0});
         }},
        {Fault::one_key_spline,
         [=] {
             return moved({0}, {9, 9, 9, 1, 0, 0, 9, 9, 9}, "CUBICSPLINE");
         }},
        {Fault::animated_matrix,
         [] {
             return triangle_and([](GltfBuilder& file) {
                 add_motion(file, {0, 1}, {0, 0, 0, 1, 0, 0});
                 file.json["nodes"][0]["matrix"] = {0, 2, 0, 0, -2, 0, 0, 0,
                                                    0, 0, 2, 0, 7,  7, 7, 1};
             });
         }},
        {Fault::first_animation,
         [] {
             return triangle_and([](GltfBuilder& file) {
                 add_motion(file, {0, 1}, {0, 0, 0, 1, 0, 0});
                 add_motion(file, {0, 1}, {0, 0, 0, 0, 9, 0});
             });
         }},
    };
}

/// A triangle with a base colour texture whose image is these bytes.
inline std::string textured_with(const Bytes& image) {
    GltfBuilder file;
    const nlohmann::json attributes = {
        {"POSITION", file.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3")},
        {"TEXCOORD_0", file.floats({0, 0, 1, 0, 0, 1}, "VEC2")}};
    file.mesh_node({{"attributes", attributes}, {"material", 0}});
    file.json.merge_patch(nlohmann::json::parse(R"({
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}], "images": [{"uri": "missing.png"}]})"));
    if (!image.empty()) file.json["images"][0] = {{"bufferView", file.view(image)}};
    return file.save();
}

inline Bytes jpeg_without_end() {
    Image image;
    image.width = image.height = 16;
    image.channels = 3;
    image.bytes.assign(16 * 16 * 3, 200);
    const std::string path = (test_folder() / "image.jpg").string();
    write_image(path, image);
    Bytes bytes = read_bytes(path, 1 << 20);
    bytes.resize(bytes.size() - 2);
    return bytes;
}

inline FaultInputs texture_inputs() {
    return {
        {Fault::missing_texture, [] { return textured_with({}); }},
        {Fault::unreadable_texture,
         [] {
             Bytes png = plain_png(4, 200);
             png.resize(60);
             return textured_with(png);
         }},
        {Fault::png_checksum,
         [] {
             Bytes png = plain_png(4, 200);
             png.resize(png.size() - 12);
             append_chunk(png, "tEXt", Bytes(3));
             png.back() ^= std::byte{1};
             append_chunk(png, "IEND", {});
             return textured_with(png);
         }},
        {Fault::png_end,
         [] {
             Bytes png = plain_png(4, 200);
             png.resize(png.size() - 12);
             return textured_with(png);
         }},
        {Fault::jpeg_end, [] { return textured_with(jpeg_without_end()); }},
    };
}

inline FaultInputs all_inputs() {
    FaultInputs inputs = container_inputs();
    inputs.merge(object_inputs());
    inputs.merge(node_inputs());
    inputs.merge(mesh_inputs());
    inputs.merge(deformed_inputs());
    inputs.merge(undrawn_inputs());
    inputs.merge(animation_inputs());
    inputs.merge(texture_inputs());
    return inputs;
}

/// Options that look at all that a file holds.
inline LoadOptions all_faults(bool strict = false) {
    LoadOptions options;
    options.find_all_faults = true;
    options.decode_images = false;
    options.strict = strict;
    return options;
}

/// Options that pose a file at half a second.
inline LoadOptions posed(bool strict) {
    LoadOptions options;
    options.time = 0.5f;
    options.strict = strict;
    return options;
}

}  // namespace sightline
