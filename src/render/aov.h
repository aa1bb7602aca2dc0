#pragma once
// The layers (AOVs) of a picture: which channels its film has and what they hold.
#include "render/pixel.h"
#include "render/settings.h"

namespace sightline {

/// The layer of what the tone map leaves alone: the part of beauty that the camera sees of
/// background colours and unlit surfaces, and its share of the pixel. Files do not get it.
inline constexpr const char* shown_layer = "shown";

/// The layer of the part of a transparent background that the camera sees, with the shadows on it,
/// and its share of the pixel. Files do not get it.
inline constexpr const char* through_layer = "through";

/// Names and ids of parts of the scene; empty if no layer uses them.
struct LayerNames {
    std::vector<std::string> light_groups;  ///< each once; a light may share one of the two below
    std::vector<uint16_t> group_of_light;   ///< by Scene::lights: lights of one name are one group
    uint16_t environment = 0;               ///< group of the environment and backgrounds
    uint16_t emission = 0;                  ///< group of emissive surfaces
    std::vector<uint32_t> object_ids;       ///< Cryptomatte's, by Scene::instances
    std::vector<uint32_t> material_ids;     ///< Cryptomatte's, by Scene::materials
    bool shown = false;                     ///< the layer shown_layer
};

/// Where a layer writes one pixel.
struct LayerWriter {
    Film& film;
    size_t first_channel, pixel;
    void set(size_t channel, float value) const {
        film.channels[first_channel + channel].values[pixel] = value;
    }
    void set(size_t channel, uint32_t value) const {
        film.channels[first_channel + channel].integers[pixel] = value;
    }
    void set(size_t channel, const Vec3& value) const {
        for (int i = 0; i < 3; ++i) set(channel + static_cast<size_t>(i), value[i]);
    }
};

/// Beauty with alpha and the layers that the settings request.
class Layers {
  public:
    Layers(const Scene& scene, const RenderSettings& settings);

    LayerNames names;
    Film layout;  ///< the channels in the order of the file, without values

    /// Writes the means of one pixel's samples into the film at (x, y), which lies in its window.
    /// The film has the channels of `layout`.
    void resolve_pixel(Film& film, int x, int y, const Pixel& pixel) const;

  private:
    using Resolve = void (*)(const Pixel& pixel, const LayerWriter& out);
    void add(Resolve resolve, const std::vector<std::string>& channels, Channel::Type type);

    struct Layer {
        size_t first_channel;
        Resolve resolve;
    };
    std::vector<Layer> layers_;
};

}  // namespace sightline
