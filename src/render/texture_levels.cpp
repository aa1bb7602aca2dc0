#include "render/texture_levels.h"

#include "core/parallel.h"
#include "render/camera_rays.h"
#include "scene/shape_bounds.h"
#include "shade/bsdf.h"
#include "shade/compiled_material.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace sightline {
namespace {

constexpr int coarsest = 16;

/// A texture of a material, as far as it decides on density.
struct TextureUse {
    uint32_t image, texcoord;
    Vec2 across, down;  // of a unit of u and v, in texels

    bool operator==(const TextureUse&) const = default;
};

bool has_mipmaps(const Texture& sampler) {
    return sampler.min != Filter::nearest && sampler.min != Filter::linear;
}

/// Whether shadow rays or the sampling of emitters read the texture, which they do without a
/// footprint: coverage, the tint of what transmits, emission and the coat before it.
bool is_read_whole(const Material& m, TextureSlot slot) {
    if (m.transmission_factor > 0 || m.diffuse_transmission_factor > 0) return true;
    const bool emits = max_component(m.emissive_factor) > 0 && !m.unlit;
    if (emits && (slot == TextureSlot::emissive || m.clearcoat_factor > 0)) return true;
    return m.alpha_mode != AlphaMode::opaque && slot == TextureSlot::base_color;
}

/// The density of a texture on one triangle: infinite if it has no area, 0 if it is unknown.
double density(const Mesh& mesh, const std::array<uint32_t, 3>& corners, const TextureUse& use) {
    const Vec3d p(mesh.positions[corners[0]]);
    const Vec3d e1 = Vec3d(mesh.positions[corners[1]]) - p;
    const Vec3d e2 = Vec3d(mesh.positions[corners[2]]) - p;
    const double e = dot(e1, e1), f = dot(e1, e2), g = dot(e2, e2);
    const double area4 = e * g - f * f;
    if (!(area4 > 0)) return std::numeric_limits<double>::infinity();
    const std::vector<Vec2>& uvs = mesh.texcoords[use.texcoord];
    const auto texels = [&](uint32_t corner) {
        const Vec2 d = uvs[corner] - uvs[corners[0]];
        return Imath::V2d(use.across * d.x + use.down * d.y);
    };
    const Imath::V2d a = texels(corners[1]), b = texels(corners[2]);
    // J·Jᵀ for the Jacobian J of texels by position: A·M⁻¹·Aᵀ with A = (a b) and M = (e f; f g).
    const auto product = [&](double a1, double b1, double a2, double b2) {
        return (g * a1 * a2 - f * (a1 * b2 + b1 * a2) + e * b1 * b2) / area4;
    };
    const double uu = product(a.x, b.x, a.x, b.x), vv = product(a.y, b.y, a.y, b.y);
    const double uv = product(a.x, b.x, a.y, b.y);
    const double mean = 0.5 * (uu + vv), half = 0.5 * (uu - vv);
    const double root = std::sqrt(half * half + uv * uv);
    constexpr double longest_row = 10;  // of eight probes, over the width of one
    const double row = std::max(mean - root, (mean + root) / (longest_row * longest_row));
    return row >= 0 ? std::sqrt(row) : 0;  // 0 also where coordinates are too large to tell
}

double least_density(const Mesh& mesh, const TextureUse& use) {
    if (use.texcoord >= mesh.texcoords.size() || mesh.texcoords[use.texcoord].empty()) return 0;
    constexpr size_t block = 4096;
    std::vector<double> least((mesh.triangles.size() + block - 1) / block,
                              std::numeric_limits<double>::infinity());
    parallel_for(least.size(), [&](size_t k) {
        const size_t end = std::min((k + 1) * block, mesh.triangles.size());
        for (size_t t = k * block; t < end; ++t)
            least[k] = std::min(least[k], density(mesh, mesh.triangles[t], use));
    });
    return least.empty() ? 0 : *std::ranges::min_element(least);
}

/// The largest factor by which the matrix stretches a direction, or more.
double largest_stretch(const Mat4& m) {
    // Gershgorin's bound of the eigenvalues of M·Mᵀ, which is exact for turns and uniform scales.
    double largest = 0;
    for (int i = 0; i < 3; ++i) {
        double sum = 0;
        for (int j = 0; j < 3; ++j) {
            double product = 0;
            for (int k = 0; k < 3; ++k) product += double(m[i][k]) * double(m[j][k]);
            sum += std::fabs(product);
        }
        largest = std::max(largest, sum);
    }
    return std::sqrt(largest);
}

float distance_to(const Box3& box, const Vec3& p) {
    Vec3 outside(0, 0, 0);
    for (int i = 0; i < 3; ++i) outside[i] = std::max({box.min[i] - p[i], p[i] - box.max[i], 0.0f});
    return outside.length();
}

float farthest_corner(const Box3& box, const Vec3& p) {
    Vec3 farthest(0, 0, 0);
    for (int i = 0; i < 3; ++i)
        farthest[i] = std::max(std::fabs(box.min[i] - p[i]), std::fabs(box.max[i] - p[i]));
    return farthest.length();
}

/// The width of a ray's cone where it meets something at some distance.
class Cones {
  public:
    Cones(const Scene& scene, const RenderSettings& settings)
        : camera_(settings, scene.bounds),
          eye_(settings.camera.to_world.translation()),
          centre_(scene.bounds.isEmpty() ? Vec3(0) : scene.bounds.center()),
          from_centre_((eye_ - centre_).length()),
          is_outside_(!scene.bounds.isEmpty() && from_centre_ > scene.bounds.size().length() / 2),
          lens_(settings.aperture / 2),
          per_axis_(std::sqrt(static_cast<float>(
              settings.error > 0 ? std::bit_ceil(static_cast<unsigned>(settings.max_samples) + 3)
                                 : static_cast<unsigned>(settings.samples)))) {}

