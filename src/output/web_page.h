#pragma once
// Web pages in one file, for the laboratory's reports and the batch's contact sheet.
#include <nlohmann/json_fwd.hpp>

#include <cstddef>
#include <span>
#include <string>

namespace sightline {

/// The bytes as a data URI of that media type.
std::string data_uri(const std::string& type, std::span<const std::byte> bytes);

/// The page with its places filled: "/*STYLE*/" with the style and "/*SCRIPT*/" with the functions
/// that pages share (page_style.css, page_script.js), and "/*DATA*/", in a script element with id
/// `data`, with the data as JSON. Bytes that are not UTF-8 are replaced.
std::string fill_page(std::string page, const nlohmann::ordered_json& data);

}  // namespace sightline
