#include "scene/gltf/uri.h"

#include "core/error.h"
#include "core/files.h"
#include "scene/gltf/container.h"

#include <algorithm>
#include <filesystem>

namespace sightline {
namespace {

namespace fs = std::filesystem;

bool has_scheme(const std::string& uri) {
    const size_t end = uri.find_first_of(":/?#");
    return end != std::string::npos && end > 0 && uri[end] == ':';
}

// Whether `path` is inside `folder` after resolving symbolic links.
bool is_within(const fs::path& path, const fs::path& folder) {
    const fs::path inner = fs::weakly_canonical(path), outer = fs::canonical(folder);
    return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first ==
           outer.end();
}

fs::path resolve(const Document& document, const std::string& uri, const std::string& place,
                 const LoadOptions& options) {
    if (has_scheme(uri)) document.fail(place, "'" + uri + "' is not a relative path");
    const auto decoded = percent_decode(uri);
    if (!decoded || decoded->empty() || decoded->find('\0') != std::string::npos)
        document.fail(place, "'" + uri + "' is not a valid URI");
    const fs::path file(document.path);
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    const fs::path path = folder / *decoded;
    try {
        if (!options.allow_outside && !is_within(path, folder)) {
            document.fail(place,
                          "'" + uri + "' is outside the file's folder (see --allow-outside)");
        }
        if (!fs::is_regular_file(path))
            document.fail(place, "'" + uri + "' is not an existing file");
    } catch (const fs::filesystem_error& error) {
        document.fail(place, "'" + uri + "': " + error.code().message());
    }
    return path;
}

}  // namespace

std::vector<std::byte> read_uri(Document& document, const std::string& uri,
                                const std::string& place, const LoadOptions& options) {
    std::vector<std::byte> bytes;
    if (is_data_uri(uri)) {
        auto decoded = decode_data_uri(uri);
        if (!decoded) document.fail(place, "is a malformed data URI");
        bytes = std::move(*decoded);
    } else {
        const fs::path path = resolve(document, uri, place, options);
        try {
            bytes = read_file(path.string(), options.max_file_bytes);
        } catch (const Error& error) {
            document.fail(place, error.what());
        }
        document.add_file(path.string(), bytes);
    }
    return bytes;
}

}  // namespace sightline
