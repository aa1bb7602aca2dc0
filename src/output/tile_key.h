#pragma once
#include "output/options.h"

#include <tuple>

namespace sightline {

// The fields of each value that kept tiles depend on. The list is a structured binding, which does
// not compile unless it names every field, and the tuple made of it.
#define SIGHTLINE_FIELDS(Type, ...)            \
    inline auto fields_of(const Type& value) { \
        const auto& [__VA_ARGS__] = value;     \
        return std::tie(__VA_ARGS__);          \
    }                                          \
    inline auto fields_of(Type& value) {       \
        auto& [__VA_ARGS__] = value;           \
        return std::tie(__VA_ARGS__);          \
    }
SIGHTLINE_FIELDS(PixelRect, x0, y0, x1, y1)
SIGHTLINE_FIELDS(Camera, orthographic, yfov, aspect, xmag, ymag, znear, zfar, to_world, name, fault)
SIGHTLINE_FIELDS(GroundSettings, kind, height, color, mirror)
SIGHTLINE_FIELDS(RenderSettings, width, height, crop, camera, aperture, focus, integrator,
                 single_sided_shadows, depth, samples, error, max_samples, seed, background,
                 background_color, background_blur, ground, full_textures, cutoff, aovs, half)
SIGHTLINE_FIELDS(ImageLimits, max_pixels, max_file_bytes)
SIGHTLINE_FIELDS(LoadOptions, scene, variant, animation, time, strict, allow_outside, decode_images,
                 find_all_faults, images, max_elements, max_accessor_values, max_file_bytes,
                 max_texture_memory, missing_texture)
SIGHTLINE_FIELDS(LightOptions, env, env_rotation, env_brightness, env_blur, background,
                 background_color)
SIGHTLINE_FIELDS(EngineOptions, intersector, isa)
#undef SIGHTLINE_FIELDS

/// Hash of all options of loading.
uint64_t load_options_key(const LoadOptions& options);

/// Hash of everything that the values of a tile depend on: the program's version, the contents of
/// `inputs`, the description of the engine with its instruction set, and all fields of the
/// command's load, light, engine and (complete) settings. The view is in the settings' camera.
uint64_t tile_key(const RenderCommand& command, const std::vector<SourceFile>& inputs,
                  const std::string& engine);

}  // namespace sightline
