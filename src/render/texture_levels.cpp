#include "render/texture_levels.h"

#include "core/parallel.h"
#include "render/camera_rays.h"
#include "render/emission.h"
#include "scene/shape_bounds.h"
#include "shade/bsdf.h"
#include "shade/compiled_material.h"
#include "shade/hit_geometry.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <utility>

namespace sightline {
namespace {

constexpr int coarsest = TextureLevels::coarsest;

bool has_mipmaps(const Texture& sampler) {
    return sampler.min != Filter::nearest && sampler.min != Filter::linear;
}

/// Whether shadow rays or the sampling of emitters read the texture without a footprint: coverage,
/// the tint of what transmits, emission behind a coat.
bool is_read_whole(const Material& m, TextureSlot slot) {
    if (m.transmission_factor > 0 || m.diffuse_transmission_factor > 0) return true;
    if (emits(m) && m.clearcoat_factor > 0) return true;
    return m.alpha_mode != AlphaMode::opaque && slot == TextureSlot::base_color;
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

double area_of(const Mesh& mesh, const std::array<uint32_t, 3>& corners) {
    const Vec3d p(mesh.positions[corners[0]]);
    return cross(Vec3d(mesh.positions[corners[1]]) - p, Vec3d(mesh.positions[corners[2]]) - p)
               .length() /
           2;
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

/// The level of lookups whose shorter axis has this many texels. A tenth more than the error of the
/// lookup's logarithm is subtracted.
size_t level_of(double texels) {
    const double level = std::log2(std::max(1.0, texels)) - 0.02;  // 0 for NaN
    return static_cast<size_t>(std::clamp(std::floor(level), 0.0, double{coarsest}));
}

/// Whether a hit is on a back that is not drawn.
bool is_culled(const Material& material, const HitGeometry& geometry, const Ray& ray) {
    return culls_back_faces(material) && dot(geometry.outward, ray.direction) > 0;
}

/// The coarsest level of which finer ones are needed by `ignored` at most.
int level_without(std::span<const double> shares, double ignored) {
    int level = 0;
    for (double sum = 0; level < coarsest; ++level) {
        sum += shares[static_cast<size_t>(level)];
        if (!(sum <= ignored)) break;  // NaN where an area and a width are zero
    }
    return level;
}

}  // namespace

/// The width of a ray's cone where it meets something at some distance.
class TextureLevels::Cones {
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
                                 : static_cast<unsigned>(settings.samples)))) {
        const Vec2 half = camera_.half_size();
        if (!settings.camera.orthographic)
            crowding_ = std::pow(1 + double(half.x * half.x + half.y * half.y), 1.5);
    }

    /// The width after a camera ray's distance, of a sample's cone.
    double width_at(float distance) const {
        const float least = std::max(distance - lens_, 0.0f) * 0.999f;
        return double(camera_.pixel_width() + camera_.pixel_spread() * least) / double(per_axis_);
    }

    /// The least width on what lies in `box` and at most `reach` from the scene's centre. Outside
    /// the sphere around the scene, the box plays no part, so that all views from one distance
    /// want the same levels.
    double least_width(const Box3& box, float reach) const {
        const float away = is_outside_ ? from_centre_ - reach : distance_to(box, eye_);
        return width_at(away);
    }

    /// How many pixels something of this area covers at most where samples have this width. Pixels
    /// in the corners of a perspective picture see a smaller solid angle than those in its middle.
    double pixels(double area, double width) const {
        const double pixel = width * double(per_axis_);
        return area / (pixel * pixel) * crowding_;
    }

    const CameraRays& camera() const { return camera_; }

    const Vec3& centre() const { return centre_; }

  private:
    CameraRays camera_;
    Vec3 eye_, centre_;
    float from_centre_;
    bool is_outside_;
    float lens_, per_axis_;
    double crowding_ = 1;
};

