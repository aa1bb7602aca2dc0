// The only file that includes Draco.
#include "scene/gltf/draco.h"

#include "core/parallel.h"

#include <draco/compression/decode.h>
#include <draco/compression/point_cloud/point_cloud_decoder.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <exception>

namespace sightline {
namespace {

using nlohmann::json;

/// Regular meshes take at least about 1/50 byte per face. Streams that claim far less are refused
/// before memory is allocated for them.
constexpr uint64_t max_faces_per_byte = 1024;

draco::DecoderBuffer open(std::span<const std::byte> data) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(data.data()), data.size());
    return buffer;
}

/// The counts in a stream's header, by which the decoder allocates memory.
struct HeaderCounts {
    uint32_t faces = 0, points = 0;
};

/// Empty if the header is damaged or not that of a mesh.
std::optional<HeaderCounts> read_header_counts(std::span<const std::byte> data) {
    draco::DecoderBuffer buffer = open(data);
    draco::DracoHeader header;
    if (!draco::PointCloudDecoder::DecodeHeader(&buffer, &header).ok()) return {};
    const int version = header.version_major * 256 + header.version_minor;
    if (version < 0x202 || header.encoder_type != draco::TRIANGULAR_MESH) return {};
    buffer.set_bitstream_version(static_cast<uint16_t>(version));
    if (header.flags & METADATA_FLAG_MASK) {
        draco::GeometryMetadata metadata;
        if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata)) return {};
    }
    HeaderCounts counts;
    if (header.encoder_method == draco::MESH_SEQUENTIAL_ENCODING) {
        if (!draco::DecodeVarint(&counts.faces, &buffer) ||
            !draco::DecodeVarint(&counts.points, &buffer))
            return {};
        return counts;
    }
    uint8_t traversal = 0, attributes = 0;
    uint32_t symbols = 0, splits = 0;
    if (!buffer.Decode(&traversal) || !draco::DecodeVarint(&counts.points, &buffer) ||
        !draco::DecodeVarint(&counts.faces, &buffer) || !buffer.Decode(&attributes) ||
        !draco::DecodeVarint(&symbols, &buffer) || !draco::DecodeVarint(&splits, &buffer))
        return {};
    counts.points = std::max(counts.points, splits);
    return counts;
}

std::unique_ptr<draco::Mesh> decode(const Document& document, std::span<const std::byte> data,
                                    uint64_t max_elements, const std::string& place) {
    const auto counts = read_header_counts(data);
    if (!counts)
        document.fail_part(Fault::draco_stream, place,
                           "is not a Draco mesh of version 2.2, or is damaged");
    const uint64_t faces = counts->faces;
    if (faces > max_faces_per_byte * data.size() || counts->points > 3 * faces)
        document.fail_part(Fault::draco_stream, place,
                           fmt::format("{} faces and {} points cannot come from {} bytes", faces,
                                       counts->points, data.size()));
    if (3 * faces > max_elements)
        document.fail(
            place, fmt::format("{} faces are above the limit of {} elements", faces, max_elements));
    draco::DecoderBuffer buffer = open(data);
    auto decoded = draco::Decoder().DecodeMeshFromBuffer(&buffer);
    if (!decoded.ok()) document.fail_part(Fault::draco_stream, place, "is damaged");
    if (decoded.value()->num_points() > 3 * faces)
        document.fail_part(Fault::draco_stream, place, "has too many points");
    return std::move(decoded).value();
}

std::span<const std::byte> stream(const Document& document, uint32_t index,
                                  const std::string& place) {
    const GltfBufferView& view = document.buffer_views[index];
    if (view.dropped)
        document.fail_part(Fault::draco_stream, place + ".bufferView",
                           fmt::format("bufferViews[{}] is left out", index));
    const uint64_t size = document.buffers[view.buffer].size();
    if (view.byte_offset > size || view.byte_length > size - view.byte_offset)
        document.fail_part(Fault::draco_stream, place + ".bufferView", "exceeds its buffer");
    return document.bytes(view);
}

/// Makes the accessor refer to `data` alone.
void fill(Document& document, uint32_t accessor, uint64_t count, FileBytes data) {
    document.charge(fmt::format("accessors[{}]", accessor), data.size() / sizeof(float));
    GltfAccessor& a = document.accessors[accessor];
    a.buffer_view = static_cast<uint32_t>(document.buffer_views.size());
    a.byte_offset = 0;
    a.count = count;
    a.sparse = {};
    document.storage.push_back(std::move(data));
    GltfBufferView view;
    view.buffer = static_cast<uint32_t>(document.buffers.size());
    view.byte_length = document.storage.back().size();
    document.buffers.push_back(document.storage.back());
    document.buffer_views.push_back(view);
}

template <class T>
bool convert(const draco::PointAttribute& attribute, uint32_t points, uint32_t components,
             FileBytes& out) {
    out.resize(size_t{points} * components * sizeof(T));
    std::vector<T> value(components);
    for (uint32_t i = 0; i < points; ++i) {
        const draco::AttributeValueIndex index = attribute.mapped_index(draco::PointIndex(i));
        if (index.value() >= attribute.size()) return false;
        if (!attribute.ConvertValue(index, static_cast<int8_t>(components), value.data()))
            return false;
        std::memcpy(out.data() + i * components * sizeof(T), value.data(), components * sizeof(T));
    }
    return true;
}

