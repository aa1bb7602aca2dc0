#pragma once
// Parsing the JSON text of a glTF file. Internal to src/scene.
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace sightline {

/// Parses a glTF file's JSON text. Throws Error with `path` if it is empty, malformed, larger than
/// 1 GiB, or nested so deeply that a recursive parser could overflow the stack.
nlohmann::json parse_json(std::string_view text, const std::string& path);

/// The extension's object within `object` (a JSON object that may have "extensions"), or nullptr.
const nlohmann::json* find_extension(const nlohmann::json& object, const char* name);

}  // namespace sightline
