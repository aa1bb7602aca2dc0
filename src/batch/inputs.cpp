#include "batch/inputs.h"

#include "core/error.h"
#include "core/files.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <filesystem>

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

std::vector<AssetRequest> search_folder(const fs::path& folder, const fs::path& base,
                                        const RenderSpec& spec) {
    std::vector<AssetRequest> requests;
    for (const auto& entry :
         fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied)) {
        std::error_code ignored;
        if (is_asset(entry.path()) && entry.is_regular_file(ignored))
            requests.push_back(make_request(entry.path(), base, spec));
    }
    return requests;
}

// The folder that holds the path component with the first wildcard.
fs::path base_of(const std::string& pattern) {
    const size_t slash = pattern.substr(0, pattern.find_first_of("*?[")).rfind('/');
    if (slash == std::string::npos) return "";
    return pattern.substr(0, std::max<size_t>(slash, 1));
}

std::vector<AssetRequest> expand_pattern(const std::string& pattern, const RenderSpec& spec) {
    std::vector<AssetRequest> requests;
    glob_t found{};
    glob(pattern.c_str(), 0, nullptr, &found);
    for (size_t i = 0; i < found.gl_pathc; ++i) {
        const fs::path path(found.gl_pathv[i]);
        const fs::path base = base_of(pattern);
        if (fs::is_directory(path)) {
            std::ranges::move(search_folder(path, base, spec), std::back_inserter(requests));
        } else if (is_asset(path)) {
            requests.push_back(make_request(path, base, spec));
        }
    }
    globfree(&found);
    return requests;
}

}  // namespace

std::vector<AssetRequest> find_assets(const std::string& input, const RenderSpec& spec) {
    std::vector<AssetRequest> requests;
    try {
        const fs::path path = fs::path(input).lexically_normal();
        if (fs::is_directory(path)) {
            requests = search_folder(path, path, spec);
        } else if (fs::exists(path)) {
            requests = {make_request(path, path.parent_path(), spec)};
        } else {
            requests = expand_pattern(input, spec);
        }
    } catch (const fs::filesystem_error& e) {
        throw Error(fmt::format("{}: {}", input, e.code().message()));
    }
    if (requests.empty()) throw Error(input + ": no such file, or no .gltf or .glb file in it");
    std::ranges::sort(requests, {}, &AssetRequest::name);
    return requests;
}

}  // namespace sightline