    /// The least width on what lies in `box` and at most `reach` from the scene's centre. Outside
    /// the sphere around the scene, the box plays no part, so that all views from one distance
    /// want the same levels.
    double least_width(const Box3& box, float reach) const {
        const float away = is_outside_ ? from_centre_ - reach : distance_to(box, eye_);
        const float distance = std::max(away - lens_, 0.0f) * 0.999f;
        return double(camera_.pixel_width() + camera_.pixel_spread() * distance) /
               double(per_axis_);
    }

    const Vec3& centre() const { return centre_; }

  private:
    CameraRays camera_;
    Vec3 eye_, centre_;
    float from_centre_;
    bool is_outside_;
    float lens_, per_axis_;
};

/// The level of lookups whose shorter axis has this many texels. A tenth more than the error of the
/// lookup's logarithm is subtracted.
int level_of(double texels) {
    const double level = std::log2(std::max(1.0, texels)) - 0.02;  // 0 for NaN
    return static_cast<int>(std::clamp(std::floor(level), 0.0, double{coarsest}));
}

/// The uses of the images of a material that need not be whole. Marks the others in `largest`.
std::vector<TextureUse> uses_of(const Scene& scene, const Material& material,
                                std::span<const std::array<int, 2>> sizes,
                                std::vector<WantedLevel>& largest, std::vector<bool>& is_numbers) {
    std::vector<TextureUse> uses;
    for (const SlotTexture& slot : slot_textures(material)) {
        if (!*slot.ref) continue;
        const Texture& sampler = scene.textures[slot.ref->texture];
        if (sampler.image >= sizes.size()) continue;
        const auto [width, height] = sizes[sampler.image];
        WantedLevel& wanted = largest[sampler.image];
        wanted.srgb |= slot.srgb;
        if (!slot.srgb) is_numbers[sampler.image] = true;
        if (width == 0 || !has_mipmaps(sampler) || is_read_whole(material, slot.slot)) {
            wanted.level = 0;
            continue;
        }
        TextureRef linear = *slot.ref;
        linear.offset = {0, 0};
        const Vec2 size(static_cast<float>(width), static_cast<float>(height));
        const TextureUse use{sampler.image, slot.ref->texcoord, transform_uv(linear, {1, 0}) * size,
                             transform_uv(linear, {0, 1}) * size};
        if (std::ranges::find(uses, use) == uses.end()) uses.push_back(use);
    }
    return uses;
}

}  // namespace

TextureLevels::TextureLevels(const Scene& scene, std::span<const std::array<int, 2>> sizes)
    : meshes_(scene.meshes.size()), largest_(sizes.size(), {coarsest, false}) {
    std::vector<bool> is_numbers(sizes.size(), false);
    std::vector<std::vector<TextureUse>> uses;
    for (const Material& material : scene.materials)
        uses.push_back(uses_of(scene, material, sizes, largest_, is_numbers));
    for (const Shape& shape : scene.shapes)
        for (const TextureUse& use : uses[shape.material]) largest_[use.image].level = 0;
    for (size_t i = 0; i < sizes.size(); ++i)
        if (largest_[i].srgb && is_numbers[i]) largest_[i].level = 0;
    const Vec3 centre = scene.bounds.isEmpty() ? Vec3(0) : scene.bounds.center();
    for (size_t m = 0; m < scene.meshes.size(); ++m) {
        const Mesh& mesh = scene.meshes[m];
        MeshUse& found = meshes_[m];
        float reach2 = 0;
        for (const Vec3& p : mesh.positions) {
            found.bounds.extendBy(p);
            reach2 = std::max(reach2, (p - centre).length2());
        }
        found.reach = std::sqrt(reach2);
        const std::vector<TextureUse>& all = uses[mesh.material];
        for (const TextureUse& use : all) {
            if (largest_[use.image].level == 0) continue;
            // Images of one size that are laid out alike have one density.
            const auto like = std::ranges::find_if(all, [&](TextureUse other) {
                other.image = use.image;
                return other == use;
            });
            const auto known = std::ranges::find(found.densities, like->image, &Density::image);
            const double texels =
                known != found.densities.end() ? known->texels : least_density(mesh, use);
            found.densities.push_back({use.image, texels});
        }
    }
}

std::vector<WantedLevel> TextureLevels::wanted(const Scene& scene,
                                               const RenderSettings& settings) const {
    std::vector<WantedLevel> wanted = largest_;
    if (settings.full_textures) {
        for (WantedLevel& level : wanted) level.level = 0;
        return wanted;
    }
    const Cones cones(scene, settings);
    for (const Instance& instance : scene.instances) {
        const double stretch = instance.baked ? 1 : largest_stretch(instance.object_to_world);
        for (const uint32_t m : scene.groups[instance.group].meshes) {
            const MeshUse& mesh = meshes_[m];
            if (mesh.densities.empty()) continue;
            const Box3 box = instance.baked
                                 ? mesh.bounds
                                 : transformed_box(mesh.bounds, Mat4d(instance.object_to_world));
            const float reach = instance.baked ? mesh.reach : farthest_corner(box, cones.centre());
            const double width = cones.least_width(box, reach) / stretch;
            for (const Density& density : mesh.densities) {
                int& level = wanted[density.image].level;
                level = std::min(level, level_of(width * density.texels));
            }
        }
    }
    return wanted;
}

}  // namespace sightline
