#pragma once
// How options are presented, by --help, the manual page and the completions alike.
#include <CLI/CLI.hpp>

namespace sightline {

/// The words of an option that takes only those; else none.
std::vector<std::string> choices_of(const CLI::Option& option);

/// The placeholder of the option's value, such as "N" or "FILE"; "" for a flag.
std::string value_name(const CLI::Option& option);

/// The option's description with its choices and its default.
std::string help_text(const CLI::Option& option);

/// A line of --help: `head`, and `text` wrapped in the column beside it.
std::string table_row(std::string head, const std::string& text);

/// Prints one option per entry, its text wrapped beside it.
std::shared_ptr<CLI::FormatterBase> make_help_formatter();

/// The options added to `app` from now on are listed under this heading.
void begin_group(CLI::App& app, const std::string& heading);

}  // namespace sightline
