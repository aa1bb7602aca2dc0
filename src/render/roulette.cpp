#include "render/roulette.h"

#include <algorithm>

namespace sightline {
namespace {

float brightest_emitter(const Scene& scene) {
    float brightest = 0;
    for (const Material& m : scene.materials)
        if (!m.unlit) brightest = std::max(brightest, max_component(m.emissive_factor));
    return brightest;
}

}  // namespace

float brightest_radiance(const Scene& scene, const RenderSettings& settings, bool environment) {
    if (environment || !scene.lights.empty()) return std::numeric_limits<float>::infinity();
    float brightest = std::max(brightest_emitter(scene), max_component(settings.background_color));
    for (const Material& m : scene.materials) {
        const Vec4& c = m.base_color_factor;
        if (m.unlit) brightest = std::max({brightest, c.x, c.y, c.z});
    }
    return std::max(brightest, 1.0f);
}

Roulette::Roulette(const Scene& scene, const RenderSettings& settings, bool environment)
    : cutoff_(settings.cutoff),
      brightest_(brightest_radiance(scene, settings, environment)),
      emitters_(brightest_emitter(scene)) {}

float Roulette::survival(const Vec3& throughput, float faint) const {
    const float weight = max_component(throughput);
    if (!(weight > 0 && weight * brightest_ >= cutoff_)) return 0;
    if (weight >= faint) return 1;
    // A lamp that may fill a pixel with white is not left to chance. Of the rest, a survivor counts
    // for at most twice the limit: few rays, and at the cutoff one is hardly seen.
    return std::clamp(weight * emitters_, weight / (2 * faint), 1.0f);
}

}  // namespace sightline
