#pragma once
// A parsed glTF file before it becomes a Scene. Internal to src/scene.
#include "core/error.h"
#include "core/files.h"
#include "core/math.h"
#include "scene/gltf/faults.h"
#include "scene/gltf/load_options.h"
#include "scene/scene.h"

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

// Names follow glTF 2.0; a missing index is `none`. After load_document, all indices are in range
// and all enumerations valid: what had a fault has been mended or emptied.

struct GltfBufferView {
    uint32_t buffer = none;
    uint64_t byte_offset = 0, byte_length = 0;
    uint32_t byte_stride = 0;  ///< 0: tightly packed
    bool dropped = false;      ///< had a fault, which has been reported; it is empty
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
    bool dropped = false;  ///< had a fault, which has been reported; it is empty
    struct Sparse {
        uint64_t count = 0;  ///< 0: not sparse
        uint32_t indices_view = none, values_view = none;
        uint64_t indices_offset = 0, values_offset = 0;
        ComponentType indices_type = ComponentType::uint16;
    } sparse;

    uint32_t components() const { return rows * columns; }
};

struct GltfPrimitive {
    std::map<std::string, uint32_t> attributes;  ///< semantic → accessor; empty: dropped
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
    bool has_matrix = false;  ///< `matrix` replaces the next three members
    Mat4d matrix;
    Vec3d translation{0, 0, 0}, scale{1, 1, 1};
    std::array<double, 4> rotation{0, 0, 0, 1};  ///< unit quaternion x, y, z, w
    std::vector<float> weights;                  ///< of the morph targets; empty: the mesh's
};

struct GltfSkin {
    std::vector<uint32_t> joints;
    uint32_t inverse_bind_matrices = none;  ///< accessor; none: identities
    std::vector<Mat4> inverse_binds;        ///< one for each joint, once check_skins has read them
};

struct GltfAnimation {
    struct Sampler {
        uint32_t input = none, output = none;
        enum class Interpolation { linear, step, cubic_spline } interpolation{};
    };
    struct Channel {
        uint32_t sampler = none;
        uint32_t node = none;  ///< none: an extension's target; the channel is ignored
        std::string path;      ///< translation, rotation, scale, weights, or an extension's
    };
    std::string name;
    std::vector<Sampler> samplers;
    std::vector<Channel> channels;
};

/// Deviations from the file that the user should know of: at most `max_lines` distinct lines.
class Warnings {
  public:
    static constexpr size_t max_lines = 200;

    /// Adds a line, made printable, unless it has been added before; returns whether it was added.
    bool add(const std::string& line);

    /// The lines; a last one counts those beyond `max_lines`.
    std::vector<std::string> lines() const;

  private:
    std::vector<std::string> lines_;
    std::unordered_set<uint64_t> hashes_;  // of all lines
};

/// Thrown by the reader of a part of the file, such as a primitive, that has a fault; whoever reads
/// the whole catches it, reports it and goes on without the part.
struct FaultyPart : Error {
    FaultyPart(const std::string& file, Fault fault_, std::string place_, std::string detail_)
        : Error(file + ": " + place_ + ": " + detail_),
          fault(fault_),
          place(std::move(place_)),
          detail(std::move(detail_)) {}

    Fault fault;
    std::string place, detail;
};

/// How many numbers may still be read. Every read is charged, even of the same bytes, because any
/// number of accessors can share a few bytes, and any number of primitives an accessor.
struct ReadBudget {
    uint64_t values;                     ///< of accessors with data
    uint64_t zeros = uint64_t{1} << 26;  ///< of accessors without data
};

/// What changes when a document is posed, beside the JSON of the nodes that are dropped.
struct DocumentState {
    std::vector<GltfNode> nodes;  ///< a forest
    Warnings warnings;
    std::vector<FoundFault> faults;  ///< those mended or dropped, at most Warnings::max_lines
    uint64_t fault_count = 0;        ///< of all that were mended or dropped
    uint64_t reports = 0;            ///< calls of report() and warn()
    ReadBudget budget{LoadOptions().max_accessor_values};
};

/// The file with its buffers in memory.
struct Document : DocumentState {
    std::string path;        ///< of the file
    bool has_folder = true;  ///< whose files it may name; false: it comes from standard input
    nlohmann::json json;     ///< the whole file; materials and extensions are read from here
    std::deque<FileBytes> storage;  ///< owns the bytes that `buffers` refers to
    /// Each of byteLength, or empty if nothing needs it; then those of decoded views.
    std::vector<std::span<const std::byte>> buffers;
    std::vector<bool> needed_buffers;  ///< of the file's own; those that nothing needs are not read
    std::vector<GltfBufferView> buffer_views;  ///< each within its buffer
    std::vector<GltfAccessor> accessors;       ///< each within its view
    std::vector<GltfMesh> meshes;
    std::vector<GltfSkin> skins;
    std::vector<GltfAnimation> animations;
    /// The nodes' JSON that drop_nodes has taken since the last save().
    std::vector<std::pair<uint32_t, nlohmann::json>> dropped_nodes;
    bool strict = false;            ///< throw Error at the first fault that is not only noted
    std::vector<SourceFile> files;  ///< every file read so far
    uint64_t content_hash = 0;      ///< of all of them

    /// Throws Error "file: place: reason"; `place` is a JSON path such as meshes[3].primitives[0].
    [[noreturn]] void fail(const std::string& place, const std::string& reason) const;

    /// Throws FaultyPart: what is read at `place` cannot be used.
    [[noreturn]] void fail_part(Fault fault, const std::string& place,
                                const std::string& detail) const;

    /// Throws FaultyPart if the accessor was dropped; `place` is that of its use.
    void require_usable(uint32_t accessor, Fault fault, const std::string& place) const;

    /// Warns of a fault, and records it unless it is only noted: "place: detail: what is done".
    /// An empty `detail` stands for the words of the table. The caller then does what the table
    /// says. Throws Error if the table or `strict` refuses the file.
    void report(Fault fault, const std::string& place, std::string detail = {});
    void report(const FaultyPart& part) { report(part.fault, part.place, part.detail); }

    /// Adds the warning "place: text".
    void warn(const std::string& place, const std::string& text);

    /// A top-level array of the JSON, such as materials; empty if it is absent.
    const nlohmann::json& list(const char* key) const;

    /// Records a file that was read in `files` and `content_hash`.
    void add_file(const std::string& name, std::span<const std::byte> bytes);

    /// Charges all numbers of an accessor to the budget. Throws Error if it is exhausted.
    void charge(uint32_t accessor);

    /// Charges data that takes as much memory as `values` numbers.
    void charge(const std::string& place, uint64_t values);

    /// Leaves out a node and all below it: they become empty nodes without children.
    void drop_nodes(uint32_t root);

    /// The state to which restore() takes the document back.
    DocumentState save();
    void restore(const DocumentState& state);

    /// The bytes of a buffer view.
    std::span<const std::byte> bytes(const GltfBufferView& view) const {
        return buffers[view.buffer].subspan(view.byte_offset, view.byte_length);
    }
};

/// The extension's object within `object` (a JSON object that may have "extensions"), or nullptr.
const nlohmann::json* find_extension(const nlohmann::json& object, const char* name);

}  // namespace sightline
