#include "output/write.h"

#include "core/error.h"
#include "core/files.h"
#include "image/write_image.h"

#include <fmt/format.h>
#include <unistd.h>

#include <filesystem>

namespace sightline {
namespace {

/// `window`: of the whole picture, so that its memory is got once.
void append_rows(Image& picture, const Image& rows, const PixelRect& window) {
    if (picture.empty()) {
        picture.width = rows.width;
        picture.channels = rows.channels;
        const size_t values = static_cast<size_t>(window.width()) *
                              static_cast<size_t>(window.height() * rows.channels);
        rows.bytes.empty() ? picture.floats.reserve(values) : picture.bytes.reserve(values);
    }
    picture.height += rows.height;
    picture.bytes.insert(picture.bytes.end(), rows.bytes.begin(), rows.bytes.end());
    picture.floats.insert(picture.floats.end(), rows.floats.begin(), rows.floats.end());
}

class DisplayWriter : public PictureWriter {
  public:
    DisplayWriter(std::string path, const DisplaySettings& settings, const PixelRect& window)
        : path_(std::move(path)), rows_(settings, window) {}
    void add(const Film& band) override { rows_.add(band); }
    void finish(const PictureInfo&) override { write_image(path_, rows_.picture()); }

  private:
    std::string path_;
    DisplayGatherer rows_;
};

class HdrWriter : public PictureWriter {
  public:
    HdrWriter(std::string path, float exposure, const PixelRect& window)
        : path_(std::move(path)), exposure_(exposure), window_(window) {}
    void add(const Film& band) override {
        append_rows(picture_, linear_picture(band, exposure_), window_);
    }
    void finish(const PictureInfo&) override { write_image(path_, picture_); }

  private:
    std::string path_;
    float exposure_;
    PixelRect window_;
    Image picture_;
};

}  // namespace

bool is_exr(const std::string& path) { return extension_of(path) == ".exr"; }

std::string format_problem(const std::string& path) {
    const std::string ending = extension_of(path);
    const bool known = ending == ".exr" || ending == ".png" || ending == ".jpg" ||
                       ending == ".jpeg" || ending == ".tif" || ending == ".tiff" ||
                       ending == ".webp" || ending == ".hdr";
    if (known) return {};
    return fmt::format("{}: unknown picture format '{}'; use .exr .png .jpg .tif .webp or .hdr",
                       path, ending);
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
                                                   const PictureInfo& info,
                                                   const WriteSettings& settings) {
    const std::string ending = extension_of(path);
    if (is_exr(path)) return make_exr_writer(path, layout, info, settings.exr);
    if (ending == ".hdr")
        return std::make_unique<HdrWriter>(path, settings.display.exposure, layout.window);
    DisplaySettings display = settings.display;
    display.alpha = display.alpha && ending != ".jpg" && ending != ".jpeg";
    return std::make_unique<DisplayWriter>(path, display, layout.window);
}

void DisplayGatherer::add(const Film& band) {
    append_rows(picture_,
                display_picture(band, settings_.tone_map, settings_.exposure, settings_.alpha),
                window_);
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
