#include "output/data_layers.h"

#include "core/error.h"
#include "core/files.h"
#include "image/png.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace sightline {
namespace {

constexpr uint32_t most = 65535;
constexpr int normal_zero = 32768;

const std::vector<float>& values_of(const Film& film, const std::string& channel) {
    const Channel* found = film.find(channel);
    if (!found) throw Error("the layer " + channel + " is missing");  // needed_layers names it
    return found->values;
}

uint16_t word(double value) {
    return static_cast<uint16_t>(std::clamp(std::lround(value), 0L, static_cast<long>(most)));
}

// A direction with steps of 1/32767 about 32768; 0 where there is none.
void add_normal(const Vec3& mean, std::vector<uint16_t>& values) {
    const float length = mean.length();
    for (int c = 0; c < 3; ++c)
        values.push_back(length > 0 ? word(double(mean[c]) / double(length) * 32767.0 + normal_zero)
                                    : uint16_t{0});
}

}  // namespace

std::vector<std::string> data_paths(const std::string& picture,
                                    const std::set<std::string>& layers) {
    std::vector<std::string> paths;
    for (const std::string& layer : layers)
        paths.push_back(
            std::filesystem::path(picture).replace_extension("." + layer + ".png").string());
    return paths;
}

std::set<std::string> needed_layers(const std::set<std::string>& layers) {
    std::set<std::string> needed = layers;
    if (needed.erase("mask")) needed.insert("object");
    return needed;
}

DataWriter::DataWriter(std::string layer, const PixelRect& window,
                       std::optional<double> depth_scale, bool has_alpha)
    : layer_(std::move(layer)), window_(window), depth_scale_(depth_scale), has_alpha_(has_alpha) {}

void DataWriter::add(const Film& band) {
    if (layer_ == "depth") {
        const std::vector<float>& depths = values_of(band, "depth.Z");
        depths_.insert(depths_.end(), depths.begin(), depths.end());
    } else if (layer_ == "normal") {
        const std::vector<float>&x = values_of(band, "normal.X"), &y = values_of(band, "normal.Y"),
              &z = values_of(band, "normal.Z");
        for (size_t i = 0; i < x.size(); ++i) add_normal({x[i], y[i], z[i]}, values_);
    } else if (layer_ == "mask" && has_alpha_) {
        for (const float alpha : values_of(band, "A"))
            values_.push_back(word(double(alpha) * most));
    } else {
        const Channel* ids = band.find(layer_ == "mask" ? "object.id" : layer_ + ".id");
        set_ids(ids->integers);
    }
}

void DataWriter::set_ids(const std::vector<uint32_t>& ids) {
    for (const uint32_t id : ids) {
        greatest_id_ = std::max(greatest_id_, id);
        values_.push_back(static_cast<uint16_t>(layer_ == "mask" ? (id ? most : 0) : id));
    }
}

void DataWriter::quantise_depth(const std::string& path) {
    float greatest = 0;
    for (const float depth : depths_)
        if (std::isfinite(depth)) greatest = std::max(greatest, depth);
    scale_.scale = depth_scale_.value_or(greatest > 0 ? double(greatest) / most : 1.0);
    if (double(greatest) / scale_.scale > most + 0.5)
        throw Error(
            fmt::format("{}: a depth of {} is more than 65535 steps of {}; use a "
                        "--depth-scale of {} or more",
                        path, greatest, scale_.scale, double(greatest) / most));
    values_.reserve(depths_.size());
    // 0 is where nothing was hit, so what lies before the first step belongs to it.
    for (const float depth : depths_)
        values_.push_back(std::isfinite(depth) && depth >= 0
                              ? std::max(uint16_t{1}, word(double(depth) / scale_.scale))
                              : uint16_t{0});
}

void DataWriter::finish(const PictureMetadata&, const std::string& path) {
    if (layer_ == "depth") quantise_depth(path);
    if (layer_ == "normal") scale_ = {1.0 / 32767.0, normal_zero};
    if (layer_ == "mask") scale_ = {1.0 / most, 0};
    if (greatest_id_ > most && layer_ != "mask")
        throw Error(fmt::format("{}: {} {}s are more than a 16-bit PNG can number; use .exr", path,
                                greatest_id_, layer_));
    DataImage image{
        window_.width(), window_.height(), layer_ == "normal" ? 3 : 1, std::move(values_), {}};
    image.texts = {{"sightline:layer", layer_},
                   {"sightline:scale", fmt::format("{}", scale_.scale)},
                   {"sightline:zero", fmt::format("{}", scale_.zero)}};
    write_file(path, encode_png(image));
}

}  // namespace sightline