bool convert(const draco::PointAttribute& attribute, uint32_t points, const GltfAccessor& to,
             FileBytes& out) {
    const uint32_t components = to.components();
    switch (to.component_type) {
        case ComponentType::int8:
            return convert<int8_t>(attribute, points, components, out);
        case ComponentType::uint8:
            return convert<uint8_t>(attribute, points, components, out);
        case ComponentType::int16:
            return convert<int16_t>(attribute, points, components, out);
        case ComponentType::uint16:
            return convert<uint16_t>(attribute, points, components, out);
        case ComponentType::uint32:
            return convert<uint32_t>(attribute, points, components, out);
        case ComponentType::float32:
            return convert<float>(attribute, points, components, out);
    }
    return false;
}

void fill_indices(Document& document, GltfPrimitive& primitive, const draco::Mesh& mesh) {
    if (primitive.indices == none) {
        primitive.indices = static_cast<uint32_t>(document.accessors.size());
        document.accessors.emplace_back();
    }
    GltfAccessor& accessor = document.accessors[primitive.indices];
    accessor.component_type = ComponentType::uint32;
    accessor.rows = accessor.columns = 1;
    std::vector<uint32_t> indices;
    indices.reserve(size_t{3} * mesh.num_faces());
    for (uint32_t f = 0; f < mesh.num_faces(); ++f)
        for (const draco::PointIndex& point : mesh.face(draco::FaceIndex(f)))
            indices.push_back(point.value());
    const auto bytes = std::as_bytes(std::span(indices));
    fill(document, primitive.indices, indices.size(), {bytes.begin(), bytes.end()});
    primitive.mode = 4;  // triangles, even if the file says strip
}

void fill_attribute(Document& document, const draco::Mesh& mesh, uint32_t accessor, const json& id,
                    const std::string& place) {
    if (!id.is_number_unsigned() || id > none)
        document.fail_part(Fault::draco_stream, place, "is not an attribute's id");
    const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(id.get<uint32_t>());
    if (!attribute)
        document.fail_part(Fault::draco_stream, place,
                           "refers to an attribute that is not in the stream");
    const GltfAccessor& to = document.accessors[accessor];
    if (attribute->num_components() != to.components())
        document.fail_part(Fault::draco_stream, place,
                           fmt::format("has {} components, but the accessor {}",
                                       attribute->num_components(), to.components()));
    FileBytes data;
    if (!convert(*attribute, mesh.num_points(), to, data))
        document.fail_part(Fault::draco_stream, place, "is damaged");
    fill(document, accessor, mesh.num_points(), std::move(data));
}

/// False if the file has the data uncompressed, or a primitive with the same accessors has been
/// decoded.
bool needs_decoding(const Document& document, const GltfPrimitive& primitive,
                    const json& attributes) {
    const auto is_empty = [&](uint32_t accessor) {
        return accessor == none || document.accessors[accessor].buffer_view == none;
    };
    return is_empty(primitive.indices) ||
           std::ranges::any_of(attributes.items(), [&](const auto& attribute) {
               const auto found = primitive.attributes.find(attribute.key());
               return found != primitive.attributes.end() && is_empty(found->second);
           });
}

/// A primitive whose data are in a stream.
struct Compressed {
    GltfPrimitive* primitive;
    const json* extension;
    std::string place;
    std::unique_ptr<draco::Mesh> mesh;  ///< once decoded
    std::exception_ptr error;           ///< why it could not be
};

std::vector<Compressed> compressed_primitives(Document& document) {
    std::vector<Compressed> all;
    for (size_t m = 0; m < document.meshes.size(); ++m) {
        for (size_t p = 0; p < document.meshes[m].primitives.size(); ++p) {
            const json* extension = find_extension(document.json["meshes"][m]["primitives"][p],
                                                   "KHR_draco_mesh_compression");
            if (!extension) continue;
            all.push_back(
                {&document.meshes[m].primitives[p],
                 extension,
                 fmt::format("meshes[{}].primitives[{}].extensions.KHR_draco_mesh_compression", m,
                             p),
                 {},
                 {}});
        }
    }
    return all;
}

/// May run beside others.
void decode(const Document& document, uint64_t max_elements, Compressed& compressed) {
    const json& extension = *compressed.extension;
    if (!needs_decoding(document, *compressed.primitive, extension["attributes"])) return;
    const std::string& place = compressed.place;
    try {
        compressed.mesh = decode(document, stream(document, extension["bufferView"], place),
                                 max_elements, place + ".bufferView");
    } catch (...) {
        compressed.error = std::current_exception();
    }
}

/// Makes the primitive's accessors refer to the decoded data, unless those of an earlier primitive,
/// which are the same, do already.
void fill_primitive(Document& document, Compressed& compressed) {
    GltfPrimitive& primitive = *compressed.primitive;
    const json& attributes = (*compressed.extension)["attributes"];
    if (!needs_decoding(document, primitive, attributes)) return;
    if (compressed.error) std::rethrow_exception(compressed.error);
    fill_indices(document, primitive, *compressed.mesh);
    for (const auto& [name, id] : attributes.items()) {
        const auto found = primitive.attributes.find(name);
        if (found != primitive.attributes.end())
            fill_attribute(document, *compressed.mesh, found->second, id,
                           fmt::format("{}.attributes.{}", compressed.place, name));
    }
}

}  // namespace

void decode_draco(Document& document, uint64_t max_elements) {
    constexpr size_t at_once = 16;  // bounds the memory of what is decoded but not yet copied
    std::vector<Compressed> all = compressed_primitives(document);
    for (size_t begin = 0; begin < all.size(); begin += at_once) {
        const auto some = std::span(all).subspan(begin, std::min(at_once, all.size() - begin));
        parallel_for(some.size(), [&](size_t i) { decode(document, max_elements, some[i]); });
        for (Compressed& compressed : some) {
            try {
                fill_primitive(document, compressed);
            } catch (const FaultyPart& part) {
                document.report(part);
                compressed.primitive->attributes.clear();
            }
            compressed.mesh.reset();
        }
    }
}

}  // namespace sightline
