#pragma once
// What Sightline does about each fault of a glTF file: the one table that decides it, and from
// which docs/faults.md is made.
#include <span>
#include <string>
#include <string_view>

namespace sightline {

/// A kind of fault. What it means is in its entry of `fault_table`.
enum class Fault {
    // Containers and texts.
    byte_order_mark,
    glb_chunk,
    glb_padding,
    data_uri_form,
    buffer,
    unneeded_buffer,
    gltf_1,
    newer_version,
    minimum_version,
    required_extension,
    required_geometry_extension,
    unknown_extension,
    too_many_faults,
    nothing_to_draw,
    // Properties and what they belong to.
    property,
    list_entry,
    color_length,
    sampler_choice,
    object,
    material_extension,
    buffer_view,
    accessor,
    // Nodes.
    node_cycle,
    second_parent,
    matrix_not_finite,
    instances,
    instance,
    camera,
    light,
    shape,
    // Meshes, morph targets and skins.
    primitive,
    attribute,
    draco_stream,
    meshopt_stream,
    morph_weights,
    unused_joint,
    skin,
    unskinned_primitive,
    // Animations.
    channel,
    duplicate_channel,
    equal_key_times,
    negative_key_time,
    one_key_spline,
    animated_matrix,
    first_animation,
    // Textures.
    missing_texture,
    unreadable_texture,
    png_checksum,
    png_end,
    jpeg_end,
    ktx2_texture,
    // What Sightline does not draw.
    points_and_lines,
    splats,
    image_based_light,
};

/// What becomes of a file with a fault.
enum class Severity {
    noted,    ///< no fault of the file: a warning says what the picture lacks or how it was chosen
    mended,   ///< a value takes the place of the faulty one; with `strict`, the file is refused
    dropped,  ///< what has the fault is left out; with `strict`, the file is refused
    refused,  ///< the file is refused in any case
};

struct FaultEntry {
    Fault fault;
    std::string_view key;  ///< its name in statistics and journals
    Severity severity;
    std::string_view wrong;      ///< what is wrong: a phrase
    std::string_view done;       ///< what is done about it: a phrase
    std::string_view validator;  ///< the codes of Khronos' glTF Validator; empty: not examined
    std::string_view three_js;   ///< what three.js does; empty: not examined
};

/// A fault of the file in spite of which it is drawn (docs/faults.md).
struct FoundFault {
    std::string key;    ///< its kind, such as "sampler-choice"
    std::string place;  ///< a JSON path such as samplers[0].wrapS
    std::string text;   ///< what was wrong and what was done; one line
    bool operator==(const FoundFault&) const = default;
};

/// All entries, in the order of `Fault`.
std::span<const FaultEntry> fault_table();

const FaultEntry& entry_of(Fault fault);

std::string_view to_string(Severity severity);

}  // namespace sightline
