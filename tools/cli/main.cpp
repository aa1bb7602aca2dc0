// The program: one subcommand in each <name>.cpp.
#include "commands.h"
#include "core/error.h"
#include "core/file_clash.h"
#include "core/message.h"
#include "core/plain_reason.h"
#include "core/text.h"
#include "core/version.h"
#include "usage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

namespace {

// The command line for the pictures' metadata, without the options that say how a picture was put
// together.
std::vector<std::string> command_line_args(int argc, char** argv) {
    std::vector<std::string> words(argv, argv + argc);
    std::erase(words, "--resume");
    std::erase(words, "--merge-parts");
    return words;
}

// Lists --help last, in the group of the last options.
void move_help_to_the_end(CLI::App& app) {
    app.set_help_flag("-h,--help", "Print this help");
    for (CLI::App* sub : app.get_subcommands({})) move_help_to_the_end(*sub);
}

void add_commands(CLI::App& app, const std::string& command_line) {
    sightline::add_render_command(app, command_line);
    sightline::add_batch_command(app);
    sightline::add_info_command(app);
    sightline::add_faults_command(app);
    sightline::add_diff_command(app);
    sightline::add_compare_command(app, command_line);
    sightline::add_atlas_command(app);
    sightline::add_worker_command(app);
    sightline::add_farm_commands(app);
    sightline::add_manual_command(app);
    move_help_to_the_end(app);
}

}  // namespace

int main(int argc, char** argv) {
    sightline::secure_standard_streams();
    CLI::App app("Sightline renders glTF files on CPUs and compares intersection methods",
                 "sightline");
    app.formatter(sightline::make_help_formatter());
    app.set_version_flag("--version", std::string("sightline ") + sightline::program_version,
                         "Print the version");
    app.require_subcommand(1);
    const std::vector<std::string> words(argv + std::min(argc, 1), argv + argc);
    app.failure_message([&](const CLI::App*, const CLI::Error& error) {
        return sightline::usage_message(app, words, error);
    });
    app.footer(
        "Try `sightline render asset.glb -o picture.png`; `sightline COMMAND --help` lists the "
        "options.");
    try {
        add_commands(app, fmt::format("{}", fmt::join(command_line_args(argc, argv), " ")));
        sightline::check_words(app, words);
        app.parse(argc, argv);
        if (std::fflush(stdout) != 0)
            throw sightline::Error(fmt::format("standard output: {}", std::strerror(errno)));
    } catch (const CLI::RuntimeError& e) {
        return e.get_exit_code();
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? 0 : 2;
    } catch (const sightline::OutputIsInput& e) {
        sightline::print_message("sightline: {}\n", e.what());
        return 2;
    } catch (const std::bad_alloc&) {
        sightline::print_message("sightline: out of memory\n");
        return 1;
    } catch (const std::exception& e) {
        sightline::print_message("sightline: {}\n",
                                 sightline::printable(sightline::plain_reason(e)));
        return 1;
    }
    return 0;
}
