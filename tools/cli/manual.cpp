// The manual page and the shells' completions, generated from the options themselves so that they
// agree with --help.
#include "commands.h"
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

// Subcommands that --help lists; the hidden ones have no group.
std::vector<const CLI::App*> commands_of(const CLI::App& app) {
    return app.get_subcommands([](const CLI::App* a) { return !a->get_group().empty(); });
}

bool is_flag(const CLI::Option& option) { return option.get_expected_max() == 0; }

Options options_of(const CLI::App& app, bool positional) {
    return app.get_options([positional](const CLI::Option* o) {
        return o->get_positional() == positional && !o->get_group().empty();
    });
}

// The arguments, then the options group by group in the order of --help.
Options grouped_options(const CLI::App& command) {
    Options result = options_of(command, true);
    for (const std::string& group : command.get_groups())
        for (const CLI::Option* option : options_of(command, false))
            if (option->get_group() == group) result.push_back(option);
    return result;
}

// "-o", "--output"
std::vector<std::string> option_names(const CLI::Option& option) {
    std::vector<std::string> names;
    for (const std::string& name : option.get_snames()) names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) names.push_back("--" + name);
    return names;
}

bool takes_file(const CLI::Option& option) {
    const std::string value = value_name(option);
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
        fmt::format("\\fB{}\\fR", roff(fmt::format("{}", fmt::join(option_names(option), ", "))));
    if (option.get_positional()) head = "\\fI" + roff(option.get_name(true)) + "\\fR";
    if (!option.get_positional() && !is_flag(option))
        head += " \\fI" + roff(value_name(option)) + "\\fR";
    return fmt::format(".TP\n{}\n{}\n", head, roff(help_text(option)));
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
Sightline renders glTF files without a graphics card, a display or a browser. The same command
gives the same bits for any number of threads.
If the file has no camera, the view is fitted to the scene; if it has no lights, a neutral studio
lights it.
.SH COMMANDS
)";

constexpr std::string_view manual_tail = R"(.SH EXIT STATUS
.TP
.B 0
Success.
.TP
.B 1
A file or the machine is at fault; one line on standard error names the fault.
.TP
.B 2
Wrong usage; one line on standard error names the option.
.TP
.B 3
A batch in which some pictures failed, or changed under \fB\-\-fail\-on\-change\fR.
.TP
.B 4
\fBcompare\fR or \fBatlas\fR found more wrong answers than \fB\-\-max\-wrong\fR allows.
.SH EXAMPLES
.nf
sightline render chair.glb \-o chair.png \-o layers.exr \-\-size 800x800
sightline batch assets/ \-\-out pictures \-\-views front,left \-\-resume
.fi
.SH SEE ALSO
/usr/share/doc/sightline
)";

// Entries that an earlier command has are listed by name only.
std::string command_section(const CLI::App& command, std::map<std::string, std::string>& first) {
    std::string text =
        fmt::format(".SS sightline {}\n{}.\n", command.get_name(), roff(command.get_description()));
    std::map<std::string, std::vector<std::string>> elsewhere;
    std::string group;
    for (const CLI::Option* option : grouped_options(command)) {
        const std::string entry = entry_of(*option);
        const auto [command_with_it, is_new] = first.emplace(entry, command.get_name());
        if (!is_new) {
            elsewhere[command_with_it->second].push_back(
                option->get_positional() ? option->get_name(true) : option_names(*option).back());
            continue;
        }
        if (!option->get_positional() && option->get_group() != group) {
            group = option->get_group();
            text += fmt::format(".PP\n.B {}\n", roff(group));
        }
        text += entry;
    }
    for (const auto& [name, options] : elsewhere)
        text += fmt::format(".PP\nAs for \\fB{}\\fR: {}.\n", name,
                            roff(fmt::format("{}", fmt::join(options, ", "))));
    return text;
}

std::string manual(const CLI::App& app) {
    std::string text = fmt::format(fmt::runtime(manual_head), program_version);
    std::map<std::string, std::string> first;  // the command that has an entry, by the entry
    for (const CLI::App* command : commands_of(app)) text += command_section(*command, first);
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
            for (const std::string& spelling : option_names(*option)) {
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
    const std::string action = takes_file(option) ? "_files"
                               : choices.empty()  ? ""
                                                  : fmt::format("({})", fmt::join(choices, " "));
    std::string text;
    for (const std::string& name : option_names(option)) {
        // A long option may also have its value after =.
        const char* joined = is_flag(option) ? "" : name.starts_with("--") ? "=" : "+";
        text += fmt::format(
            " \\\n            '*{}{}[{}]{}'", name, joined, zsh_quoted(option.get_description()),
            is_flag(option) ? "" : fmt::format(":{}:{}", zsh_quoted(value_name(option)), action));
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
    CLI::App* sub = app.add_subcommand("manual", "Print the manual page or a shell's completion");
    sub->group("");  // hidden: for the installation
    sub->add_option("FORM", *form, "What to print")
        ->required()
        ->type_name("NAME")
        ->check(one_of({"man", "bash", "zsh"}));
    sub->callback([&app, form] {
        fmt::print("{}", *form == "man" ? manual(app) : *form == "bash" ? bash(app) : zsh(app));
    });
}

}  // namespace sightline
