#include "output/web_page.h"

#include <nlohmann/json.hpp>

namespace sightline {

/// The texts of the files, compiled in by the build.
extern const char* const page_style_css;
extern const char* const page_script_js;

namespace {

void fill_place(std::string& page, std::string_view place, const std::string& text) {
    if (const size_t at = page.find(place); at != std::string::npos)
        page.replace(at, place.size(), text);
}

}  // namespace

std::string data_uri(const std::string& type, std::span<const std::byte> bytes) {
    constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text = "data:" + type + ";base64,";
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t group = 0;
        for (size_t k = 0; k < 3; ++k)
            group = group << 8 | (i + k < bytes.size() ? static_cast<uint32_t>(bytes[i + k]) : 0u);
        for (size_t k = 0; k < 4; ++k)
            text += i + k > bytes.size() ? '=' : digits[group >> (18 - 6 * k) & 63];
    }
    return text;
}

std::string fill_page(std::string page, const nlohmann::ordered_json& data) {
    std::string text = data.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
    // In <script>, "</script>" or "<!--" in an asset's name would end or hide the data.
    for (size_t at = 0; (at = text.find('<', at)) != std::string::npos;)
        text.replace(at, 1, "\\u003c");
    fill_place(page, "/*STYLE*/", page_style_css);
    fill_place(page, "/*SCRIPT*/", page_script_js);
    fill_place(page, "/*DATA*/", text);
    return page;
}

}  // namespace sightline
