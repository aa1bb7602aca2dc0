#include "scene/gltf/container.h"

#include "core/bytes.h"
#include "core/error.h"
#include "scene/foreign_format.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

namespace sightline {
namespace {

constexpr uint32_t magic_gltf = 0x46546C67, chunk_json = 0x4E4F534A, chunk_bin = 0x004E4942;
constexpr size_t max_json_bytes = size_t{1} << 30;
constexpr int max_depth = 500;  // the deepest property of glTF 2.0 and its extensions is at 12

uint32_t read_uint32(std::span<const std::byte> bytes, size_t offset) {
    return static_cast<uint32_t>(little_endian(bytes.subspan(offset, 4)));
}

std::string_view text(std::span<const std::byte> bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// A file may have any number of chunks.
void add_fault(GltfContainer& container, Fault fault, size_t byte, std::string detail) {
    constexpr size_t enough = 16;
    if (container.faults.size() < enough)
        container.faults.push_back({fault, fmt::format("GLB, byte {}", byte), std::move(detail)});
}

GltfContainer split_glb(std::span<const std::byte> file, const std::string& path) {
    const auto fail = [&](size_t offset, const std::string& reason) {
        throw Error(fmt::format("{}: GLB, byte {}: {}", path, offset, reason));
    };
    if (file.size() < 12) fail(0, "the header is truncated");
    if (const uint32_t version = read_uint32(file, 4); version != 2)
        fail(4, fmt::format("version {} instead of 2", version));
    GltfContainer container;
    const uint32_t length = read_uint32(file, 8);
    if (length > file.size())
        fail(8, fmt::format("the header says {} bytes, but there are {}: the file is truncated",
                            length, file.size()));
    if (length < file.size())
        add_fault(container, Fault::glb_chunk, length, "bytes after the GLB's end");

    bool have_json = false;
    for (size_t offset = 12, index = 0; offset < length; ++index) {
        if (length - offset < 8) fail(offset, "a chunk's header is truncated");
        const uint32_t size = read_uint32(file, offset), type = read_uint32(file, offset + 4);
        offset += 8;
        if (size > length - offset) fail(offset - 8, "the chunk is longer than the file");
        const auto data = file.subspan(offset, size);
        if (index == 0) {
            if (type != chunk_json) fail(offset - 4, "the first chunk is not JSON");
            container.json = text(data);
            have_json = true;
        } else if (type == chunk_bin && !container.bin) {
            container.bin = data;
            if (index > 1)
                add_fault(container, Fault::glb_chunk, offset - 8, "a chunk before the binary one");
        } else if (type == chunk_json || type == chunk_bin) {
            add_fault(container, Fault::glb_chunk, offset - 8, "a second chunk of the same type");
        }
        // The last chunk's padding may be missing; chunks after an unpadded one are not found.
        if (size % 4 != 0) add_fault(container, Fault::glb_padding, offset - 8, "");
        offset += size;
    }
    if (!have_json) fail(12, "there is no JSON chunk");
    return container;
}

void check_depth(std::string_view json, const std::string& path) {
    int depth = 0;
    bool in_string = false;
    for (size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (in_string) {
            if (c == '\\') ++i;
            if (c == '"') in_string = false;
        } else if (c == '"') {
            in_string = true;
        } else if (c == '[' || c == '{') {
            if (++depth > max_depth) {
                throw Error(fmt::format("{}: JSON, byte {}: nested deeper than {} levels", path, i,
                                        max_depth));
            }
        } else if (c == ']' || c == '}') {
            --depth;
        }
    }
}

// Finds the byte of the first error, which the library's exception for numbers lacks.
struct ErrorFinder : nlohmann::json_sax<nlohmann::json> {
    size_t byte = 0;

    bool null() override { return true; }
    bool boolean(bool) override { return true; }
    bool number_integer(number_integer_t) override { return true; }
    bool number_unsigned(number_unsigned_t) override { return true; }
    bool number_float(number_float_t, const string_t&) override { return true; }
    bool string(string_t&) override { return true; }
    bool binary(binary_t&) override { return true; }
    bool start_object(size_t) override { return true; }
    bool key(string_t&) override { return true; }
    bool end_object() override { return true; }
    bool start_array(size_t) override { return true; }
    bool end_array() override { return true; }
    bool parse_error(size_t position, const std::string&,
                     const nlohmann::json::exception&) override {
        byte = position;
        return false;
    }
};

// "line 3, column 7" of a byte in a text, all counted from 1.
std::string position(std::string_view text, size_t byte) {
    const std::string_view before = text.substr(0, byte > 0 ? byte - 1 : 0);
    const size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
    return fmt::format("line {}, column {}", 1 + std::ranges::count(before, '\n'),
                       before.size() - line_start + 1);
}

}  // namespace

GltfContainer split_container(std::span<const std::byte> file, const std::string& path) {
    const bool is_glb = file.size() >= 4 && read_uint32(file, 0) == magic_gltf;
    GltfContainer container = is_glb ? split_glb(file, path) : GltfContainer{text(file), {}, {}};
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    if (container.json.starts_with(byte_order_mark)) {
        container.json.remove_prefix(byte_order_mark.size());
        container.faults.push_back({Fault::byte_order_mark, "JSON", ""});
    }
    return container;
}

nlohmann::json parse_json(std::string_view text, const std::string& path) {
    const auto fail = [&](const std::string& reason) { throw Error(path + ": JSON: " + reason); };
    const size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) fail("is empty");
    if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"))
        fail("is UTF-16, but glTF must be UTF-8");
    if (text[first] != '{') {
        const auto foreign = describe_foreign_format(path, std::as_bytes(std::span(text)));
        if (!foreign.empty()) throw Error(path + " " + foreign);
        fail("does not begin with '{': not a glTF file");
    }
    if (text.size() > max_json_bytes) fail("is larger than 1 GiB");
    check_depth(text, path);
    try {
        return nlohmann::json::parse(text);
    } catch (const nlohmann::json::parse_error& error) {
        // The library's message repeats the damaged text; the position is more useful.
        fail("is malformed at " + position(text, error.byte));
    } catch (const nlohmann::json::out_of_range&) {
        ErrorFinder finder;
        nlohmann::json::sax_parse(text, &finder);
        fail("a number is out of range at " + position(text, finder.byte));
    }
    return {};
}

}  // namespace sightline
