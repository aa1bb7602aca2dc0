#include "usage.h"

#include "core/files.h"
#include "core/suggest.h"
#include "core/text.h"
#include "output/formats.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <set>
#include <vector>

namespace sightline {
namespace {

[[noreturn]] void refuse(const std::string& message) { throw CLI::ValidationError(message); }

// Commands that --help lists.
std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App* a) { return !a->get_group().empty(); });
}

bool asks_for_help(const std::string& word) {
    return word == "-h" || word == "--help" || word == "--version";
}

// As CLI11 sees it: -1,2,3 is a value.
bool looks_like_option(const std::string& word) {
    if (word.size() < 2 || word[0] != '-') return false;
    if (word[1] == '-') return word.size() > 2;
    return std::isalpha(static_cast<unsigned char>(word[1])) != 0;
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

std::vector<std::string> long_options(const CLI::App& command) {
    std::vector<std::string> names;
    for (const CLI::Option* option : command.get_options({}))
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    return names;
}

// The words of one command, checked from left to right.
class WordCheck {
  public:
    WordCheck(const CLI::App& app, const CLI::App& command, std::span<const std::string> words)
        : app_(app), command_(command), words_(words) {}

    void run() {
        while (next_ < words_.size()) {
            const std::string& word = words_[next_++];
            if (word == "--") {
                check_arguments_only();
            } else if (looks_like_option(word)) {
                word[1] == '-' ? check_long(word) : check_short(word);
            } else {
                ++arguments_;
                last_argument_ = word;
            }
        }
        check_argument_count();
        check_required();
    }

  private:
    void check_arguments_only() {
        for (; next_ < words_.size(); ++next_) {
            const std::string& word = words_[next_];
            if (const CLI::Option* option = find(word); option && !option->get_positional())
                refuse(
                    fmt::format("{} follows --, after which all words are file names; put "
                                "options before --",
                                word));
            ++arguments_;
            last_argument_ = word;
        }
    }

    void check_long(const std::string& word) {
        const size_t equals = word.find('=');
        const std::string name = word.substr(0, equals);
        const CLI::Option* option = find(name);
        if (!option) refuse_option(name);
        const bool has_value = equals != std::string::npos;
        if (!takes_value(*option) && has_value) refuse(name + " takes no value");
        if (takes_value(*option))
            take_value(*option, name, has_value ? word.c_str() + equals + 1 : nullptr);
    }

    void check_short(const std::string& word) {
        const std::string name = word.substr(0, 2);
        const CLI::Option* option = find(name);
        if (!option)
            refuse(fmt::format("there is no option {}{}", name,
                               word.find('.') == std::string::npos
                                   ? did_you_mean("-" + word, long_options(command_))
                                   : fmt::format("; a file of that name is given as ./{}", word)));
        if (takes_value(*option))
            take_value(*option, name, word.size() > 2 ? word.c_str() + 2 : nullptr);
    }

    const CLI::Option* find(const std::string& name) const {
        return command_.get_option_no_throw(name);
    }

    // `value`: the rest of the word; nullptr if the next word is the value.
    void take_value(const CLI::Option& option, const std::string& name, const char* value) {
        if (value ? *value == 0 : next_ == words_.size() || words_[next_] == "--")
            refuse(fmt::format("{} needs a value, {}", name, value_name(option)));
        if (!value && find(words_[next_].substr(0, words_[next_].find('='))))
            refuse(
                fmt::format("{0} needs a value, {1}, but the option {2} follows; if that is the "
                            "value: {0}={2}",
                            name, value_name(option), words_[next_]));
        const std::string text = value ? value : words_[next_++];
        const auto [earlier, is_first] = values_.emplace(&option, text);
        if (!is_first && option.get_items_expected_max() == 1)
            refuse(fmt::format("{} is given twice, with {} and {}", name,
                               shell_quoted(earlier->second), shell_quoted(text)));
    }

    [[noreturn]] void refuse_option(const std::string& name) const {
        std::string hint = did_you_mean(name, long_options(command_));
        std::vector<std::string> others;
        for (const CLI::App* other : commands_of(app_))
            if (other->get_option_no_throw(name)) others.push_back(other->get_name());
        if (!others.empty()) hint = fmt::format("; it is an option of {}", fmt::join(others, ", "));
        refuse(fmt::format("{} has no option {}{}", command_.get_name(), name, hint));
    }

    std::vector<const CLI::Option*> positionals() const {
        return command_.get_options([](const CLI::Option* o) { return o->get_positional(); });
    }

    void check_argument_count() const {
        int most = 0;
        std::string names;
        for (const CLI::Option* option : positionals()) {
            most += std::min(option->get_items_expected_max(), 1 << 20);
            names += (names.empty() ? "" : " and ") + option->get_name(true);
        }
        if (arguments_ <= most) return;
        const std::string name = command_.get_name(), last = shell_quoted(last_argument_);
        std::string hint;
        if (name == "render")
            hint = format_problem(last_argument_).empty()
                       ? fmt::format("; a picture to write is given as -o {}", last)
                       : "; batch renders several files";
        refuse(fmt::format("the argument {} is one too many: {} takes {}{}", last, name,
                           names.empty() ? "none" : "one " + names, hint));
    }

    void check_required() const {
        int left = arguments_;
        for (const CLI::Option* option : positionals()) {
            if (option->get_required() && left == 0)
                refuse(fmt::format("{} is missing: {}", option->get_name(true),
                                   option->get_description()));
            --left;
        }
        for (const CLI::Option* option : command_.get_options({}))
            if (option->get_required() && !option->get_positional() && !values_.contains(option))
                refuse(fmt::format("{} {} is missing: {}", shortest_name(*option),
                                   value_name(*option), option->get_description()));
    }

    static std::string shortest_name(const CLI::Option& option) {
        return option.get_snames().empty() ? "--" + option.get_lnames()[0]
                                           : "-" + option.get_snames()[0];
    }

    const CLI::App& app_;
    const CLI::App& command_;
    std::span<const std::string> words_;
    size_t next_ = 0;
    int arguments_ = 0;
    std::string last_argument_;
    std::map<const CLI::Option*, std::string> values_;  // the first of each option
};

[[noreturn]] void refuse_command(const CLI::App& app, const std::string& word) {
    std::vector<std::string> names;
    for (const CLI::App* command : commands_of(app)) names.push_back(command->get_name());
    const std::string ending = extension_of(word);
    if (ending == ".gltf" || ending == ".glb")
        refuse(fmt::format("{} is a file where a command is expected; did you mean 'render {}'?",
                           shell_quoted(word), shell_quoted(word)));
    if (looks_like_option(word))
        refuse(fmt::format("{} comes before the command; a command is one of {}", word,
                           fmt::join(names, ", ")));
    const std::string hint = did_you_mean(word, names);
    refuse(fmt::format(
        "there is no command {}{}", shell_quoted(word),
        hint.empty() ? fmt::format("; a command is one of {}", fmt::join(names, ", ")) : hint));
}

}  // namespace

