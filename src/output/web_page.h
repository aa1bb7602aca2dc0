#pragma once
// Web pages that need no other file.
#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <span>
#include <string>

namespace sightline {

/// The bytes as a data URI of that media type.
std::string data_uri(const std::string& type, std::span<const std::byte> bytes);

/// The page with the data, as the script's constant `data`, in place of its "/*DATA*/", and with
/// it the functions `byId` and `element` that the pages' scripts share. Text that is not UTF-8 is
/// mended.
std::string fill_page(std::string page, const nlohmann::ordered_json& data);

}  // namespace sightline
