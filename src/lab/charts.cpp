#include "lab/charts.h"

#include "core/error.h"
#include "core/files.h"
#include "output/output_folder.h"
#include "output/web_page.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <vector>

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr uintmax_t max_drawing_bytes = 1 << 24;

/// The script's path relative to the program, both in the build and when installed.
fs::path script() {
    std::error_code ignored;
    const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
    return program.parent_path() / "../libexec/sightline/charts";
}

/// Runs the command without output; true if it succeeded.
bool run(std::vector<std::string> command) {
    std::vector<char*> arguments;
    for (std::string& argument : command) arguments.push_back(argument.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
        posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_RDWR, 0);
    pid_t process = 0;
    const int failed =
        posix_spawn(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
    posix_spawn_file_actions_destroy(&actions);
    int status = 0;
    if (failed != 0) return false;
    while (waitpid(process, &status, 0) < 0)
        if (errno != EINTR) return false;
    return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// The drawing from its <svg> on; HTML does not allow the XML header.
std::string inline_svg(const fs::path& path) {
    const auto bytes = read_file(path.string(), max_drawing_bytes);
    const std::string text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return text.substr(std::min(text.find("<svg"), text.size()));
}

bool is_chart(const fs::path& path) {
    const std::string name = path.filename().string();
    return name.starts_with("chart-") && (name.ends_with(".svg") || name.ends_with(".png"));
}

/// Names of the charts in the folder, sorted.
std::vector<std::string> charts_in(const std::string& folder) {
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (is_chart(entry.path())) names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    return names;
}

std::string draw_charts(const std::string& folder) {
    const fs::path results = fs::path(folder) / "results.json",
                   drawing = fs::path(folder) / "chart";
    if (!run({script().string(), "draw", results.string(), drawing.string()}))
        return "<p>The charts could not be drawn: this needs Debian's python3-matplotlib. Draw "
               "them later with <code>tools/charts draw results.json chart</code>.</p>\n";
    const std::vector<std::string> charts = charts_in(folder);
    claim_outputs(folder, charts, {}, true);
    std::string html;
    for (const std::string& name : charts)
        if (name.ends_with(".svg"))
            html += fmt::format("<figure class=\"chart\">{}</figure>\n",
                                inline_svg(fs::path(folder) / name));
    return html;
}

}  // namespace

void make_report_folder(const std::string& folder) {
    std::error_code error;
    fs::create_directories(folder, error);
    if (error || !fs::is_directory(folder))
        throw Error(fmt::format("{}: cannot be made a folder: {}", folder,
                                error ? error.message() : "it is a file"));
}

void claim_report(const std::string& folder, bool overwrite) {
    make_report_folder(folder);
    std::vector<std::string> names = charts_in(folder);
    names.insert(names.end(), report_files.begin(), report_files.end());
    claim_outputs(folder, names, {}, overwrite);
}

void write_report_page(const std::string& folder, std::string page,
                       const nlohmann::ordered_json& data) {
    constexpr std::string_view placeholder = "<!--CHARTS-->";
    page.replace(page.find(placeholder), placeholder.size(), draw_charts(folder));
    write_text(folder + "/index.html", fill_page(std::move(page), data));
}

}  // namespace sightline
