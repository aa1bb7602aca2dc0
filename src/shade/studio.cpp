#include "shade/studio.h"

#include "core/error.h"
#include "core/math.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

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

/// Walls that fade from above into a darker floor, as a paper backdrop does.
float wall(const Vec3& d, float floor, float rise) {
    return floor + rise * smoothstep(-0.9f, 0.7f, d.y);
}

Vec3 add_boxes(std::span<const Softbox> boxes, const Vec3& d, float background) {
    Vec3 color(background);
    for (const Softbox& box : boxes) color += box.tint * (box.radiance * inside(box, d));
    return color;
}

Vec3 studio(const Vec3& d) {
    static const Softbox boxes[] = {
        {normalize(Vec3(0.1f, 1, 0.15f)), 0.9f, 0.7f, 2, {1, 1, 1}},
        {normalize(Vec3(-0.9f, 0.45f, 0.75f)), 0.4f, 0.8f, 5, {1, 0.985f, 0.96f}},
        {normalize(Vec3(1, 0.35f, -0.1f)), 0.3f, 0.9f, 1.4f, {0.96f, 0.98f, 1}},
    };
    return add_boxes(boxes, d, wall(d, 0.16f, 0.24f));
}

Vec3 softbox(const Vec3& d) {
    static const Softbox boxes[] = {
        {normalize(Vec3(-0.6f, 0.9f, 0.7f)), 0.8f, 0.8f, 5, {1, 1, 1}},
    };
    return add_boxes(boxes, d, wall(d, 0.1f, 0.15f));
}

Vec3 three_point(const Vec3& d) {
    static const Softbox boxes[] = {
        {normalize(Vec3(-0.8f, 0.7f, 0.9f)), 0.4f, 0.4f, 9, {1, 0.98f, 0.95f}},
        {normalize(Vec3(1, 0.3f, 0.8f)), 0.6f, 0.6f, 1.5f, {0.96f, 0.98f, 1}},
        {normalize(Vec3(0.5f, 0.8f, -1)), 0.35f, 0.35f, 7, {1, 1, 1}},
    };
    return add_boxes(boxes, d, wall(d, 0.08f, 0.08f));
}

Vec3 outdoor(const Vec3& d) {
    static const Softbox sun{
        normalize(Vec3(-0.5f, 0.8f, 0.55f)), 0.05f, 0.05f, 160, {1, 0.95f, 0.85f}};
    const Vec3 horizon(0.95f, 1, 1.05f), zenith(0.35f, 0.55f, 0.95f), ground(0.3f, 0.28f, 0.25f);
    const float up = smoothstep(0, 0.9f, d.y), above = smoothstep(-0.06f, 0.02f, d.y);
    const Vec3 sky = horizon * (1 - up) + zenith * up;
    return ground * (1 - above) + sky * above + sun.tint * (sun.radiance * inside(sun, d));
}

struct Entry {
    const char* name;
    Vec3 (*radiance)(const Vec3& direction);
};

constexpr Entry entries[] = {
    {"studio", studio}, {"softbox", softbox}, {"three-point", three_point}, {"outdoor", outdoor}};

/// Of each light, over all directions: under the studio, a white surface that lies flat is as
/// bright as 1.23, which the tone map shows as near white; one that faces the front 0.85, the left
/// 0.9 and the right 0.52, so that the sides of a box differ.
constexpr double mean_luminance = 0.65;

Image make_image(Vec3 (*radiance)(const Vec3&)) {
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
            const Vec3 color = radiance(d);
            image.floats.insert(image.floats.end(), {color.x, color.y, color.z});
        }
    }
    return image;
}

void scale_to_mean(Image& image) {
    double sum = 0, weights = 0;
    for (int y = 0; y < image.height; ++y) {
        const double weight = std::sin(M_PI * (y + 0.5) / image.height);
        for (int x = 0; x < image.width; ++x) {
            const float* c = &image.floats[3 * static_cast<size_t>(y * image.width + x)];
            sum += weight * double(luminance(Vec3(c[0], c[1], c[2])));
            weights += weight;
        }
    }
    const auto scale = static_cast<float>(mean_luminance * weights / sum);
    for (float& value : image.floats) value *= scale;
}

}  // namespace

std::span<const std::string> light_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> result;
        for (const Entry& entry : entries) result.emplace_back(entry.name);
        return result;
    }();
    return names;
}

Image light_image(const std::string& name) {
    for (const Entry& entry : entries) {
        if (name != entry.name) continue;
        Image image = make_image(entry.radiance);
        scale_to_mean(image);
        return image;
    }
    throw Error(fmt::format("there is no built-in light '{}'", name));
}

}  // namespace sightline
