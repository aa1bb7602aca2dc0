#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sightline {

/// `text` as part of one line for a terminal: control characters, characters that break lines or
/// change their direction, and bytes that are not UTF-8 become "\n", "\t" or "\x1b".
std::string printable(std::string_view text);

bool is_utf8(std::string_view text);

/// The text as one word of a bash command; the word is UTF-8 even if the text is not.
std::string shell_quoted(std::string_view text);

/// A duration in seconds as "1:02" or, from an hour, "1:02:03".
std::string clock_text(double seconds);

/// The index of the name that equals `choice`, or else `choice` itself as an index: names may look
/// like numbers.
std::optional<size_t> find_choice(std::span<const std::string> names, std::string_view choice);

/// The names as part of a message: `0 "idle", 1 "walk"`; "none" if there are none.
std::string list_choices(std::span<const std::string> names);

}  // namespace sightline
