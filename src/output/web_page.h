#pragma once
// Web pages that need no other file.
#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <span>
#include <string>

namespace sightline {

/// The bytes as a data URI of that media type.
std::string data_uri(const std::string& type, std::span<const std::byte> bytes);

/// The page with the data in place of its "/*DATA*/null"; text that is not UTF-8 is mended.
std::string fill_page(std::string page, const nlohmann::json& data);

}  // namespace sightline
