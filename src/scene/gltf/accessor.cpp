#include "scene/gltf/accessor.h"

#include "core/parallel.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <type_traits>

namespace sightline {
namespace {

// Reads one component at `from`, which need not be aligned.
template <class T>
T load(const std::byte* from) {
    T value;
    std::memcpy(&value, from, sizeof value);
    return value;
}

template <class Out, class T>
Out convert(T value, bool normalized) {
    if constexpr (std::is_same_v<Out, T> || std::is_same_v<Out, uint32_t>) {
        return static_cast<Out>(value);
    } else {
        const auto real = static_cast<double>(value);
        if (!normalized) return static_cast<Out>(real);
        return static_cast<Out>(std::max(real / std::numeric_limits<T>::max(), -1.0));
    }
}

// Calls `f` with a value of the C++ type that corresponds to a component type.
void with_type(ComponentType type, const auto& f) {
    switch (type) {
        case ComponentType::int8:
            return f(int8_t{});
        case ComponentType::uint8:
            return f(uint8_t{});
        case ComponentType::int16:
            return f(int16_t{});
        case ComponentType::uint16:
            return f(uint16_t{});
        case ComponentType::uint32:
            return f(uint32_t{});
        case ComponentType::float32:
            return f(float{});
    }
}

// Copies elements `begin` to `end`, `stride` bytes apart; element i goes to `target(i)`.
template <class Out>
void copy_elements(const GltfAccessor& a, const std::byte* from, uint64_t stride, uint64_t begin,
                   uint64_t end, const auto& target) {
    const uint64_t column = column_size(a);
    with_type(a.component_type, [&]<class T>(T) {
        for (uint64_t i = begin; i < end; ++i) {
            Out* to = target(i);
            for (uint32_t c = 0; c < a.columns; ++c) {
                const std::byte* at = from + i * stride + c * column;
                for (uint32_t r = 0; r < a.rows; ++r)
                    *to++ = convert<Out>(load<T>(at + r * sizeof(T)), a.normalized);
            }
        }
    });
}

// Whether elements that lie next to each other are an array of Out.
template <class Out>
bool is_array_of(const GltfAccessor& a) {
    return a.component_type ==
           (std::is_same_v<Out, float> ? ComponentType::float32 : ComponentType::uint32);
}

std::vector<uint32_t> sparse_indices(const Document& document, uint32_t accessor, Fault fault) {
    const GltfAccessor& a = document.accessors[accessor];
    const std::byte* from = document.bytes(document.buffer_views[a.sparse.indices_view]).data() +
                            a.sparse.indices_offset;
    std::vector<uint32_t> indices(a.sparse.count);
    with_type(a.sparse.indices_type, [&]<class T>(T) {
        for (size_t i = 0; i < indices.size(); ++i)
            indices[i] = static_cast<uint32_t>(load<T>(from + i * sizeof(T)));
    });
    for (const uint32_t i : indices) {
        if (i < a.count) continue;
        document.fail_part(fault, "accessors[" + std::to_string(accessor) + "].sparse.indices",
                           "index " + std::to_string(i) + " is not below the accessor's count, " +
                               std::to_string(a.count));
    }
    return indices;
}

template <class Out>
void copy_values(const Document& document, uint32_t accessor, Out* out, Fault fault) {
    const GltfAccessor& a = document.accessors[accessor];
    if (a.buffer_view == none) {
        std::fill_n(out, a.count * a.components(), Out{});
    } else {
        const GltfBufferView& view = document.buffer_views[a.buffer_view];
        const uint64_t stride = view.byte_stride ? view.byte_stride : element_size(a);
        const std::byte* from = document.bytes(view).data() + a.byte_offset;
        parallel_ranges(a.count, [&](size_t begin, size_t end) {
            if (is_array_of<Out>(a) && stride == element_size(a))
                std::memcpy(out + begin * a.components(), from + begin * stride,
                            (end - begin) * stride);
            else
                copy_elements<Out>(a, from, stride, begin, end,
                                   [&](uint64_t i) { return out + i * a.components(); });
        });
    }
    if (a.sparse.count == 0) return;
    const std::vector<uint32_t> indices = sparse_indices(document, accessor, fault);
    const std::byte* from =
        document.bytes(document.buffer_views[a.sparse.values_view]).data() + a.sparse.values_offset;
    copy_elements<Out>(a, from, element_size(a), 0, a.sparse.count,
                       [&](uint64_t i) { return out + uint64_t{indices[i]} * a.components(); });
}

}  // namespace

uint64_t column_size(const GltfAccessor& accessor) {
    const uint64_t bytes = uint64_t{accessor.rows} * size_of(accessor.component_type);
    return accessor.columns == 1 ? bytes : (bytes + 3) / 4 * 4;
}

uint64_t element_size(const GltfAccessor& accessor) {
    return accessor.columns * column_size(accessor);
}

void copy_floats(const Document& document, uint32_t accessor, float* out, Fault fault) {
    copy_values(document, accessor, out, fault);
}

void require_integers(Document& document, uint32_t accessor, const std::string& place) {
    document.require_usable(accessor, Fault::primitive, place);
    const GltfAccessor& a = document.accessors[accessor];
    if (!is_unsigned(a.component_type) || a.normalized) {
        document.fail_part(
            Fault::primitive, place,
            "accessor " + std::to_string(accessor) + " does not hold plain unsigned integers");
    }
    document.charge(accessor);
}

void copy_integers(const Document& document, uint32_t accessor, uint32_t* out) {
    copy_values(document, accessor, out, Fault::primitive);
}

std::vector<uint32_t> read_integers(Document& document, uint32_t accessor,
                                    const std::string& place) {
    require_integers(document, accessor, place);
    const GltfAccessor& a = document.accessors[accessor];
    std::vector<uint32_t> values(a.count * a.components());
    copy_integers(document, accessor, values.data());
    return values;
}

}  // namespace sightline
