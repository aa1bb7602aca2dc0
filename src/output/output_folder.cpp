#include "output/output_folder.h"

#include "core/error.h"
#include "core/files.h"

#include <fmt/format.h>

#include <filesystem>

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t max_claims_bytes = uint64_t{1} << 32;

fs::path claims_file(const std::string& folder) {
    return fs::path(folder) / private_folder / "outputs";
}

/// Names end with a zero byte, which no file name has.
std::set<std::string> read_claims(const std::string& folder) {
    std::set<std::string> names;
    const fs::path path = claims_file(folder);
    if (!fs::exists(path)) return names;
    const auto bytes = read_file(path.string(), max_claims_bytes);
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    for (size_t begin = 0, end; (end = text.find('\0', begin)) != std::string_view::npos;
         begin = end + 1)
        names.emplace(text.substr(begin, end - begin));
    return names;
}

void write_claims(const std::string& folder, const std::set<std::string>& names) {
    std::string text;
    for (const std::string& name : names) (text += name) += '\0';
    fs::create_directories(claims_file(folder).parent_path());
    write_text(claims_file(folder).string(), text);
}

/// Throws Error if a link leads from `root` to a subfolder that is elsewhere.
void check_stays_within(const fs::path& root, const fs::path& subfolder) {
    if (is_within(subfolder.string(), root.string())) return;
    throw Error(
        fmt::format("{}: is a link out of the folder {}; remove it or choose another folder",
                    subfolder.string(), root.string()));
}

}  // namespace

void make_output_folder(const std::string& path, const std::string& option) {
    std::error_code error;
    if (fs::is_directory(path, error)) return;
    if (fs::exists(path, error))
        throw Error(fmt::format("{}: is not a folder; choose another {}", path, option));
    fs::create_directories(path, error);
    if (error)
        throw Error(fmt::format("{}: the folder cannot be made: {}; choose another {}", path,
                                error.message(), option));
}

void claim_outputs(const std::string& folder, std::span<const std::string> names,
                   const std::set<std::string>& own, bool overwrite) {
    const fs::path root(folder);
    check_stays_within(root, root / private_folder);
    const std::set<std::string> earlier = read_claims(folder);
    std::set<std::string> claims = earlier;
    std::set<fs::path> subfolders;
    for (const std::string& name : names) {
        const fs::path path = root / name;
        if (subfolders.insert(path.parent_path()).second)
            check_stays_within(root, path.parent_path());
        const fs::file_status status = fs::symlink_status(path);
        const bool is_own = overwrite || earlier.contains(name) || own.contains(name);
        if (fs::exists(status) && !is_own)
            throw Error(
                fmt::format("{}: was not made by this program; add --overwrite to replace "
                            "it, or choose another folder",
                            path.string()));
        if (fs::is_symlink(status)) fs::remove(path);
        claims.insert(name);
    }
    if (claims.size() > earlier.size()) write_claims(folder, claims);
}

}  // namespace sightline
