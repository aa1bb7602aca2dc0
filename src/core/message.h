#pragma once
// Progress, warnings and errors for the user, on stderr.
#include <fmt/format.h>

#include <string_view>

namespace sightline {

/// Opens /dev/null for those of stdin, stdout and stderr that are closed, and ignores SIGPIPE. To
/// be called first in main: otherwise the next file that is opened would take the stream's place
/// and receive its text, and a reader that ends early would end the process.
void secure_standard_streams();

/// Writes the text to stderr. If stderr is closed, full or a broken pipe, the text is lost; the
/// work goes on.
void write_message(std::string_view text);

template <class... Arguments>
void print_message(fmt::format_string<Arguments...> format, Arguments&&... arguments) {
    write_message(fmt::format(format, std::forward<Arguments>(arguments)...));
}

}  // namespace sightline
