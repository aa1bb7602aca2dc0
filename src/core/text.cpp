#include "core/text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstdint>

namespace sightline {
namespace {

// The first UTF-8 character of a text; its size is 0 if the bytes are not UTF-8.
struct Character {
    size_t size = 0;
    uint32_t code = 0;
};

Character first_character(std::string_view text) {
    const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char lead = byte(0);
    if (lead < 0x80) return {1, lead};
    const size_t size = lead >= 0xf8   ? 0
                        : lead >= 0xf0 ? 4
                        : lead >= 0xe0 ? 3
                        : lead >= 0xc0 ? 2
                                       : 0;
    if (size == 0 || size > text.size()) return {};
    uint32_t code = lead & (0x7fu >> size);
    for (size_t i = 1; i < size; ++i) {
        if ((byte(i) & 0xc0) != 0x80) return {};
        code = code << 6 | (byte(i) & 0x3fu);
    }
    constexpr uint32_t least[] = {0, 0, 0x80, 0x800, 0x10000};
    const bool surrogate = code >= 0xd800 && code < 0xe000;
    return code < least[size] || code > 0x10ffff || surrogate ? Character{} : Character{size, code};
}

bool is_plain(uint32_t code) {
    const auto within = [&](uint32_t first, uint32_t last) {
        return code >= first && code <= last;
    };
    return !(within(0, 0x1f) || within(0x7f, 0x9f) || within(0x2028, 0x202e) ||
             within(0x2066, 0x2069));
}

}  // namespace

std::string printable(std::string_view text) {
    std::string result;
    while (!text.empty()) {
        const Character c = first_character(text);
        const std::string_view bytes = text.substr(0, std::max<size_t>(c.size, 1));
        text.remove_prefix(bytes.size());
        if (c.size > 0 && is_plain(c.code))
            result += bytes;
        else if (c.code == '\n' || c.code == '\t')
            result += c.code == '\n' ? "\\n" : "\\t";
        else
            for (const char b : bytes)
                result += fmt::format("\\x{:02x}", static_cast<unsigned char>(b));
    }
    return result;
}

bool is_utf8(std::string_view text) {
    while (!text.empty()) {
        const size_t size = first_character(text).size;
        if (size == 0) return false;
        text.remove_prefix(size);
    }
    return true;
}

std::string shell_quoted(std::string_view text) {
    const bool plain = !text.empty() && std::ranges::all_of(text, [](char c) {
        return std::isalnum(static_cast<unsigned char>(c)) ||
               std::string_view("-_./=,:").find(c) != std::string_view::npos;
    });
    if (plain) return std::string(text);
    const bool utf8 = is_utf8(text);
    std::string result = utf8 ? "'" : "$'";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (utf8 ? c == '\'' : byte >= 0x80 || c == '\'' || c == '\\')
            result += utf8 ? "'\\''" : fmt::format("\\x{:02x}", byte);
        else
            result += c;
    }
    return result + "'";
}

std::string clock_text(double seconds) {
    const auto whole = static_cast<long>(seconds + 0.5);
    if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

std::optional<size_t> find_choice(std::span<const std::string> names, std::string_view choice) {
    const auto named = std::ranges::find(names, choice);
    if (named != names.end()) return static_cast<size_t>(named - names.begin());
    size_t index = 0;
    const char* end = choice.data() + choice.size();
    const auto [stop, error] = std::from_chars(choice.data(), end, index);
    if (error != std::errc() || stop != end || index >= names.size()) return std::nullopt;
    return index;
}

std::string list_choices(std::span<const std::string> names) {
    constexpr size_t max_listed = 20;
    std::string list;
    for (size_t i = 0; i < std::min(names.size(), max_listed); ++i)
        list += fmt::format("{}{} \"{}\"", i ? ", " : "", i, names[i]);
    if (names.size() > max_listed) list += fmt::format(" and {} more", names.size() - max_listed);
    return list.empty() ? "none" : list;
}

}  // namespace sightline
