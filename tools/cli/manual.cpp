// The manual page and the shells' completions, written from the options themselves, so that they
// cannot tell anything else than --help.
#include "core/version.h"
#include "options.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string_view>

namespace sightline {
namespace {

using Options = std::vector<const CLI::Option*>;

// Subcommands that are for people; the others have no group.
std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App* a) { return !a->get_group().empty(); });
}

bool is_flag(const CLI::Option& option) { return option.get_expected_max() == 0; }

Options options_of(const CLI::App& app, bool positional) {
    return app.get_options([positional](const CLI::Option* o) {
        return o->get_positional() == positional && !o->get_group().empty();
    });
}

// "-o", "--output"
std::vector<std::string> names_of(const CLI::Option& option) {
    std::vector<std::string> names;
    for (const std::string& name : option.get_snames()) names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
    return names;
}

// The words that an option takes, if it takes only those: its type name ends in {a,b,c}.
std::vector<std::string> choices_of(const CLI::Option& option) {
    const std::string type = option.get_type_name();
    const size_t open = type.find('{');
    if (open == std::string::npos || type.back() != '}') return {};
    return CLI::detail::split(type.substr(open + 1, type.size() - open - 2), ',');
}

// What the option's value is called, without how it is checked.
std::string value_of(const CLI::Option& option) {
    const auto choices = choices_of(option);
    const std::string type = option.get_type_name();
    return choices.empty() ? type.substr(0, type.find(':'))
                           : fmt::format("{}", fmt::join(choices, "|"));
}

bool takes_file(const CLI::Option& option) {
    const std::string value = value_of(option);
    return value.starts_with("FILE") || value.starts_with("DIR");
}

std::string roff(std::string_view text) {
    std::string result;
    for (const char c : text) {
        if (c == '\\') {
            result += "\\e";
        } else if (c == '-') {
            result += "\\-";
        } else if (c == '\'') {
            result += "\\(aq";
        } else {
            result += c;
        }
    }
    return result.starts_with('.') ? "\\&" + result : result;
}

std::string entry_of(const CLI::Option& option) {
    std::string head =
        fmt::format("\\fB{}\\fR", roff(fmt::format("{}", fmt::join(names_of(option), ", "))));
    if (option.get_positional()) head = "\\fI" + roff(option.get_name(true)) + "\\fR";
    if (!option.get_positional() && !is_flag(option))
        head += " \\fI" + roff(value_of(option)) + "\\fR";
    std::string text = option.get_description();
    if (!option.get_default_str().empty()) text += fmt::format(" [{}]", option.get_default_str());
    return fmt::format(".TP\n{}\n{}\n", head, roff(text));
}

constexpr std::string_view manual_head = R"(.TH SIGHTLINE 1 "" "Sightline {}" "User Commands"
.SH NAME
sightline \- render glTF 2.0 assets on CPUs
.SH SYNOPSIS
.B sightline render
\fISCENE\fR \fB\-o\fR \fIFILE\fR [\fIOPTION\fR...]
.br
.B sightline batch
\fIINPUT\fR... \fB\-\-out\fR \fIDIR\fR [\fIOPTION\fR...]
.br
.B sightline
\fICOMMAND\fR \fB\-\-help\fR
.SH DESCRIPTION
Sightline makes pictures of glTF files without a graphics card, a display or a browser; the same
command gives the same bits for any number of threads.
A file without a camera is framed, one without light gets a neutral studio.
.SH COMMANDS
)";

constexpr std::string_view manual_tail = R"(.SH EXIT STATUS
.TP
.B 0
All is well.
.TP
.B 1
A file or the machine is at fault; one line on standard error says which and why.
.TP
.B 2
Wrong usage.
.TP
.B 3
A batch in which some assets failed, or changed under \fB\-\-fail\-on\-change\fR.
.SH EXAMPLES
.nf
sightline render chair.glb \-o chair.png \-o layers.exr \-\-size 800x800
sightline batch assets/ \-\-out pictures \-\-views front,left \-\-resume
.fi
.SH SEE ALSO
/usr/share/doc/sightline
)";

// An option that means the same elsewhere is told once, with the first command that has it.
std::string manual(const CLI::App& app) {
    std::string text = fmt::format(fmt::runtime(manual_head), program_version);
    std::map<std::string, std::string> told;  // the command by the entry
    for (const CLI::App* command : commands_of(app)) {
        text += fmt::format(".SS sightline {}\n{}.\n", command->get_name(),
                            roff(command->get_description()));
        std::map<std::string, std::vector<std::string>> elsewhere;
        for (const bool positional : {true, false})
            for (const CLI::Option* option : options_of(*command, positional)) {
                const std::string entry = entry_of(*option);
                const auto [first, is_new] = told.emplace(entry, command->get_name());
                if (is_new)
                    text += entry;
                else
                    elsewhere[first->second].push_back(option->get_positional()
                                                           ? option->get_name(true)
                                                           : names_of(*option).back());
            }
        for (const auto& [first, names] : elsewhere)
            text += fmt::format(".PP\nAs for \\fB{}\\fR: {}.\n", first,
                                roff(fmt::format("{}", fmt::join(names, ", "))));
    }
    return text + std::string(manual_tail);
}

