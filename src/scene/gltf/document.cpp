#include "scene/gltf/document.h"

#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "core/text.h"
#include "scene/gltf/checks.h"
#include "scene/gltf/compression.h"
#include "scene/gltf/container.h"
#include "scene/gltf/parse.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace sightline {
namespace {

namespace fs = std::filesystem;
using json = nlohmann::json;

constexpr size_t max_json_bytes = size_t{1} << 30;

bool has_scheme(const std::string& uri) {
    const size_t end = uri.find_first_of(":/?#");
    return end != std::string::npos && end > 0 && uri[end] == ':';
}

// Whether `path` lies in `folder`, with symbolic links followed.
bool is_within(const fs::path& path, const fs::path& folder) {
    const fs::path inner = fs::weakly_canonical(path), outer = fs::canonical(folder);
    return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first ==
           outer.end();
}

fs::path resolve(const Document& document, const std::string& uri, const std::string& place,
                 const LoadOptions& options) {
    if (has_scheme(uri)) document.fail(place, "'" + uri + "' is not a relative path");
    const auto decoded = percent_decode(uri);
    if (!decoded || decoded->empty() || decoded->find('\0') != std::string::npos)
        document.fail(place, "'" + uri + "' is not a valid URI");
    const fs::path file(document.path);
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    const fs::path path = folder / *decoded;
    try {
        if (!options.allow_outside && !is_within(path, folder)) {
            document.fail(place, "'" + uri + "' leaves the file's folder (see --allow-outside)");
        }
        if (!fs::is_regular_file(path)) document.fail(place, "'" + uri + "' is not a file there");
    } catch (const fs::filesystem_error& error) {
        document.fail(place, "'" + uri + "': " + error.code().message());
    }
    return path;
}

// "line 3, column 7" of a text's byte, all counted from 1.
std::string position(std::string_view text, size_t byte) {
    const std::string_view before = text.substr(0, byte > 0 ? byte - 1 : 0);
    const size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
    return fmt::format("line {}, column {}", 1 + std::ranges::count(before, '\n'),
                       before.size() - line_start + 1);
}

void parse_json(Document& document, std::string_view text) {
    const size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) document.fail("JSON", "is empty");
    if (text[first] != '{') document.fail("JSON", "does not begin with '{': not a glTF file");
    if (text.size() > max_json_bytes) document.fail("JSON", "is larger than 1 GiB");
    check_json_depth(text, document.path);
    try {
        document.json = json::parse(text);
    } catch (const json::parse_error& error) {
        // The library's message repeats the damaged text; the position is what helps.
        document.fail("JSON", "is malformed at " + position(text, error.byte));
    }
}

bool is_meshopt_fallback(const json& buffer) {
    const json* extension = find_extension(buffer, "EXT_meshopt_compression");
    return extension && extension->is_object() && extension->value("fallback", json()) == true;
}

void load_buffers(Document& document, std::optional<std::span<const std::byte>> bin,
                  const LoadOptions& options) {
    const json& buffers = document.list("buffers");
    for (size_t i = 0; i < buffers.size(); ++i) {
        const json& buffer = buffers[i];
        const std::string place = fmt::format("buffers[{}]", i);
        const auto length = buffer["byteLength"].get<uint64_t>();
        std::span<const std::byte>& bytes = document.buffers.emplace_back();
        if (buffer.contains("uri")) {
            document.storage.push_back(read_uri(document, buffer["uri"], place + ".uri", options));
            bytes = document.storage.back();
        } else if (i == 0 && bin) {
            bytes = *bin;
        } else if (is_meshopt_fallback(buffer)) {
            continue;
        } else {
            document.fail(place, "has no uri, and the file no binary chunk for it");
        }
        if (bytes.size() < length) {
            document.fail(place + ".byteLength",
                          fmt::format("is {}, but there are {} bytes", length, bytes.size()));
        }
        bytes = bytes.first(length);
    }
}

}  // namespace

void Warnings::add(const std::string& line) {
    if (!hashes_.insert(hash_text(line)).second || lines_.size() == most) return;
    lines_.push_back(printable(line));
}

std::vector<std::string> Warnings::lines() const {
    std::vector<std::string> all = lines_;
    if (hashes_.size() > most) all.push_back(fmt::format("… and {} more", hashes_.size() - most));
    return all;
}

void Document::fail(const std::string& place, const std::string& reason) const {
    throw Error(path + ": " + place + ": " + reason);
}

void Document::warn(const std::string& place, const std::string& what) {
    warnings.add(place + ": " + what);
}

const nlohmann::json& Document::list(const char* key) const {
    static const nlohmann::json empty = nlohmann::json::array();
    const auto found = json.find(key);
    return found == json.end() ? empty : *found;
}

void Document::spend(uint32_t accessor) const {
    const GltfAccessor& a = accessors[accessor];
    const uint64_t values = a.count * a.components();
    const std::string place = fmt::format("accessors[{}]", accessor);
    if (a.buffer_view != none) return spend(place, values);
    if (values > zeros_left) fail(place, "too many elements without data are used");
    zeros_left -= values;
}

void Document::spend(const std::string& place, uint64_t values) const {
    if (values > values_left) {
        fail(place, "the numbers used, each as often as it is used, exceed --max-values");
    }
    values_left -= values;
}

void Document::add_file(const std::string& name, std::span<const std::byte> bytes) {
    files.push_back({name, hash_bytes(bytes)});
    content_hash = hash_bytes(std::as_bytes(std::span(&files.back().hash, 1)), content_hash);
}

const json* find_extension(const json& object, const char* name) {
    const auto extensions = object.find("extensions");
    if (extensions == object.end() || !extensions->is_object()) return nullptr;
    const auto extension = extensions->find(name);
    return extension == extensions->end() ? nullptr : &*extension;
}

std::vector<std::byte> read_uri(Document& document, const std::string& uri,
                                const std::string& place, const LoadOptions& options) {
    std::vector<std::byte> bytes;
    if (is_data_uri(uri)) {
        auto decoded = decode_data_uri(uri);
        if (!decoded) document.fail(place, "is a malformed data URI");
        bytes = std::move(*decoded);
    } else {
        const fs::path path = resolve(document, uri, place, options);
        try {
            bytes = read_file(path.string(), options.max_file_bytes);
        } catch (const Error& error) {
            document.fail(place, error.what());
        }
        document.add_file(path.string(), bytes);
    }
    return bytes;
}

Document load_document(const std::string& path, const LoadOptions& options) {
    Document document;
    document.path = path;
    document.values_left = options.max_values;
    document.storage.push_back(read_file(path, options.max_file_bytes));
    document.add_file(path, document.storage.back());
    const GltfContainer container = split_container(document.storage.back(), path);
    for (const std::string& line : container.warnings) document.warnings.add(line);
    parse_json(document, container.json);
    check_structure(document);
    // Ready when the meshes are, which takes as long in many a file.
    if (options.decode_images && !document.list("textures").empty()) preload_image_module();
    check_version_and_extensions(document);
    parse_model(document);
    load_buffers(document, container.bin, options);
    decode_meshopt(document);
    decode_draco(document, options.max_elements);
    check_accessors(document, options.max_elements);
    check_tree(document);
    check_animations(document);
    return document;
}

}  // namespace sightline