/// The uses of the images of a material that need not be whole. Marks the others in `largest`.
std::vector<TextureLevels::TextureUse> TextureLevels::uses_of(
    const Scene& scene, const Material& material, std::span<const std::array<int, 2>> sizes,
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
        if (slot.slot == TextureSlot::emissive && emits(material)) {
            const double texels = double(emitter_footprint) * std::min(width, height);
            wanted.level = std::min(wanted.level, static_cast<int>(level_of(texels)));
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

/// The density of a texture on one triangle with an area; 0 if it is unknown.
double TextureLevels::density(const Mesh& mesh, const std::array<uint32_t, 3>& corners,
                              const TextureUse& use) {
    if (use.texcoord >= mesh.texcoords.size() || mesh.texcoords[use.texcoord].empty()) return 0;
    const Vec3d p(mesh.positions[corners[0]]);
    const Vec3d e1 = Vec3d(mesh.positions[corners[1]]) - p;
    const Vec3d e2 = Vec3d(mesh.positions[corners[2]]) - p;
    const double e = dot(e1, e1), f = dot(e1, e2), g = dot(e2, e2);
    const double area4 = e * g - f * f;
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

/// Parts whose densities differ by less than a sixteenth of a level, in order.
std::vector<TextureLevels::Part> TextureLevels::parts_of(const Mesh& mesh, const TextureUse& use) {
    constexpr size_t block = 4096;
    using Parts = std::map<int, Part>;
    std::vector<Parts> blocks((mesh.triangles.size() + block - 1) / block);
    const auto add = [](Parts& parts, const Part& part) {
        const double step = std::clamp(std::floor(16 * std::log2(part.texels)), -1e4, 1e4);
        const auto [at, is_new] = parts.try_emplace(static_cast<int>(step), part);
        if (is_new) return;
        at->second.texels = std::min(at->second.texels, part.texels);
        at->second.area += part.area;
    };
    parallel_for(blocks.size(), [&](size_t k) {
        const size_t end = std::min((k + 1) * block, mesh.triangles.size());
        for (size_t t = k * block; t < end; ++t) {
            const std::array<uint32_t, 3>& corners = mesh.triangles[t];
            const double area = area_of(mesh, corners);
            if (area > 0) add(blocks[k], {density(mesh, corners, use), area});
        }
    });
    Parts all;
    for (const Parts& some : blocks)
        for (const auto& [step, part] : some) add(all, part);
    std::vector<Part> parts;
    for (const auto& [step, part] : all) parts.push_back(part);
    return parts;
}

TextureLevels::TextureLevels(const Scene& scene, std::span<const std::array<int, 2>> sizes)
    : meshes_(scene.meshes.size()),
      sizes_(sizes.begin(), sizes.end()),
      largest_(sizes.size(), {coarsest, false}) {
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
        for (const TextureUse& use : uses[mesh.material]) {
            if (largest_[use.image].level == 0) continue;
            // Images of one size that are laid out alike have one density.
            const auto like = std::ranges::find_if(found.textures, [&](TextureUse other) {
                other.image = use.image;
                return other == use;
            });
            found.parts.push_back(like == found.textures.end()
                                      ? parts_of(mesh, use)
                                      : found.parts[size_t(like - found.textures.begin())]);
            found.textures.push_back(use);
        }
    }
}

std::vector<TextureLevels::Shares> TextureLevels::bounds(const Scene& scene,
                                                         const Cones& cones) const {
    std::vector<Shares> shares(largest_.size(), Shares{});
    for (const Instance& instance : scene.instances) {
        const double stretch = instance.baked ? 1 : largest_stretch(instance.object_to_world);
        for (const uint32_t m : scene.groups[instance.group].meshes) {
            const MeshUse& mesh = meshes_[m];
            if (mesh.textures.empty()) continue;
            const Box3 box = instance.baked
                                 ? mesh.bounds
                                 : transformed_box(mesh.bounds, Mat4d(instance.object_to_world));
            const float reach = instance.baked ? mesh.reach : farthest_corner(box, cones.centre());
            const double width = cones.least_width(box, reach) / stretch;  // in the mesh's space
            for (size_t i = 0; i < mesh.textures.size(); ++i)
                for (const auto& [texels, area] : mesh.parts[i])
                    shares[mesh.textures[i].image][level_of(width * texels)] +=
                        cones.pixels(area, width);
        }
    }
    return shares;
}

void TextureLevels::count_hit(const Scene& scene, const Cones& cones, const Ray& ray,
                              const Hit& hit, std::vector<Shares>& shares) const {
    const Instance& instance = scene.instances[hit.instance];
    const MeshUse& mesh = meshes_[hit.geometry];
    const double stretch = instance.baked ? 1 : largest_stretch(instance.object_to_world);
    const double width = cones.width_at(hit.t * ray.direction.length()) / stretch;
    const std::array<uint32_t, 3>& corners = scene.meshes[hit.geometry].triangles[hit.primitive];
    for (const TextureUse& use : mesh.textures)
        ++shares[use.image][level_of(width * density(scene.meshes[hit.geometry], corners, use))];
}

/// Along a row of rays and through what does not hold them off.
void TextureLevels::count_seen(const Scene& scene, const Cones& cones,
                               const Intersector& intersector, std::vector<Ray> rays,
                               std::vector<Shares>& shares) const {
    constexpr int most_layers = 16;
    std::vector<Hit> hits;
    for (int layer = 0; layer < most_layers && !rays.empty(); ++layer) {
        hits.resize(rays.size());
        intersector.closest(rays, hits, Coherence::incoherent);
        std::vector<Ray> behind;
        for (size_t i = 0; i < rays.size(); ++i) {
            const Hit& hit = hits[i];
            if (!hit) continue;
            const Material& material = scene.materials[scene.material_of(hit.geometry)];
            const bool culled =
                is_culled(material, hit_geometry(scene, hit, &rays[i], false), rays[i]);
            if (!culled && scene.is_mesh(hit.geometry))
                count_hit(scene, cones, rays[i], hit, shares);
            if (!culled && !is_translucent(material)) continue;
            behind.push_back(rays[i]);
            behind.back().tnear = hit.t * 1.0001f;
        }
        rays = std::move(behind);
    }
}

/// By rays through a grid of points of the picture.
std::vector<TextureLevels::Shares> TextureLevels::seen(const Scene& scene,
                                                       const RenderSettings& settings,
                                                       const Cones& cones,
                                                       const Intersector& intersector) const {
    constexpr int most_points = 128;
    const int columns = std::min(settings.width, most_points);
    const int rows = std::min(settings.height, most_points);
    const auto place = [](size_t i, int points, int size) {
        return (static_cast<float>(i) + 0.5f) / static_cast<float>(points) *
               static_cast<float>(size);
    };
    std::vector<std::vector<Shares>> found(static_cast<size_t>(rows));
    parallel_for(found.size(), [&](size_t row) {
        std::vector<Ray> rays;
        for (size_t column = 0; column < static_cast<size_t>(columns); ++column)
            rays.push_back(cones.camera().ray(place(column, columns, settings.width),
                                              place(row, rows, settings.height), {0.5f, 0.5f}));
        found[row].assign(largest_.size(), Shares{});
        count_seen(scene, cones, intersector, std::move(rays), found[row]);
    });
    std::vector<Shares> sum(largest_.size(), Shares{});
    for (const std::vector<Shares>& some : found)
        for (size_t i = 0; i < sum.size(); ++i)
            for (size_t level = 0; level < sum[i].size(); ++level)
                sum[i][level] += some[i][level] / (double(columns) * double(rows));
    return sum;
}

std::vector<WantedLevel> TextureLevels::wanted(const Scene& scene, const RenderSettings& settings,
                                               const Intersector* intersector) const {
    constexpr double large = 1 << 20;  // texels: less is decoded sooner than rays are traced
    std::vector<WantedLevel> wanted = largest_;
    const Cones cones(scene, settings);
    const double pixels = double(settings.width) * double(settings.height);
    const std::vector<Shares> least =
        settings.full_textures ? std::vector<Shares>() : bounds(scene, cones);
    bool can_gain = false;
    for (size_t i = 0; i < wanted.size(); ++i) {
        int& level = wanted[i].level;
        if (settings.full_textures) level = 0;
        if (level == 0) continue;
        level = std::min(level, level_without(least[i], ignored_share * pixels));
        can_gain |= std::ldexp(double(sizes_[i][0]) * double(sizes_[i][1]), -2 * level) > large;
    }
    if (!can_gain || !intersector) return wanted;
    const std::vector<Shares> rays = seen(scene, settings, cones, *intersector);
    for (size_t i = 0; i < wanted.size(); ++i) {
        int& level = wanted[i].level;
        if (largest_[i].level == 0) continue;
        const int coarser = std::min(level_without(rays[i], ignored_share), level + hidden_levels);
        level = std::clamp(coarser, level, std::max(level, largest_[i].level));
    }
    return wanted;
}

}  // namespace sightline
