#include "scene/gltf/faults.h"

#include <algorithm>
#include <iterator>

namespace sightline {
namespace {

constexpr Severity noted = Severity::noted, mended = Severity::mended, dropped = Severity::dropped,
                   refused = Severity::refused;

constexpr FaultEntry table[] = {
    {Fault::byte_order_mark, "byte-order-mark", mended, "the JSON begins with a byte order mark",
     "skipped", "INVALID_JSON", "skips it"},
    {Fault::glb_chunk, "glb-chunk", mended,
     "a GLB has a chunk, or bytes after its end, that do not belong there", "passed over",
     "GLB_DUPLICATE_CHUNK, GLB_UNEXPECTED_BIN_CHUNK, GLB_EXTRA_DATA (warning)", "passes over it"},
    {Fault::glb_padding, "glb-padding", mended,
     "the length of a GLB's chunk is not a multiple of 4", "read as it is",
     "GLB_CHUNK_LENGTH_UNALIGNED", "reads it"},
    {Fault::data_uri_form, "data-uri-form", mended,
     "a data URI has blanks, or \"base64\" in capital letters", "read as base64", "INVALID_URI",
     "reads it"},
    {Fault::buffer, "buffer", refused, "a buffer is missing, too short or described wrongly",
     "refused", "IO_ERROR, BUFFER_BYTE_LENGTH_MISMATCH, BUFFER_MISSING_GLB_DATA", "fails"},
    {Fault::unneeded_buffer, "unneeded-buffer", noted,
     "a buffer that nothing needs is missing or too short (only `info` looks)", "not read",
     "IO_ERROR, BUFFER_BYTE_LENGTH_MISMATCH", "does not read it"},
    {Fault::gltf_1, "gltf-1.0", refused, "the file is glTF 1.0", "refused",
     "UNKNOWN_ASSET_MAJOR_VERSION", "refuses it"},
    {Fault::newer_version, "newer-version", noted, "asset.version is above 2.0",
     "read as glTF 2.0: what is newer is missing in the picture",
     "UNKNOWN_ASSET_MINOR_VERSION (warning)", "reads it as 2.0"},
    {Fault::minimum_version, "minimum-version", refused,
     "asset.version or asset.minVersion asks for a reader of more than glTF 2.0", "refused",
     "UNKNOWN_ASSET_MAJOR_VERSION, UNKNOWN_ASSET_MINOR_VERSION (warning), "
     "ASSET_MIN_VERSION_GREATER_THAN_VERSION",
     "reads it as 2.0"},
    {Fault::required_extension, "required-extension", dropped,
     "an extension is required that is not read and only changes how things look",
     "drawn without it", "UNSUPPORTED_EXTENSION (information)", "warns, and draws without it"},
    {Fault::required_geometry_extension, "required-geometry-extension", refused,
     "an extension is required that is not read and may hide geometry or bytes", "refused",
     "UNSUPPORTED_EXTENSION (information)", "warns, and draws what it finds"},
    {Fault::unknown_extension, "unknown-extension", noted, "an extension is used that is not read",
     "ignored", "UNSUPPORTED_EXTENSION (information)", "ignores it"},
    {Fault::too_many_faults, "too-many-faults", refused, "the file has more than 65536 faults",
     "refused", "", ""},
    {Fault::nothing_to_draw, "nothing-to-draw", refused,
     "because of its faults, nothing is left to draw", "refused", "", ""},

    {Fault::property, "property", mended, "a property has a wrong type, size or value",
     "left out: its default holds", "TYPE_MISMATCH, UNRESOLVED_REFERENCE, VALUE_NOT_IN_RANGE",
     "mostly takes it as it is"},
    {Fault::list_entry, "list-entry", dropped,
     "an entry of a list has a wrong type or refers to nothing", "left out",
     "TYPE_MISMATCH, UNRESOLVED_REFERENCE", "fails if it refers to nothing"},
    {Fault::color_length, "color-length", mended,
     "a colour has three numbers in place of four, or four in place of three",
     "alpha is 1, or the fourth number is left out", "ARRAY_LENGTH_NOT_IN_LIST",
     "takes three numbers; warns of the alpha"},
    {Fault::sampler_choice, "sampler-choice", mended,
     "a sampler has a wrap mode or filter that does not exist",
     "the default holds: repeat, or linear with mipmaps", "VALUE_NOT_IN_LIST (warning)",
     "takes its default"},
    {Fault::object, "object", dropped, "an object lacks what it needs or has a wrong type",
     "left out, with what refers to it", "UNDEFINED_PROPERTY, TYPE_MISMATCH",
     "fails if something uses it"},
    {Fault::material_extension, "material-extension", dropped,
     "a material's extension has a wrong type", "left out", "TYPE_MISMATCH", "leaves it out"},
    {Fault::buffer_view, "buffer-view", dropped,
     "a buffer view exceeds its buffer, or is described wrongly", "left out, with what lies in it",
     "BUFFER_VIEW_TOO_LONG", "fails if an accessor does not fit"},
    {Fault::accessor, "accessor", dropped,
     "an accessor exceeds its buffer view, or is described wrongly", "left out, with what uses it",
     "ACCESSOR_TOO_LONG", "fails if something uses it"},

    {Fault::node_cycle, "node-cycle", dropped, "a node is its own ancestor",
     "not drawn, with all below it", "NODE_LOOP", "fails if a scene shows it"},
    {Fault::second_parent, "second-parent", mended, "a node has two parents",
     "it stays below the first", "NODE_PARENT_OVERRIDE", "it stays below the last"},
    {Fault::matrix_not_finite, "matrix-not-finite", dropped,
     "a node's matrix to world space is not finite", "not drawn, with all below it", "nothing",
     "takes it as it is"},
    {Fault::instances, "instances", dropped,
     "the instances of EXT_mesh_gpu_instancing have wrong types, counts or values",
     "drawn once, where the node stands", "UNSUPPORTED_EXTENSION (information)",
     "takes them as they are"},
    {Fault::instance, "instance", dropped,
     "an instance of EXT_mesh_gpu_instancing has no finite matrix", "not drawn",
     "ACCESSOR_INVALID_FLOAT", "takes it as it is"},
    {Fault::camera, "camera", dropped, "a camera has an impossible lens",
     "left out: an error only if it is the camera asked for",
     "CAMERA_XMAG_YMAG_ZERO, CAMERA_ZFAR_LEQUAL_ZNEAR, VALUE_NOT_IN_RANGE",
     "takes it as it is; fails without a lens"},
    {Fault::light, "light", dropped, "a light has a wrong type", "left out",
     "VALUE_NOT_IN_LIST (warning)", "fails if a node has it"},
    {Fault::shape, "shape", dropped, "an implicit shape has an impossible size or unknown type",
     "not drawn", "UNSUPPORTED_EXTENSION (information)", "ignores it"},

    {Fault::primitive, "primitive", dropped,
     "a primitive has wrong or missing data, or indices out of range", "not drawn",
     "ACCESSOR_INDEX_OOB, MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT",
     "draws it; fails without attributes"},
    {Fault::attribute, "attribute", dropped,
     "an attribute that the material does not need has wrong data", "drawn without",
     "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT", "takes it as it is"},
    {Fault::draco_stream, "draco-stream", dropped, "a Draco stream is damaged", "not drawn",
     "UNSUPPORTED_EXTENSION (information)", "fails"},
    {Fault::meshopt_stream, "meshopt-stream", dropped, "a meshopt stream is damaged",
     "what lies in it is left out", "UNSUPPORTED_EXTENSION (information)", "fails"},
    {Fault::morph_weights, "morph-weights", mended,
     "there are more or fewer morph weights than morph targets",
     "weights that are missing are 0, others are left out",
     "MESH_INVALID_WEIGHTS_COUNT, NODE_WEIGHTS_INVALID", "missing weights are 0"},
    {Fault::unused_joint, "unused-joint", mended, "a joint of weight 0 is out of range",
     "passed over", "ACCESSOR_JOINTS_INDEX_OOB", "passes over it"},
    {Fault::skin, "skin", dropped, "a skin has no joints, or wrong ones",
     "its meshes are drawn where their nodes stand",
     "EMPTY_ENTITY, UNRESOLVED_REFERENCE, INVALID_IBM_ACCESSOR_COUNT",
     "fails if a joint is no node"},
    {Fault::unskinned_primitive, "unskinned-primitive", mended,
     "a primitive with a skin has no JOINTS_0 and WEIGHTS_0", "drawn where its node stands",
     "NODE_SKIN_WITH_NON_SKINNED_MESH, MESH_PRIMITIVE_JOINTS_WEIGHTS_MISMATCH",
     "warns, and draws it where its node stands"},

    {Fault::channel, "channel", dropped, "an animation's channel has wrong data or targets",
     "the property rests", "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT", "loads it"},
    {Fault::duplicate_channel, "duplicate-channel", dropped,
     "two channels of an animation move the same property", "the second is left out",
     "ANIMATION_DUPLICATE_TARGETS", "mixes both"},
    {Fault::equal_key_times, "equal-key-times", mended, "keyframes have the same time",
     "the last of them holds from that time on", "ACCESSOR_ANIMATION_INPUT_NON_INCREASING",
     "the last of them holds"},
    {Fault::negative_key_time, "negative-key-time", mended, "a keyframe's time is below 0",
     "used as it is", "ACCESSOR_ANIMATION_INPUT_NEGATIVE", "uses it as it is"},
    {Fault::one_key_spline, "one-key-spline", mended, "a cubic spline has one keyframe",
     "its value holds at all times", "ANIMATION_SAMPLER_INPUT_ACCESSOR_TOO_FEW_ELEMENTS",
     "its value holds"},
    {Fault::animated_matrix, "animated-matrix", mended, "a node that is animated has a matrix",
     "the matrix is taken apart into translation, rotation and scale",
     "ANIMATION_CHANNEL_TARGET_NODE_MATRIX", "takes it apart"},
    {Fault::first_animation, "first-animation", noted,
     "--time is given without --animation, and the file has several animations",
     "the first one is played", "", ""},

    {Fault::missing_texture, "missing-texture", dropped, "a texture's image file is missing",
     "drawn without the texture, or with --missing-texture checker in its place", "IO_ERROR",
     "draws without it"},
    {Fault::unreadable_texture, "unreadable-texture", dropped,
     "a texture's image cannot be decoded",
     "drawn without the texture, or with --missing-texture checker in its place",
     "IMAGE_DATA_INVALID, IMAGE_UNEXPECTED_EOS", "draws without what the browser rejects"},
    {Fault::png_checksum, "png-checksum", mended,
     "a chunk of a PNG that is not needed has a wrong checksum", "passed over", "nothing",
     "leaves it to the browser"},
    {Fault::png_end, "png-end", mended, "a PNG has no IEND chunk", "read as if it had", "nothing",
     "leaves it to the browser"},
    {Fault::jpeg_end, "jpeg-end", mended, "a JPEG has no end marker", "read as if it had",
     "nothing", "leaves it to the browser"},
    {Fault::ktx2_texture, "ktx2-texture", noted, "a texture has no image but a KTX2 file",
     "drawn without the texture", "UNSUPPORTED_EXTENSION (information)",
     "reads it with a decoder of its own"},

    {Fault::points_and_lines, "points-and-lines", noted, "a primitive consists of points or lines",
     "not drawn", "nothing", "draws them one pixel wide"},
    {Fault::splats, "splats", noted, "a primitive consists of Gaussian splats", "not drawn",
     "UNSUPPORTED_EXTENSION (information)", "draws points"},
    {Fault::image_based_light, "image-based-light", noted,
     "the scene has a light of EXT_lights_image_based", "lit without it",
     "UNSUPPORTED_EXTENSION (information)", "ignores it"},
};

constexpr bool is_in_order() {
    for (size_t i = 0; i < std::size(table); ++i)
        if (static_cast<size_t>(table[i].fault) != i) return false;
    return true;
}
static_assert(is_in_order() &&
              std::size(table) == static_cast<size_t>(Fault::image_based_light) + 1);

}  // namespace

std::span<const FaultEntry> fault_table() { return table; }

const FaultEntry& entry_of(Fault fault) { return table[static_cast<size_t>(fault)]; }

std::string_view to_string(Severity severity) {
    switch (severity) {
        case Severity::noted:
            return "noted";
        case Severity::mended:
            return "mended";
        case Severity::dropped:
            return "dropped";
        case Severity::refused:
            return "refused";
    }
    return "";
}

}  // namespace sightline
