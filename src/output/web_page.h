#pragma once
// Web pages in one file, for the laboratory's reports and the batch's contact sheet.
#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <span>
#include <string>

namespace sightline {

/// The bytes as a data URI of that media type.
std::string data_uri(const std::string& type, std::span<const std::byte> bytes);

/// The page with its "/*DATA*/" replaced by the script's constant `data` and by the functions
/// `byId` and `element` that the pages share. Bytes that are not UTF-8 are replaced.
std::string fill_page(std::string page, const nlohmann::ordered_json& data);

}  // namespace sightline
