#include "output/write.h"

#include "core/error.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cctype>
#include <filesystem>

namespace sightline {
namespace {

std::string ending_of(const std::string& path) {
    std::string ending = std::filesystem::path(path).extension().string();
    for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return ending;
}

}  // namespace

void check_output(const std::string& path) {
    const std::string ending = ending_of(path);
    const bool known = ending == ".exr" || ending == ".png" || ending == ".jpg" ||
                       ending == ".jpeg" || ending == ".tif" || ending == ".tiff" ||
                       ending == ".webp" || ending == ".hdr";
    if (!known)
        throw Error(
            fmt::format("{}: unknown picture format '{}'; use .exr .png .jpg .tif .webp "
                        "or .hdr",
                        path, ending));
    const auto folder = std::filesystem::path(path).parent_path();
    const std::string place = folder.empty() ? "." : folder.string();
    if (!std::filesystem::is_directory(place))
        throw Error(fmt::format("{}: the folder {} does not exist", path, place));
    if (access(place.c_str(), W_OK) != 0)
        throw Error(fmt::format("{}: the folder {} cannot be written", path, place));
}

void write_picture(const std::string& path, const Film& film, const PictureInfo& info,
                   const DisplaySettings& settings, unsigned threads) {
    const std::string ending = ending_of(path);
    if (ending == ".exr") {
        write_exr(path, film, info, threads);
    } else if (ending == ".hdr") {
        write_image(path, linear_picture(film, settings.exposure));
    } else {
        const bool alpha = settings.alpha && ending != ".jpg" && ending != ".jpeg";
        write_image(path, display_picture(film, settings.tone_map, settings.exposure, alpha));
    }
}

ToneMap parse_tone_map(const std::string& name) {
    if (name == "none") return ToneMap::linear;
    if (name == "pbr-neutral") return ToneMap::pbr_neutral;
    if (name == "aces") return ToneMap::aces;
    if (name == "agx") return ToneMap::agx;
    throw std::invalid_argument(
        fmt::format("unknown tone map '{}'; use none, pbr-neutral, aces or agx", name));
}

}  // namespace sightline
