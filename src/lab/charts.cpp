#include "lab/charts.h"

#include "core/error.h"
#include "core/files.h"
#include "core/message.h"
#include "core/run_program.h"
#include "output/output_folder.h"
#include "output/web_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <list>
#include <vector>

namespace sightline {

/// The text of tools/charting/looks.json, compiled in by the build.
extern const char* const looks_json;

namespace {

namespace fs = std::filesystem;

constexpr uintmax_t max_drawing_bytes = 1 << 26;
constexpr int no_matplotlib = 3;  // exit code of tools/charts

/// Debian's Python first: another one in the PATH has no packages of Debian.
constexpr std::array<const char*, 2> pythons = {"/usr/bin/python3", "python3"};

/// The script's path, both in the build and when installed.
fs::path script() {
    std::error_code ignored;
    const fs::path program = fs::read_symlink("/proc/self/exe", ignored);
    return (program.parent_path() / "../libexec/sightline/charts").lexically_normal();
}

bool is_chart(const fs::path& path) {
    const std::string name = path.filename().string();
    return name.starts_with("chart-") && (name.ends_with(".svg") || name.ends_with(".png"));
}

/// Names of the charts in the folder, sorted.
std::vector<std::string> charts_in(const fs::path& folder) {
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
        if (is_chart(entry.path())) names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    return names;
}

/// A folder for drawings, removed with what is in it.
class DrawingFolder {
  public:
    explicit DrawingFolder(const std::string& report)
        : path_(temporary_for((fs::path(report) / private_folder / "charts").string())) {
        fs::create_directories(path_);
    }
    ~DrawingFolder() {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
    }
    DrawingFolder(const DrawingFolder&) = delete;

    fs::path operator/(const std::string& name) const { return path_ / name; }
    const fs::path& path() const { return path_; }

  private:
    fs::path path_;
};

/// Draws the charts of `results` into `folder`. Returns "" or why there are none.
std::string draw_charts(const DrawingFolder& folder, const std::string& results) {
    const std::string file = (folder / "results.json").string();
    write_text(file, results);
    std::vector<std::string> tried;
    for (const char* name : pythons) {
        const std::string python = find_program(name);
        if (python.empty()) {
            tried.push_back(fmt::format("{} is not installed", name));
            continue;
        }
        try {
            const ProgramEnd end =
                run_program({python, script().string(), "draw", file, (folder / "chart").string()});
            if (end.succeeded()) return "";
            if (end.status != no_matplotlib)
                return fmt::format("{} {} draw ended with {}", python, script().string(), end.how);
            tried.push_back(fmt::format("{} has no matplotlib", python));
        } catch (const Error& error) {
            tried.emplace_back(error.what());
        }
    }
    return fmt::format("{}: install Debian's python3-matplotlib", fmt::join(tried, ", "));
}

std::string file_text(const fs::path& path) {
    const auto bytes = read_file(path.string(), max_drawing_bytes);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The drawings from their <svg> on; HTML does not allow the XML header.
std::string inline_charts(const DrawingFolder& drawings, const std::vector<std::string>& names) {
    std::string html;
    for (const std::string& name : names) {
        if (!name.ends_with(".svg")) continue;
        const std::string text = file_text(drawings / name);
        html += fmt::format("<figure class=\"chart\" id=\"{}\">{}</figure>\n",
                            fs::path(name).stem().string(),
                            text.substr(std::min(text.find("<svg"), text.size())));
    }
    return html;
}

std::string make_page(const Report& report, const std::string& charts, const std::string& problem) {
    nlohmann::ordered_json data = report.data;
    data["no_charts"] = problem;
    data["looks"] = nlohmann::ordered_json::parse(looks_json);
    constexpr std::string_view placeholder = "<!--CHARTS-->";
    std::string page = fill_page(report.page, data);  // contains no other "<!--"
    if (const size_t at = page.find(placeholder); at != std::string::npos)
        page.replace(at, placeholder.size(), charts);
    return page;
}

/// Files that replace others together.
class PendingFiles {
  public:
    explicit PendingFiles(const std::string& folder) : folder_(folder) {}

    void add(const std::string& name, const std::string& text) {
        files_.emplace_back((folder_ / name).string()).write(std::as_bytes(std::span(text)));
    }
    void commit() {
        for (PendingFile& file : files_) file.commit();
    }

  private:
    fs::path folder_;
    std::list<PendingFile> files_;
};

}  // namespace

void claim_report(const std::string& folder, bool overwrite) {
    make_output_folder(folder, "--report");
    std::vector<std::string> names = charts_in(folder);
    names.insert(names.end(), report_files.begin(), report_files.end());
    claim_outputs(folder, names, {}, overwrite);
}

void write_report(const std::string& folder, const Report& report) {
    const DrawingFolder drawings(folder);
    const std::string problem = draw_charts(drawings, report.results);
    const std::vector<std::string> charts = charts_in(drawings.path()), earlier = charts_in(folder);
    if (!problem.empty()) print_message("sightline: no charts: {}\n", problem);
    PendingFiles files(folder);
    for (const std::string& name : charts) files.add(name, file_text(drawings / name));
    files.add("results.csv", report.csv);
    files.add("results.json", report.results + "\n");
    files.add("index.html", make_page(report, inline_charts(drawings, charts), problem));
    claim_outputs(folder, charts, {}, true);
    for (const std::string& name : earlier)
        if (std::ranges::count(charts, name) == 0) fs::remove(fs::path(folder) / name);
    files.commit();
}

}  // namespace sightline
