#include "output/formats.h"

#include "core/error.h"
#include "core/files.h"
#include "output/data_layers.h"
#include "output/image_writer.h"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>

namespace sightline {
bool is_exr(const std::string& path) { return extension_of(path) == ".exr"; }

bool is_written_by_module(const std::string& path) {
    const std::string ending = extension_of(path);
    return ending != ".exr" && ending != ".png" && ending != ".jpg" && ending != ".jpeg";
}

std::string alpha_problem(const LightOptions& light, std::span<const std::string> pictures) {
    if (light.background != Background::transparent) return "";
    for (const std::string& picture : pictures)
        if (const std::string ending = extension_of(picture);
            ending == ".jpg" || ending == ".jpeg" || ending == ".hdr")
            return fmt::format(
                "--background transparent: {} cannot hold transparency; use .png, "
                ".webp, .tif or .exr, or another background",
                picture);
    return "";
}

std::string format_problem(const std::string& path) {
    const std::string ending = extension_of(path);
    const bool known = ending == ".exr" || ending == ".png" || ending == ".jpg" ||
                       ending == ".jpeg" || ending == ".tif" || ending == ".tiff" ||
                       ending == ".webp" || ending == ".hdr";
    if (known) return {};
    std::error_code ignored;
    if (std::filesystem::path(path).filename().empty() ||
        std::filesystem::is_directory(path, ignored))
        return fmt::format("{} is a folder; name a picture in it, as in {}", path,
                           (std::filesystem::path(path) / "picture.png").string());
    if (ending.empty())
        return fmt::format(
            "{}: the name has no ending that says the format; use .exr .png .jpg "
            ".tif .webp or .hdr, or .mp4 .webm or .gif for a film, as in {}.png",
            path, path);
    return fmt::format(
        "{}: unknown picture format '{}'; use .exr .png .jpg .tif .webp or .hdr, or .mp4 .webm or "
        ".gif for a film",
        path, ending);
}

std::vector<std::string> files_of(const OutputOptions& output) {
    std::vector<std::string> files = output.pictures;
    if (!files.empty() && !output.data.empty())
        for (const std::string& file : data_paths(files[0], output.data)) files.push_back(file);
    for (const std::string& file : {output.stats, output.record_rays})
        if (!file.empty()) files.push_back(file);
    return files;
}

void check_place(const std::string& path) {
    const auto folder = std::filesystem::path(write_target(path)).parent_path();
    const std::string place = folder.empty() ? "." : folder.string();
    if (!std::filesystem::is_directory(place))
        throw Error(fmt::format("{}: the folder {} does not exist", path, place));
    if (access(place.c_str(), W_OK) != 0)
        throw Error(fmt::format("{}: the folder {} cannot be written", path, place));
}

void check_output(const std::string& path) {
    const std::string problem = format_problem(path);
    if (!problem.empty()) throw Error(problem);
    check_place(path);
}

std::unique_ptr<PictureWriter> make_picture_writer(const std::string& path, const Film& layout,
                                                   const PictureMetadata& metadata,
                                                   const OutputOptions& options, bool alpha) {
    const std::string ending = extension_of(path);
    if (ending == ".exr") return make_exr_writer(path, layout, metadata, options.exr);
    ImageWriter::Convert convert;
    if (ending == ".hdr") {
        convert = [exposure = options.exposure](const Film& band) {
            return linear_picture(band, exposure);
        };
    } else {
        const bool keep = alpha && ending != ".jpg" && ending != ".jpeg";
        const auto view = find_color_view(options.color_view);
        convert = [options, keep, view](const Film& band) {
            return display_picture(band, {options.tone_map, view.get()}, options.exposure, keep,
                                   options.alpha_for);
        };
    }
    return std::make_unique<ImageWriter>(layout.window, std::move(convert));
}

}  // namespace sightline
