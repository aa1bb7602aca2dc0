// The only file that includes meshoptimizer.
#include "scene/gltf/meshopt.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

namespace sightline {
namespace {

using nlohmann::json;

/// 16 bytes of attributes take at least 2 bits, and three indices a byte, so no stream can expand
/// more. Streams that claim to are refused before memory is allocated for them.
constexpr uint64_t max_growth = 256;

/// An EXT_meshopt_compression object, whose structure has been checked.
struct Stream {
    std::span<const std::byte> data;
    uint64_t count, stride;
    std::string mode, filter;
};

void check_stream(const Document& document, const Stream& s, const GltfBufferView& view,
                  const std::string& place) {
    const bool attributes = s.mode == "ATTRIBUTES";
    const bool stride_fits = attributes ? s.stride % 4 == 0 && s.stride >= 4 && s.stride <= 256
                                        : s.stride == 2 || s.stride == 4;
    if (!stride_fits) document.fail(place + ".byteStride", fmt::format("cannot be {}", s.stride));
    if (s.count > max_growth * s.data.size() || s.count * s.stride > max_growth * s.data.size())
        document.fail(place + ".count",
                      fmt::format("{} elements cannot come from {} bytes", s.count, s.data.size()));
    if (s.count * s.stride != view.byte_length)
        document.fail(place + ".count",
                      fmt::format("{} elements of {} bytes do not fill the view's {}", s.count,
                                  s.stride, view.byte_length));
    if (s.mode == "TRIANGLES" && s.count % 3 != 0)
        document.fail(place + ".count", "is not a multiple of 3");
    const bool filter_fits =
        s.filter == "NONE" ||
        (attributes && ((s.filter == "OCTAHEDRAL" && (s.stride == 4 || s.stride == 8)) ||
                        (s.filter == "QUATERNION" && s.stride == 8) || s.filter == "EXPONENTIAL"));
    if (!filter_fits)
        document.fail(place + ".filter",
                      fmt::format("{} does not go with mode {} and byteStride {}", s.filter, s.mode,
                                  s.stride));
}

Stream read_stream(const Document& document, const json& extension, const std::string& place) {
    const uint64_t offset = extension.value("byteOffset", uint64_t{0});
    const uint64_t length = extension["byteLength"];
    const auto& buffer = document.buffers[extension["buffer"].get<size_t>()];
    if (offset > buffer.size() || length > buffer.size() - offset)
        document.fail(place, fmt::format("bytes {} to {} are not all in a buffer of {}", offset,
                                         offset + length, buffer.size()));
    return {buffer.subspan(offset, length), extension["count"], extension["byteStride"],
            extension["mode"], extension.value("filter", "NONE")};
}

/// False where the stream is damaged.
bool decode(const Stream& s, std::vector<std::byte>& out) {
    const auto* data = reinterpret_cast<const unsigned char*>(s.data.data());
    if (s.mode == "TRIANGLES")
        return meshopt_decodeIndexBuffer(out.data(), s.count, s.stride, data, s.data.size()) == 0;
    if (s.mode == "INDICES")
        return meshopt_decodeIndexSequence(out.data(), s.count, s.stride, data, s.data.size()) == 0;
    if (meshopt_decodeVertexBuffer(out.data(), s.count, s.stride, data, s.data.size()) != 0)
        return false;
    if (s.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(out.data(), s.count, s.stride);
    if (s.filter == "QUATERNION") meshopt_decodeFilterQuat(out.data(), s.count, s.stride);
    if (s.filter == "EXPONENTIAL") meshopt_decodeFilterExp(out.data(), s.count, s.stride);
    return true;
}

}  // namespace

void decode_meshopt(Document& document) {
    for (size_t i = 0; i < document.buffer_views.size(); ++i) {
        const json* extension =
            find_extension(document.json["bufferViews"][i], "EXT_meshopt_compression");
        if (!extension) continue;
        GltfBufferView& view = document.buffer_views[i];
        const std::string place =
            fmt::format("bufferViews[{}].extensions.EXT_meshopt_compression", i);
        const Stream stream = read_stream(document, *extension, place);
        check_stream(document, stream, view, place);
        std::vector<std::byte>& decoded = document.storage.emplace_back(view.byte_length);
        if (!decode(stream, decoded)) document.fail(place, "is damaged");
        view.buffer = static_cast<uint32_t>(document.buffers.size());
        view.byte_offset = 0;
        document.buffers.push_back(decoded);
    }
}

}  // namespace sightline
