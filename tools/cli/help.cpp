#include "help.h"

#include <fmt/format.h>

#include <sstream>

namespace sightline {
namespace {

constexpr size_t text_column = 30, line_width = 100;

std::string wrap(const std::string& text) {
    std::istringstream words(text);
    std::string result;
    size_t column = text_column;
    for (std::string word; words >> word;) {
        if (column > text_column && column + word.size() >= line_width) {
            result += '\n' + std::string(text_column, ' ');
            column = text_column;
        } else if (column > text_column) {
            result += ' ';
        }
        result += word;
        column += word.size() + 1;
    }
    return result;
}

class HelpFormatter : public CLI::Formatter {
  public:
    HelpFormatter() {
        column_width(text_column);
        label("Positionals", "Arguments");
        label("SUBCOMMAND", "COMMAND");
    }
    // Without CLI11's remark on how many subcommands are required.
    std::string make_description(const CLI::App* app) const override {
        return app->get_description() + ".\n";
    }
    std::string make_help(const CLI::App* app, std::string name,
                          CLI::AppFormatMode mode) const override {
        const std::string text = Formatter::make_help(app, std::move(name), mode);
        return CLI::detail::find_and_replace(text, "\n\n\n", "\n\n");
    }
    // Subcommands inherit the program's footer; only one of their own is printed.
    std::string make_footer(const CLI::App* app) const override {
        const CLI::App* parent = app->get_parent();
        return parent && app->get_footer() == parent->get_footer() ? ""
                                                                   : Formatter::make_footer(app);
    }
    std::string make_option(const CLI::Option* option, bool positional) const override {
        std::string head = "  " + option->get_name(positional, true);
        if (!positional && !value_name(*option).empty()) head += " " + value_name(*option);
        return table_row(std::move(head), help_text(*option));
    }
};

}  // namespace

std::string table_row(std::string head, const std::string& text) {
    head += head.size() + 1 < text_column ? std::string(text_column - head.size(), ' ')
                                          : '\n' + std::string(text_column, ' ');
    return head + wrap(text) + '\n';
}

std::vector<std::string> choices_of(const CLI::Option& option) {
    // one_of() gives them as the validator's description, which CLI11 appends to the type's name.
    const std::string type = option.get_type_name();
    const size_t open = type.find('{');
    if (open == std::string::npos || type.back() != '}') return {};
    return CLI::detail::split(type.substr(open + 1, type.size() - open - 2), ',');
}

std::string value_name(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    return type.substr(0, type.find(':'));
}

std::string help_text(const CLI::Option& option) {
    std::string text = option.get_description();
    const auto choices = choices_of(option);
    if (!choices.empty()) text += fmt::format(": {}", fmt::join(choices, ", "));
    if (!option.get_default_str().empty()) text += fmt::format(" [{}]", option.get_default_str());
    return text;
}

std::shared_ptr<CLI::FormatterBase> make_help_formatter() {
    return std::make_shared<HelpFormatter>();
}

void begin_group(CLI::App& app, const std::string& heading) {
    app.option_defaults()->group(heading);
}

}  // namespace sightline
