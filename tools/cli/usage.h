#pragma once
// What is said about a command line that is wrong.
#include "help.h"

#include <span>
#include <string>

namespace sightline {

/// Checks the words after the program's name before CLI11 reads them. CLI11 reports what is missing
/// before what is mistyped, and reports some faults without saying where; this names the word.
/// Throws CLI::ParseError for an unknown command or option, an option without its value, a flag
/// with one, a repeated option, and an argument too many or too few.
void check_words(const CLI::App& app, std::span<const std::string> words);

/// CLI11's message in plainer words.
std::string plain_message(const CLI::Error& error);

/// The message about a fault of the command line: one line, with the way to the help.
std::string usage_message(const CLI::App& app, std::span<const std::string> words,
                          const CLI::Error& error);

}  // namespace sightline
