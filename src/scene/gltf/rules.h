#pragma once
// The glTF 2.0 specification's rules for the properties that Sightline reads, as a table. Internal
// to src/scene.
#include "scene/gltf/faults.h"

#include <cstddef>
#include <span>
#include <string_view>

namespace sightline {

/// The type of a property.
enum class ValueKind {
    boolean,
    number,
    numbers,
    color,  ///< `size` numbers, of which the fourth may be missing or too much
    string,
    strings,
    natural,  ///< an integer from 0 to 2^53
    small,    ///< an integer from 0 to 2^31 − 1
    stride,   ///< a multiple of 4 up to 252
    choice,   ///< one of the words, or integers, in `of`
    index,    ///< below the size of the array at the JSON pointer `of`
    indices,
    dictionary,  ///< an object whose values are indices
    dictionaries,
    object,  ///< checked by the rules of `of`
    objects,
};

/// What a property is to the object that has it.
enum class Need {
    optional,  ///< may be absent; a wrong one is left out
    decisive,  ///< may be absent; a wrong one makes the object wrong
    required,
};

/// The rule for property `name` of objects of kind `owner`.
struct GltfRule {
    std::string_view owner, name;
    ValueKind kind;
    std::string_view of = {};
    size_t size = 0;  ///< of numbers; 0: any; of a dictionary: at least
    Need need = Need::optional;
    Fault fault = Fault::property;  ///< reported if it is left out; of `objects`, for each of them
};

/// All rules; those of one owner are adjacent.
std::span<const GltfRule> gltf_rules();

}  // namespace sightline
