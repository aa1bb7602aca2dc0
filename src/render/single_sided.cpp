#include "render/single_sided.h"

#include "core/sampler.h"
#include "core/text.h"
#include "render/coincident_hits.h"
#include "render/shadow_rays.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {
namespace {

constexpr uint32_t grid_size = 64;  // cells along each side of the frame
constexpr uint32_t grid_rays = grid_size * grid_size;
constexpr size_t named_materials = 8;  // in the explanation

/// One ray through each cell of a grid over the frame, from the centre of the lens. Positions
/// within the cells vary, since rows of slats would be missed by a regular grid.
std::vector<Ray> grid_of_rays(const RenderSettings& settings, const CameraRays& camera) {
    const Vec2 cell(static_cast<float>(settings.width) / grid_size,
                    static_cast<float>(settings.height) / grid_size);
    const Vec2 lens_centre(0.5f, 0.5f);
    std::vector<Ray> rays;
    rays.reserve(grid_rays);
    for (uint32_t y = 0; y < grid_size; ++y)
        for (uint32_t x = 0; x < grid_size; ++x) {
            const Vec2 within = sample_2d(0, hash_combine(x, y));
            rays.push_back(camera.ray((static_cast<float>(x) + within.x) * cell.x,
                                      (static_cast<float>(y) + within.y) * cell.y, lens_centre));
        }
    return rays;
}

/// Takes camera rays through undrawn backs and holes to the first drawn surface.
class BackCounter {
  public:
    BackCounter(const Scene& scene, const Surfaces& surfaces, const Intersector& intersector,
                const LoneSurfaces& lone)
        : scene_(scene),
          surfaces_(surfaces),
          intersector_(intersector),
          coincident_hits_(scene, intersector, lone, {}),
          seen_(scene.materials.size()) {}

    /// By material: how many of the rays meet an undrawn back of it before the first drawn surface.
    std::vector<uint32_t> count(std::vector<Ray> rays) {
        std::vector<Hit> hits;
        for (int layer = 0; layer <= max_layers && !rays.empty(); ++layer) {
            hits.resize(rays.size());
            intersector_.closest(rays, hits,
                                 layer == 0 ? Coherence::coherent : Coherence::incoherent);
            size_t left = 0;
            for (size_t i = 0; i < rays.size(); ++i)
                if (hits[i] && passes(rays[i], hits[i])) rays[left++] = rays[i];
            rays.resize(left);
        }
        return std::move(seen_);
    }

  private:
    /// Counts the undrawn backs that coincide with the hit and moves the ray behind them; false if
    /// something is drawn there.
    bool passes(Ray& ray, const Hit& closest) {
        Surface surface = surfaces_.at(ray, closest, 0);
        if (surface.alpha > 0) return false;
        coincident_hits_.clear();
        std::span<const Hit> coincident(&closest, 1);
        if (const auto index = coincident_hits_.add(ray, closest, surface)) {
            coincident_hits_.search(Visible::all);
            coincident = coincident_hits_.at(*index);
        }
        for (const Hit& hit : coincident) {
            if (coincident.size() > 1) {
                surface = surfaces_.at(ray, hit, 0);
                coincident_hits_.widen(surface);
            }
            if (surface.alpha > 0) return false;
            seen_[surface.material] += is_undrawn_back(surface);
        }
        ray = spawn_ray(surface, ray.direction, ray.tfar - closest.t);
        return true;
    }

    bool is_undrawn_back(const Surface& surface) const {
        return !surface.front && culls_back_faces(scene_.materials[surface.material]);
    }

    const Scene& scene_;
    const Surfaces& surfaces_;
    const Intersector& intersector_;
    CoincidentHits coincident_hits_;
    std::vector<uint32_t> seen_;
};

std::string name_of(const Scene& scene, uint32_t material) {
    const std::string& name = scene.materials[material].name;
    return name.empty() ? fmt::format("material {}", material) : '"' + printable(name) + '"';
}

/// The reason for which light passes, in brackets behind the material's name.
std::string reason_for(const Material& material, uint32_t seen) {
    if (material.unlit) return "unlit";
    return fmt::format("backs met by {} of {} camera rays", seen, grid_rays);
}

Decision explain(const Scene& scene, const RenderSettings& settings,
                 const std::vector<uint32_t>& single_sided, const std::vector<uint32_t>& passing,
                 const std::vector<uint32_t>& seen) {
    const bool automatic = settings.single_sided_shadows == SingleSidedShadows::automatic;
    std::string because = fmt::format("light passes the backs of {} of {} single-sided materials",
                                      passing.size(), single_sided.size());
    if (!automatic) because += ", as the option says";
    const size_t named = std::min(passing.size(), automatic ? named_materials : 0);
    for (size_t i = 0; i < named; ++i) {
        const uint32_t m = passing[i];
        because += fmt::format("{}{} ({})", i == 0 ? ": " : ", ", name_of(scene, m),
                               reason_for(scene.materials[m], seen[m]));
    }
    if (automatic && passing.size() > named)
        because += fmt::format(" and {} others", passing.size() - named);
    const bool none = passing.empty(), all = passing.size() == single_sided.size();
    return {"single_sided_shadows",
            none  ? "on"
            : all ? "off"
                  : "some",
            because, none ? "the closest hits of blocked shadow rays" : ""};
}

}  // namespace

SingleSidedFaces find_single_sided_faces(const Scene& scene, const RenderSettings& settings,
                                         const Surfaces& surfaces, const CameraRays& camera,
                                         const Intersector& intersector, const LoneSurfaces& lone) {
    const std::vector<bool> used = used_materials(scene);
    std::vector<uint32_t> single_sided;
    for (uint32_t m = 0; m < used.size(); ++m)
        if (used[m] && culls_back_faces(scene.materials[m])) single_sided.push_back(m);
    const bool automatic = settings.single_sided_shadows == SingleSidedShadows::automatic;
    std::vector<uint32_t> seen(scene.materials.size());
    if (automatic && !single_sided.empty())
        seen =
            BackCounter(scene, surfaces, intersector, lone).count(grid_of_rays(settings, camera));

    std::vector<uint32_t> passing;
    std::ranges::copy_if(single_sided, std::back_inserter(passing), [&](uint32_t m) {
        return automatic ? seen[m] > 0 || scene.materials[m].unlit
                         : settings.single_sided_shadows == SingleSidedShadows::off;
    });
    SingleSidedFaces faces;
    faces.decision = explain(scene, settings, single_sided, passing, seen);
    if (!passing.empty()) faces.pass_light.resize(scene.materials.size());
    for (const uint32_t m : passing) faces.pass_light[m] = 1;
    return faces;
}

}  // namespace sightline
