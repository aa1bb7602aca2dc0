#include "shade/studio.h"

#include "core/math.h"

#include <algorithm>

namespace sightline {
namespace {

float smoothstep(float low, float high, float x) {
    const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
    return t * t * (3 - 2 * t);
}

/// A rectangular lamp at infinity: its centre and half its extents, as tangents of angles.
struct Softbox {
    Vec3 direction;
    float half_width, half_height;
    float radiance;
    Vec3 tint;
};

/// Falloff of the lamp in direction d: 1 inside, with soft edges.
float inside(const Softbox& box, const Vec3& d) {
    const float towards = dot(d, box.direction);
    if (towards <= 0) return 0;
    const Vec3 up = std::fabs(box.direction.y) > 0.9f ? Vec3(0, 0, 1) : Vec3(0, 1, 0);
    const Vec3 right = normalize(cross(up, box.direction));
    const float x = std::fabs(dot(d, right)) / towards / box.half_width;
    const float y = std::fabs(dot(d, cross(box.direction, right))) / towards / box.half_height;
    return (1 - smoothstep(0.8f, 1.1f, x)) * (1 - smoothstep(0.8f, 1.1f, y));
}

}  // namespace

Image studio_image() {
    const Softbox boxes[] = {
        {normalize(Vec3(0.1f, 1, 0.15f)), 0.9f, 0.7f, 3.2f, {1, 1, 1}},
        {normalize(Vec3(-0.9f, 0.45f, 0.75f)), 0.4f, 0.8f, 2.4f, {1, 0.985f, 0.96f}},
        {normalize(Vec3(1, 0.35f, -0.1f)), 0.3f, 0.9f, 1.8f, {0.96f, 0.98f, 1}},
    };
    Image image;
    image.width = 256;
    image.height = 128;
    image.channels = 3;
    image.floats.reserve(static_cast<size_t>(256) * 128 * 3);
    for (int y = 0; y < image.height; ++y) {
        const float theta = pi * (static_cast<float>(y) + 0.5f) / 128;
        for (int x = 0; x < image.width; ++x) {
            const float phi = 2 * pi * ((static_cast<float>(x) + 0.5f) / 256 - 0.5f);
            const Vec3 d(std::cos(phi) * std::sin(theta), std::cos(theta),
                         std::sin(phi) * std::sin(theta));
            // Below the horizon the walls fade into a darker floor, as a paper backdrop does.
            const float wall = 0.16f + 0.24f * smoothstep(-0.9f, 0.7f, d.y);
            Vec3 color(wall);
            for (const Softbox& box : boxes) color += box.tint * (box.radiance * inside(box, d));
            image.floats.insert(image.floats.end(), {color.x, color.y, color.z});
        }
    }
    return image;
}

}  // namespace sightline
