#include "scene/gltf/json.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {
namespace {

constexpr size_t max_bytes = size_t{1} << 30;
constexpr int max_depth = 500;  // the deepest property of glTF 2.0 and its extensions is at 12

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

// "line 3, column 7" of a byte in a text, all counted from 1.
std::string position(std::string_view text, size_t byte) {
    const std::string_view before = text.substr(0, byte > 0 ? byte - 1 : 0);
    const size_t line_start = before.rfind('\n') + 1;  // npos + 1 is 0
    return fmt::format("line {}, column {}", 1 + std::ranges::count(before, '\n'),
                       before.size() - line_start + 1);
}

}  // namespace

nlohmann::json parse_json(std::string_view text, const std::string& path) {
    const auto fail = [&](const std::string& reason) { throw Error(path + ": JSON: " + reason); };
    const size_t first = text.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) fail("is empty");
    if (text[first] != '{') fail("does not begin with '{': not a glTF file");
    if (text.size() > max_bytes) fail("is larger than 1 GiB");
    check_depth(text, path);
    try {
        return nlohmann::json::parse(text);
    } catch (const nlohmann::json::parse_error& error) {
        // The library's message repeats the damaged text; the position is more useful.
        fail("is malformed at " + position(text, error.byte));
    }
    return {};
}

const nlohmann::json* find_extension(const nlohmann::json& object, const char* name) {
    const auto extensions = object.find("extensions");
    if (extensions == object.end() || !extensions->is_object()) return nullptr;
    const auto extension = extensions->find(name);
    return extension == extensions->end() ? nullptr : &*extension;
}

}  // namespace sightline