constexpr std::string_view bash_script = R"(# Completion for bash.
_sightline() {{
    local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}}
    local command=${{COMP_WORDS[1]}} words='' files=''
    # --option=value comes as three words.
    if [[ $current == = ]]; then
        current=''
    elif [[ $previous == = ]]; then
        previous=${{COMP_WORDS[COMP_CWORD - 2]}}
    fi
    if ((COMP_CWORD == 1)); then
        words='{commands}--help --version'
    else
        case "$command $previous" in
{values}            *) case "$command $current" in
{names}                *) files=yes ;;
            esac ;;
        esac
    fi
    if [[ $files ]]; then
        compopt -o filenames 2> /dev/null
        mapfile -t COMPREPLY < <(compgen -f -- "$current")
    else
        mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
    fi
}}
complete -F _sightline sightline
)";

std::string bash(const CLI::App& app) {
    std::string commands, values, names;
    for (const CLI::App* command : commands_of(app)) {
        const std::string& name = command->get_name();
        commands += name + " ";
        std::vector<std::string> all;
        for (const CLI::Option* option : options_of(*command, false))
            for (const std::string& spelling : names_of(*option)) {
                all.push_back(spelling);
                if (is_flag(*option)) continue;
                values += fmt::format(
                    "            '{} {}') {} ;;\n", name, spelling,
                    takes_file(*option)
                        ? "files=yes"
                        : fmt::format("words='{}'", fmt::join(choices_of(*option), " ")));
            }
        names += fmt::format("                '{} -'*) words='{}' ;;\n", name, fmt::join(all, " "));
    }
    return fmt::format(fmt::runtime(bash_script), fmt::arg("commands", commands),
                       fmt::arg("values", values), fmt::arg("names", names));
}

// A text within the single quotes of zsh's _arguments.
std::string zsh_quoted(std::string_view text) {
    std::string result;
    for (const char c : text) {
        if (c == '\'') {
            result += "'\\''";
        } else {
            if (c == '[' || c == ']' || c == ':' || c == '\\') result += '\\';
            result += c;
        }
    }
    return result;
}

std::string zsh_option(const CLI::Option& option) {
    const auto choices = choices_of(option);
    const std::string offer = takes_file(option) ? "_files"
                              : choices.empty()  ? ""
                                                 : fmt::format("({})", fmt::join(choices, " "));
    std::string text;
    for (const std::string& name : names_of(option)) {
        // A long one may also have its value after =.
        const char* joined = is_flag(option) ? "" : name.starts_with("--") ? "=" : "+";
        text += fmt::format(
            " \\\n            '*{}{}[{}]{}'", name, joined, zsh_quoted(option.get_description()),
            is_flag(option) ? "" : fmt::format(":{}:{}", zsh_quoted(value_of(option)), offer));
    }
    return text;
}

std::string zsh(const CLI::App& app) {
    std::string commands, cases;
    for (const CLI::App* command : commands_of(app)) {
        commands +=
            fmt::format(" '{}:{}'", command->get_name(), zsh_quoted(command->get_description()));
        cases += fmt::format("        {})\n            _arguments", command->get_name());
        for (const CLI::Option* option : options_of(*command, false)) cases += zsh_option(*option);
        cases += " \\\n            '*:file:_files' ;;\n";
    }
    return fmt::format(
        "#compdef sightline\n# Completion for zsh.\n"
        "local -a commands=({} --help --version)\n"
        "if ((CURRENT == 2)); then\n    _describe command commands\nelse\n"
        "    local command=$words[2]\n    shift words\n    ((CURRENT--))\n"
        "    case $command in\n{}    esac\nfi\n",
        commands.substr(1), cases);
}

}  // namespace

void add_manual_command(CLI::App& app) {
    const auto form = std::make_shared<std::string>();
    CLI::App* sub = app.add_subcommand("manual", "The manual page, or a shell's completion");
    sub->group("");  // for installing
    sub->add_option("FORM", *form)->required()->check(CLI::IsMember({"man", "bash", "zsh"}));
    sub->callback([&app, form] {
        fmt::print("{}", *form == "man" ? manual(app) : *form == "bash" ? bash(app) : zsh(app));
    });
}

}  // namespace sightline
