#pragma once
// A parsed and checked glTF file, before it becomes a Scene. Internal to src/scene.
#include "core/math.h"
#include "scene/gltf/load.h"

#include <array>
#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <unordered_set>
#include <vector>

namespace sightline {

/// What `none` is to an index, names follow glTF 2.0. All indices are in range, all enumerations
/// valid: load_document has checked them.
struct GltfBufferView {
    uint32_t buffer = none;
    uint64_t byte_offset = 0, byte_length = 0;
    uint32_t byte_stride = 0;  ///< 0: tightly packed
};

enum class ComponentType { int8 = 5120, uint8, int16, uint16, uint32 = 5125, float32 };

/// Bytes of one component.
constexpr uint32_t size_of(ComponentType type) {
    return type == ComponentType::int8 || type == ComponentType::uint8     ? 1
           : type == ComponentType::int16 || type == ComponentType::uint16 ? 2
                                                                           : 4;
}

constexpr bool is_unsigned(ComponentType type) {
    return type == ComponentType::uint8 || type == ComponentType::uint16 ||
           type == ComponentType::uint32;
}

struct GltfAccessor {
    uint32_t buffer_view = none;  ///< none: zeros
    uint64_t byte_offset = 0, count = 0;
    ComponentType component_type = ComponentType::float32;
    uint32_t rows = 1, columns = 1;  ///< VEC3: 3 × 1, MAT4: 4 × 4
    bool normalized = false;
    struct Sparse {
        uint64_t count = 0;  ///< 0: not sparse
        uint32_t indices_view = none, values_view = none;
        uint64_t indices_offset = 0, values_offset = 0;
        ComponentType indices_type = ComponentType::uint16;
    } sparse;

    uint32_t components() const { return rows * columns; }
};

struct GltfPrimitive {
    std::map<std::string, uint32_t> attributes;  ///< semantic → accessor
    uint32_t indices = none, material = none;
    int mode = 4;
    std::vector<std::map<std::string, uint32_t>> targets;
};

struct GltfMesh {
    std::string name;
    std::vector<GltfPrimitive> primitives;
    std::vector<float> weights;  ///< of the morph targets; empty: all 0
};

struct GltfNode {
    std::string name;
    std::vector<uint32_t> children;
    uint32_t parent = none, mesh = none, skin = none, camera = none;
    bool has_matrix = false;  ///< `matrix` stands in place of the three below
    Mat4d matrix;
    Vec3d translation{0, 0, 0}, scale{1, 1, 1};
    std::array<double, 4> rotation{0, 0, 0, 1};  ///< unit quaternion x, y, z, w
    std::vector<float> weights;                  ///< of the morph targets; empty: the mesh's
};

struct GltfSkin {
    std::vector<uint32_t> joints;
    uint32_t inverse_bind_matrices = none;  ///< accessor; none: identities
};

struct GltfAnimation {
    struct Sampler {
        uint32_t input = none, output = none;
        enum class Interpolation { linear, step, cubic_spline } interpolation{};
    };
    struct Channel {
        uint32_t sampler = none;
        uint32_t node = none;  ///< none: an extension's target, to be left out
        std::string path;      ///< translation, rotation, scale, weights, or an extension's
    };
    std::string name;
    std::vector<Sampler> samplers;
    std::vector<Channel> channels;
};

/// What is drawn otherwise than meant: each line once, and no more of them than anyone will read.
class Warnings {
  public:
    static constexpr size_t most = 200;

    /// The line is made printable.
    void add(const std::string& line);

    /// The lines; a last one counts those that were too many.
    std::vector<std::string> lines() const;

  private:
    std::vector<std::string> lines_;
    std::unordered_set<uint64_t> hashes_;  // of all lines
};

/// The file with its buffers in memory.
struct Document {
    std::string path;     ///< of the file
    nlohmann::json json;  ///< the whole of it: materials and extensions are read from here
    std::deque<std::vector<std::byte>> storage;       ///< owns what `buffers` shows
    std::vector<std::span<const std::byte>> buffers;  ///< each at least byteLength long
    std::vector<GltfBufferView> buffer_views;         ///< each within its buffer
    std::vector<GltfAccessor> accessors;              ///< each within its view
    std::vector<GltfMesh> meshes;
    std::vector<GltfNode> nodes;  ///< a forest
    std::vector<GltfSkin> skins;
    std::vector<GltfAnimation> animations;
    Warnings warnings;
    /// Numbers that may still be read from accessors: of data, and of accessors without any.
    mutable uint64_t values_left = LoadOptions().max_values, zeros_left = uint64_t{1} << 26;
    std::vector<SourceFile> files;  ///< every file read so far
    uint64_t content_hash = 0;      ///< of all of them

    /// Throws Error "file: place: reason"; `place` is a JSON path such as meshes[3].primitives[0].
    [[noreturn]] void fail(const std::string& place, const std::string& reason) const;

    /// Adds the line "place: what" to the warnings.
    void warn(const std::string& place, const std::string& what);

    /// A top-level array of the JSON, such as materials; an empty one where it is absent.
    const nlohmann::json& list(const char* key) const;

    /// Takes note of a file that was read: into `files` and `content_hash`.
    void add_file(const std::string& name, std::span<const std::byte> bytes);

    /// Counts an accessor's numbers as read. Throws Error where that is more than is allowed: a few
    /// bytes may be named by any number of accessors, and those by any number of primitives.
    void spend(uint32_t accessor) const;

    /// The same for what takes as much memory as `values` numbers.
    void spend(const std::string& place, uint64_t values) const;

    /// The bytes of a buffer view.
    std::span<const std::byte> bytes(const GltfBufferView& view) const {
        return buffers[view.buffer].subspan(view.byte_offset, view.byte_length);
    }
};

/// Reads, checks and parses a file and its buffers; meshopt and Draco data are already decoded
/// into plain buffer views and accessors. Throws Error.
Document load_document(const std::string& path, const LoadOptions& options);

/// The bytes that a URI names: a data URI, or a percent-encoded path relative to the document's
/// folder, which it may leave only with `allow_outside`. Adds them to the document's hash.
std::vector<std::byte> read_uri(Document& document, const std::string& uri,
                                const std::string& place, const LoadOptions& options);

/// The extension's object within `object` (a JSON object with "extensions"), or nullptr.
const nlohmann::json* find_extension(const nlohmann::json& object, const char* name);

}  // namespace sightline
