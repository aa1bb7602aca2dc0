#include "batch/plan.h"
#include "core/error.h"

#include <fmt/format.h>
#include <glob.h>

#include <algorithm>
#include <filesystem>

namespace sightline {
namespace {

namespace fs = std::filesystem;

bool is_asset(const fs::path& path) {
    std::string ending = path.extension();
    std::ranges::transform(ending, ending.begin(),
                           [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return ending == ".gltf" || ending == ".glb";
}

Order order_of(const fs::path& file, const fs::path& base, const PictureSet& pictures) {
    const fs::path below = file.lexically_relative(base);
    return {fs::absolute(file).lexically_normal(), (below.parent_path() / below.stem()).string(),
            pictures, 0};
}

std::vector<Order> assets_in(const fs::path& folder, const fs::path& base,
                             const PictureSet& pictures) {
    std::vector<Order> orders;
    for (const auto& entry :
         fs::recursive_directory_iterator(folder, fs::directory_options::skip_permission_denied)) {
        std::error_code ignored;
        if (is_asset(entry.path()) && entry.is_regular_file(ignored))
            orders.push_back(order_of(entry.path(), base, pictures));
    }
    return orders;
}

// The folder in which a pattern's first wildcard stands.
fs::path base_of(const std::string& pattern) {
    const size_t slash = pattern.substr(0, pattern.find_first_of("*?[")).rfind('/');
    if (slash == std::string::npos) return "";
    return pattern.substr(0, std::max<size_t>(slash, 1));
}

std::vector<Order> matches_of(const std::string& pattern, const PictureSet& pictures) {
    std::vector<Order> orders;
    glob_t found{};
    glob(pattern.c_str(), 0, nullptr, &found);
    for (size_t i = 0; i < found.gl_pathc; ++i) {
        const fs::path path(found.gl_pathv[i]);
        const fs::path base = base_of(pattern);
        if (fs::is_directory(path)) {
            std::ranges::move(assets_in(path, base, pictures), std::back_inserter(orders));
        } else if (is_asset(path)) {
            orders.push_back(order_of(path, base, pictures));
        }
    }
    globfree(&found);
    return orders;
}

}  // namespace

std::vector<Order> find_assets(const std::string& input, const PictureSet& pictures) {
    std::vector<Order> orders;
    try {
        const fs::path path = fs::path(input).lexically_normal();
        if (fs::is_directory(path)) {
            orders = assets_in(path, path, pictures);
        } else if (fs::exists(path)) {
            orders = {order_of(path, path.parent_path(), pictures)};
        } else {
            orders = matches_of(input, pictures);
        }
    } catch (const fs::filesystem_error& e) {
        throw Error(fmt::format("{}: {}", input, e.code().message()));
    }
    if (orders.empty()) throw Error(input + ": no such file, or no .gltf or .glb in it");
    std::ranges::sort(orders, {}, &Order::name);
    return orders;
}

}  // namespace sightline
