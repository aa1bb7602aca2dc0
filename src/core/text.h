#pragma once
#include <string>
#include <string_view>

namespace sightline {

/// `text` as part of one line for a terminal: control characters, characters that break lines or
/// turn their direction, and bytes that are no UTF-8 become "\n", "\t" or "\x1b".
std::string printable(std::string_view text);

}  // namespace sightline
