#pragma once
// glTF files made in code, a JSON tree with one binary buffer, and checks that they load or fail.
#include "core/error.h"
#include "scene/gltf/load.h"
#include "support/test_folder.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

namespace sightline {

inline std::string write_file(const std::filesystem::path& path, std::string_view content) {
    std::ofstream(path, std::ios::binary) << content;
    return path.string();
}

class GltfBuilder {
  public:
    nlohmann::json json = {{"asset", {{"version", "2.0"}}}};
    std::string bin;

    /// Appends values as a new buffer view, aligned to 4 bytes; returns its index.
    template <class T>
    size_t view(const std::vector<T>& values, size_t stride = 0) {
        bin.resize((bin.size() + 3) / 4 * 4);
        nlohmann::json view = {
            {"buffer", 0}, {"byteOffset", bin.size()}, {"byteLength", values.size() * sizeof(T)}};
        if (stride) view["byteStride"] = stride;
        bin.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        return add("bufferViews", view);
    }

    /// Adds an accessor; `more` overrides or extends its properties.
    size_t accessor(size_t view, int component_type, const char* type, size_t count,
                    const nlohmann::json& more = {}) {
        nlohmann::json accessor = {{"bufferView", view},
                                   {"componentType", component_type},
                                   {"type", type},
                                   {"count", count}};
        if (!more.is_null()) accessor.update(more);
        return add("accessors", accessor);
    }

    size_t floats(const std::vector<float>& values, const char* type) {
        const size_t size = std::strcmp(type, "SCALAR") == 0 ? 1
                            : std::strcmp(type, "MAT4") == 0 ? 16
                                                             : static_cast<size_t>(type[3] - '0');
        return accessor(view(values), 5126, type, values.size() / size);
    }

    size_t indices(const std::vector<uint16_t>& values) {
        return accessor(view(values), 5123, "SCALAR", values.size());
    }

    /// Appends to a top-level array; returns the index.
    size_t add(const char* array, const nlohmann::json& item) {
        json[array].push_back(item);
        return json[array].size() - 1;
    }

    /// A mesh of one primitive, and a root node with it. Returns the node.
    size_t mesh_node(const nlohmann::json& primitive) {
        const size_t mesh = add("meshes", {{"primitives", {primitive}}});
        return add("nodes", {{"mesh", mesh}});
    }

    /// One triangle (0,0,0) (1,0,0) (0,1,0) and a node that draws it.
    size_t triangle() {
        return mesh_node(
            {{"attributes", {{"POSITION", floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3")}}}});
    }

    std::string glb() const {
        nlohmann::json whole = json;
        if (!bin.empty() && whole.is_object()) whole["buffers"] = {{{"byteLength", bin.size()}}};
        std::string text = whole.dump(), data = bin;
        text.resize((text.size() + 3) / 4 * 4, ' ');
        data.resize((data.size() + 3) / 4 * 4);
        std::string chunks = chunk(0x4E4F534A, text);
        if (!bin.empty()) chunks += chunk(0x004E4942, data);
        return number(0x46546C67) + number(2) + number(static_cast<uint32_t>(12 + chunks.size())) +
               chunks;
    }

    /// Writes a .glb into the test's folder; returns its path.
    std::string save() const { return write_file(test_folder() / "test.glb", glb()); }

  private:
    static std::string number(uint32_t value) {
        return {reinterpret_cast<const char*>(&value), sizeof value};
    }
    static std::string chunk(uint32_t type, const std::string& data) {
        return number(static_cast<uint32_t>(data.size())) + number(type) + data;
    }
};

/// Whether strict loading fails with one line that names the file and contains `part`.
inline testing::AssertionResult fails(const std::string& path, const std::string& part,
                                      LoadOptions options = {}) {
    options.strict = true;
    try {
        load_gltf(path, options);
    } catch (const Error& error) {
        const std::string line = error.what();
        if (line.starts_with(path + ": ") && line.find(part) != std::string::npos &&
            line.find('\n') == std::string::npos) {
            return testing::AssertionSuccess();
        }
        return testing::AssertionFailure() << "another error: " << line;
    }
    return testing::AssertionFailure() << "it loads";
}

/// Whether it loads. A failure must be an Error with a message of one line.
inline bool loads(const std::string& path) {
    try {
        load_gltf(path);
        return true;
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        return false;
    }
}

}  // namespace sightline
