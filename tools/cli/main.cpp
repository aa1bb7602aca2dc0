// The program: one subcommand each in sightline_<name>.cpp.
#include "core/error.h"
#include "core/text.h"
#include "core/version.h"
#include "options.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

namespace {

// The command line as the pictures tell it: how often it took to make them is left out.
std::vector<std::string> told(int argc, char** argv) {
    std::vector<std::string> words(argv, argv + argc);
    std::erase(words, "--resume");
    std::erase(words, "--join");
    return words;
}

// One line, as for any other fault.
std::string usage_message(const CLI::App* app, const CLI::Error& error) {
    std::string command = "sightline";
    for (const CLI::App* sub : app->get_subcommands()) command += " " + sub->get_name();
    return fmt::format("sightline: {}; see {} --help\n", sightline::printable(error.what()),
                       command);
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app("Sightline renders glTF assets on CPUs and compares intersection methods.",
                 "sightline");
    app.set_version_flag("--version", std::string("sightline ") + sightline::program_version);
    app.require_subcommand(1);
    app.failure_message(usage_message);
    app.footer("Try: sightline render asset.glb -o picture.png");
    try {
        const std::string command = fmt::format("{}", fmt::join(told(argc, argv), " "));
        sightline::add_render_command(app, command);
        sightline::add_info_command(app);
        sightline::add_diff_command(app);
        sightline::add_compare_command(app, command);
        sightline::add_batch_command(app);
        sightline::add_worker_command(app);
        sightline::add_farm_commands(app);
        sightline::add_atlas_command(app);
        sightline::add_manual_command(app);
        app.parse(argc, argv);
        if (std::fflush(stdout) != 0)
            throw sightline::Error(fmt::format("standard output: {}", std::strerror(errno)));
    } catch (const CLI::RuntimeError& e) {
        return e.get_exit_code();
    } catch (const CLI::ParseError& e) {
        return app.exit(e) == 0 ? 0 : 2;
    } catch (const std::bad_alloc&) {
        fmt::print(stderr, "sightline: out of memory\n");
        return 1;
    } catch (const std::exception& e) {
        fmt::print(stderr, "sightline: {}\n", sightline::printable(e.what()));
        return 1;
    }
    return 0;
}
