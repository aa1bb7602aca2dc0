// The only file that includes meshoptimizer.
#include "scene/gltf/meshopt.h"

#include "core/parallel.h"

#include <fmt/format.h>
#include <meshoptimizer.h>

namespace sightline {
namespace {

using nlohmann::json;

/// 16 bytes of attributes take at least 2 bits, and three indices a byte, so no stream can expand
/// more. Streams that claim to are refused before memory is allocated for them.
constexpr uint64_t max_growth = 256;

/// An object of EXT_meshopt_compression or KHR_meshopt_compression, whose structure has been
/// checked.
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
    if (!stride_fits)
        document.fail_part(Fault::meshopt_stream, place + ".byteStride",
                           fmt::format("cannot be {}", s.stride));
    if (s.count > max_growth * s.data.size() || s.count * s.stride > max_growth * s.data.size())
        document.fail_part(
            Fault::meshopt_stream, place + ".count",
            fmt::format("{} elements cannot come from {} bytes", s.count, s.data.size()));
    if (s.count * s.stride != view.byte_length)
        document.fail_part(Fault::meshopt_stream, place + ".count",
                           fmt::format("{} elements of {} bytes do not fill the view's {}", s.count,
                                       s.stride, view.byte_length));
    if (s.mode == "TRIANGLES" && s.count % 3 != 0)
        document.fail_part(Fault::meshopt_stream, place + ".count", "is not a multiple of 3");
    if (s.filter == "COLOR")
        document.fail_part(Fault::meshopt_stream, place + ".filter", "COLOR is not read");
    const bool filter_fits =
        s.filter == "NONE" ||
        (attributes && ((s.filter == "OCTAHEDRAL" && (s.stride == 4 || s.stride == 8)) ||
                        (s.filter == "QUATERNION" && s.stride == 8) || s.filter == "EXPONENTIAL"));
    if (!filter_fits)
        document.fail_part(Fault::meshopt_stream, place + ".filter",
                           fmt::format("{} does not go with mode {} and byteStride {}", s.filter,
                                       s.mode, s.stride));
}

Stream read_stream(const Document& document, const json& extension, const std::string& place) {
    const uint64_t offset = extension.value("byteOffset", uint64_t{0});
    const uint64_t length = extension["byteLength"];
    const auto& buffer = document.buffers[extension["buffer"].get<size_t>()];
    if (offset > buffer.size() || length > buffer.size() - offset)
        document.fail_part(Fault::meshopt_stream, place,
                           fmt::format("bytes {} to {} are not all in a buffer of {}", offset,
                                       offset + length, buffer.size()));
    return {buffer.subspan(offset, length), extension["count"], extension["byteStride"],
            extension["mode"], extension.value("filter", "NONE")};
}

/// Says why a stream could not be decoded. The high half of its first byte is the kind of stream,
/// the low half the version.
[[noreturn]] void fail_stream(const Document& document, const Stream& s, const std::string& place) {
    const int header = s.data.empty() ? 0 : static_cast<int>(s.data[0]);
    if (s.mode == "ATTRIBUTES" && header == 0xa1)
        document.fail_part(Fault::meshopt_stream, place,
                           "is of version 1, which the meshoptimizer of this build may not read");
    document.fail_part(Fault::meshopt_stream, place, "is damaged");
}

/// False where the stream is damaged.
bool decode(const Stream& s, FileBytes& out) {
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

/// A view to be decoded.
struct Compressed {
    uint32_t view;
    Stream stream;
    std::string place;
    FileBytes decoded;
    bool is_good = false;
};

Compressed read_view(Document& document, uint32_t view, const json& extension,
                     const std::string& place) {
    const uint64_t length = document.buffer_views[view].byte_length;
    const Stream stream = read_stream(document, extension, place);
    check_stream(document, stream, document.buffer_views[view], place);
    document.charge(place, length / sizeof(float));
    return {view, stream, place, FileBytes(length), false};
}

/// The views that are needed and whose descriptions are sound; reports the others.
std::vector<Compressed> compressed_views(Document& document) {
    std::vector<Compressed> all;
    for (uint32_t i = 0; i < document.buffer_views.size(); ++i) {
        GltfBufferView& view = document.buffer_views[i];
        if (view.dropped) continue;
        const json* extension = find_meshopt(document.json["bufferViews"][i]);
        if (!extension) continue;
        if (!document.needed_buffers[(*extension)["buffer"].get<size_t>()]) continue;
        const bool ratified =
            find_extension(document.json["bufferViews"][i], "KHR_meshopt_compression");
        const std::string place = fmt::format("bufferViews[{}].extensions.{}_meshopt_compression",
                                              i, ratified ? "KHR" : "EXT");
        try {
            all.push_back(read_view(document, i, *extension, place));
        } catch (const FaultyPart& part) {
            document.report(part);
            view.dropped = true;
        }
    }
    return all;
}

/// Makes the view refer to a buffer with the decoded bytes.
void fill_view(Document& document, Compressed& compressed) {
    if (!compressed.is_good) fail_stream(document, compressed.stream, compressed.place);
    GltfBufferView& view = document.buffer_views[compressed.view];
    document.storage.push_back(std::move(compressed.decoded));
    view.buffer = static_cast<uint32_t>(document.buffers.size());
    view.byte_offset = 0;
    document.buffers.push_back(document.storage.back());
}

}  // namespace

const json* find_meshopt(const json& buffer_view) {
    const json* ratified = find_extension(buffer_view, "KHR_meshopt_compression");
    return ratified ? ratified : find_extension(buffer_view, "EXT_meshopt_compression");
}

void decode_meshopt(Document& document) {
    std::vector<Compressed> all = compressed_views(document);
    parallel_for(all.size(),
                 [&](size_t i) { all[i].is_good = decode(all[i].stream, all[i].decoded); });
    for (Compressed& compressed : all) {
        try {
            fill_view(document, compressed);
        } catch (const FaultyPart& part) {
            document.report(part);
            document.buffer_views[compressed.view].dropped = true;
        }
    }
}

}  // namespace sightline
