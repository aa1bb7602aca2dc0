#pragma once
// Reading accessors: interleaved, normalised and sparse; their bounds have been checked. Internal
// to src/scene.
#include "core/memory.h"
#include "scene/gltf/document.h"

namespace sightline {

/// Bytes from one column of a matrix to the next; columns start at multiples of 4.
uint64_t column_size(const GltfAccessor& accessor);

/// Bytes of one tightly packed element.
uint64_t element_size(const GltfAccessor& accessor);

/// Writes count · components values of an accessor, which must have been charged, to `out`.
/// Normalised integers become [0,1] or [−1,1], others keep their value; matrices are written column
/// by column without padding. Throws FaultyPart with `fault` if sparse indices are out of range.
void copy_floats(const Document& document, uint32_t accessor, float* out, Fault fault);

/// Reads an accessor as float, Vec2, Vec3, Vec4 or Mat4 (glTF's column-major layout equals that of
/// the row-vector matrix). Throws FaultyPart with `fault` and `place` if the accessor is dropped or
/// the number of components differs.
template <class T>
std::vector<T> read_floats(Document& document, uint32_t accessor, Fault fault,
                           const std::string& place) {
    constexpr uint32_t components = sizeof(T) / sizeof(float);
    document.require_usable(accessor, fault, place);
    const GltfAccessor& a = document.accessors[accessor];
    if (a.components() != components) {
        document.fail_part(fault, place,
                           "accessor " + std::to_string(accessor) + " has " +
                               std::to_string(a.components()) + " components, not " +
                               std::to_string(components));
    }
    document.charge(accessor);
    std::vector<T> values;
    reserve_in_large_pages(values, a.count + 1);  // Embree reads behind the last position
    values.resize(a.count);
    copy_floats(document, accessor, reinterpret_cast<float*>(values.data()), fault);
    return values;
}

/// Charges an accessor of plain unsigned integers. Throws FaultyPart{primitive} with `place` if it
/// is dropped, holds signed integers or floats, or is normalised.
void require_integers(Document& document, uint32_t accessor, const std::string& place);

/// Writes count · components values of an accessor that require_integers has accepted to `out`.
/// Throws FaultyPart{primitive} if sparse indices are out of range.
void copy_integers(const Document& document, uint32_t accessor, uint32_t* out);

/// Reads all components of an accessor of unsigned integers (indices, joints), interleaved. Throws
/// as require_integers and copy_integers do.
std::vector<uint32_t> read_integers(Document& document, uint32_t accessor,
                                    const std::string& place);

}  // namespace sightline