std::string plain_message(const CLI::Error& error) {
    std::string text = error.what();
    const auto replace = [&](const std::string& from, const std::string& to) {
        if (const size_t at = text.find(from); at != std::string::npos)
            text.replace(at, from.size(), to);
    };
    replace(" excludes ", " cannot be combined with ");
    replace(" requires ", " is of use only with ");
    return text;
}

void check_words(const CLI::App& app, std::span<const std::string> words) {
    if (std::ranges::any_of(words, asks_for_help)) return;
    if (words.empty()) {
        std::vector<std::string> names;
        for (const CLI::App* command : commands_of(app)) names.push_back(command->get_name());
        refuse(fmt::format("a command is missing, one of {}", fmt::join(names, ", ")));
    }
    for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
        if (command->get_name() == words[0])
            return WordCheck(app, *command, words.subspan(1)).run();
    refuse_command(app, words[0]);
}

std::string usage_message(const CLI::App& app, std::span<const std::string> words,
                          const CLI::Error& error) {
    std::string command = "sightline";
    for (const CLI::App* sub : commands_of(app))
        if (!words.empty() && sub->get_name() == words[0]) command += " " + words[0];
    const std::string text = printable(plain_message(error));
    return fmt::format("sightline: {}{} see {} --help\n", text, text.ends_with('?') ? "" : ";",
                       command);
}

}  // namespace sightline
