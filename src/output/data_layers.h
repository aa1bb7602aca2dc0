#pragma once
// Layers as 16-bit PNG files: data sets for other programs (docs/data_sets.md).
#include "output/picture_writer.h"

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sightline {

inline constexpr std::array data_layers = {"depth", "mask", "material", "normal", "object"};

/// What a value v of a file means: (v - zero) * scale. Zero itself: see docs/data_sets.md.
struct DataScale {
    double scale = 1;
    int zero = 0;
};

/// The names of the layers' files, in the order of the layers: "a.depth.png" for "a.png".
std::vector<std::string> data_paths(const std::string& picture,
                                    const std::set<std::string>& layers);

/// The layers of the film that the files are made of.
std::set<std::string> needed_layers(const std::set<std::string>& layers);

/// Writes a layer of a film as a PNG when it is complete.
class DataWriter : public PictureWriter {
  public:
    /// `layer`: of data_layers. `depth_scale`: world units of a step; unset: such that the
    /// picture's greatest depth gets the greatest value. `has_alpha`: the film's alpha says what
    /// surfaces cover.
    DataWriter(std::string layer, const PixelRect& window, std::optional<double> depth_scale,
               bool has_alpha);
    void add(const Film& band) override;
    /// Throws Error, also if a value is too large for 16 bits.
    void finish(const PictureMetadata& metadata, const std::string& path) override;

    const std::string& layer() const { return layer_; }
    /// Of the file that finish() has written.
    const DataScale& scale() const { return scale_; }

  private:
    void quantise_depth(const std::string& path);
    void set_ids(const std::vector<uint32_t>& ids);

    std::string layer_;
    PixelRect window_;
    std::optional<double> depth_scale_;
    bool has_alpha_;
    DataScale scale_;
    std::vector<float> depths_;
    std::vector<uint16_t> values_;
    uint32_t greatest_id_ = 0;
};

}  // namespace sightline
