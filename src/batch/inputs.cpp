#include "batch/inputs.h"

#include "core/beneath.h"
#include "core/error.h"
#include "core/files.h"
#include "output/output_folder.h"
#include "scene/foreign_format.h"

#include <fmt/format.h>
#include <glob.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <set>
#include <span>
#include <tuple>

namespace sightline {
namespace {

namespace fs = std::filesystem;

bool is_asset(const fs::path& path) {
    const std::string extension = extension_of(path);
    return extension == ".gltf" || extension == ".glb";
}

AssetRequest make_request(const fs::path& file, const fs::path& base, const RenderSpec& spec) {
    const fs::path below = file.lexically_relative(base);
    return {fs::absolute(file).lexically_normal(), (below.parent_path() / below.stem()).string(),
            spec, 0};
}

// Collects the assets below a folder. Functions of std::filesystem that take an error_code are
// used throughout: what cannot be examined is passed over.
class FolderSearch {
  public:
    FolderSearch(fs::path base, const RenderSpec& spec, InputSearch& search)
        : base_(std::move(base)), spec_(spec), search_(search) {
        std::error_code ignored;
        root_ = fs::canonical(base_.empty() ? "." : base_, ignored);
    }

    std::vector<AssetRequest> requests;

    void visit_folder(const fs::path& folder) {
        std::error_code error;
        // Links may lead to one folder several times, or to one that contains them.
        if (!visited_.insert(fs::canonical(folder, error)).second) return;
        fs::directory_iterator entry(folder, error);
        std::vector<fs::path> paths;
        for (; !error && entry != fs::directory_iterator(); entry.increment(error))
            paths.push_back(entry->path());
        if (error) pass_over(folder, "cannot be read: " + error.message());
        std::ranges::sort(paths);
        for (const fs::path& path : paths) {
            std::error_code ignored;
            visit(path, fs::is_symlink(path, ignored));
        }
    }

    // `may_leave`: whether the path may lead out of the base folder.
    void visit(const fs::path& path, bool may_leave) {
        std::error_code error;
        const fs::file_status status = fs::status(path, error);
        if (may_leave && status.type() == fs::file_type::not_found)
            return pass_over(path, "is a link to something that does not exist");
        const bool is_folder = fs::is_directory(status);
        if (is_folder && path.filename() == private_folder) return;
        if (!is_folder && !is_asset(path)) {
            const std::string foreign = describe_foreign_format(path.string(), {});
            if (!foreign.empty()) pass_over(path, foreign);
            return;
        }
        if (may_leave && leaves(path) && !search_.follow_links)
            return pass_over(path, fmt::format("is a link out of {}; --follow-links follows it",
                                               root_.string()));
        if (is_folder) return visit_folder(path);
        if (!fs::is_regular_file(status))
            return pass_over(path, error ? "cannot be read: " + error.message()
                                         : std::string("is not a regular file"));
        requests.push_back(make_request(path, base_, spec_));
    }

  private:
    // By the rule of the URIs in assets.
    bool leaves(const fs::path& path) const {
        const int fd = open_beneath(root_, path.lexically_relative(base_));
        if (fd < 0) return errno == EXDEV;
        close(fd);
        return false;
    }

    void pass_over(const fs::path& path, const std::string& reason) {
        search_.passed_over.push_back({fs::absolute(path).lexically_normal().string(), reason});
    }

    fs::path base_, root_;
    const RenderSpec& spec_;
    InputSearch& search_;
    std::set<fs::path> visited_;
};

// The folder that holds the path component with the first wildcard.
fs::path base_of(const std::string& pattern) {
    const size_t slash = pattern.substr(0, pattern.find_first_of("*?[")).rfind('/');
    if (slash == std::string::npos) return "";
    return pattern.substr(0, std::max<size_t>(slash, 1));
}

void visit_matches(const std::string& pattern, FolderSearch& search) {
    glob_t found{};
    glob(pattern.c_str(), 0, nullptr, &found);
    for (size_t i = 0; i < found.gl_pathc; ++i) search.visit(found.gl_pathv[i], true);
    globfree(&found);
}

bool is_pattern(const std::string& input) {
    return input.find_first_of("*?[") != std::string::npos;
}

// Why a folder or a pattern has no asset, as far as what was passed over explains it.
std::string reason_without_assets(bool is_folder, std::span<const PassedOver> passed_over) {
    if (!passed_over.empty())
        return fmt::format(
            "no .gltf or .glb file to render; passed over: {}: {}{}", passed_over[0].path,
            passed_over[0].reason,
            passed_over.size() > 1 ? fmt::format(" (and {} more)", passed_over.size() - 1) : "");
    return is_folder ? "no .gltf or .glb file in this folder"
                     : "no .gltf or .glb file matches this pattern";
}

void add_problem(InputSearch& search, const std::string& input, const std::string& reason) {
    if (search.problem.empty()) search.problem = input + ": " + reason;
}

}  // namespace

std::vector<AssetRequest> find_assets(const std::string& input, const RenderSpec& spec,
                                      InputSearch& search) {
    const fs::path path = fs::path(input).lexically_normal();
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    const bool is_folder = fs::is_directory(status);
    if (!is_folder && (fs::exists(status) || !is_pattern(input))) {
        if (!fs::exists(status))
            add_problem(
                search, input,
                status.type() == fs::file_type::none ? error.message() : "no such file or folder");
        return {make_request(path, path.parent_path(), spec)};
    }
    const size_t before = search.passed_over.size();
    FolderSearch found(is_folder ? path : base_of(input), spec, search);
    is_folder ? found.visit_folder(path) : visit_matches(input, found);
    if (found.requests.empty()) {
        const std::string reason =
            reason_without_assets(is_folder, std::span(search.passed_over).subspan(before));
        add_problem(search, input, reason);
        if (search.passed_over.size() == before)
            search.passed_over.push_back({fs::absolute(path).string(), reason});
    }
    std::ranges::sort(found.requests, {}, [](const AssetRequest& request) {
        return std::tie(request.name, request.asset);
    });
    return found.requests;
}

void check_that_one_exists(const std::vector<AssetRequest>& requests, const InputSearch& search) {
    std::error_code ignored;
    const auto exists = [&](const AssetRequest& r) { return fs::exists(r.asset, ignored); };
    if (!search.problem.empty() && std::ranges::none_of(requests, exists))
        throw Error(search.problem);
}

}  // namespace sightline
