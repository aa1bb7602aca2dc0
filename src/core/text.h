#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace sightline {

/// `text` as part of one line for a terminal: control characters, characters that break lines or
/// turn their direction, and bytes that are no UTF-8 become "\n", "\t" or "\x1b".
std::string printable(std::string_view text);

/// Which of `names` was asked for, by name or, where none is called so, by index: names may look
/// like numbers.
std::optional<size_t> find_choice(std::span<const std::string> names, std::string_view wanted);

/// The same names as part of a message: `0 "idle", 1 "walk"`; "none" where there are none.
std::string list_choices(std::span<const std::string> names);

}  // namespace sightline
