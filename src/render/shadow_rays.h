#pragma once
#include "render/render_context.h"
#include "render/samples.h"
#include "shade/bsdf.h"
#include "shade/media.h"

namespace sightline {

/// A ray may cross so many translucent layers before it counts as blocked: more would be a fault of
/// the file, and the loops must end.
inline constexpr int max_layers = 256;

/// What a light adds to a sample if nothing lies between it and the surface.
struct DirectLight {
    Vec3 alone;   ///< by parts of the BSDF for which no ray is followed: crosses all that transmits
    Vec3 shared;  ///< by rough lobes, with MIS: goes where rays from the surface reach unbent
    /// The part of `alone` that also passes undrawn backs (RenderContext::single_sided): all that
    /// points and suns add, of other lights what is diffuse. Rough lobes see those faces' fronts.
    Vec3 through_backs;

    /// Takes away what a layer or a medium keeps back; `unbent` is the share that keeps its
    /// direction.
    void attenuate(const Vec3& transmitted, const Vec3& unbent) {
        alone *= transmitted;
        shared *= unbent;
        through_backs *= transmitted;
    }
};

/// The shares of light that cross the surface in a straight line, whatever bends there. `media`:
/// around the ray before it. Sets surface.eta.
LayerTransmittance straight_transmittance(const RenderContext& context, const MediumStack& media,
                                          Surface& surface);

/// Shadow rays that are collected while the hits of a wave are shaded and then traced together.
class ShadowRays {
  public:
    explicit ShadowRays(const RenderContext& context)
        : context_(context),
          coincident_hits_(context.scene, context.intersector, context.lone_surfaces,
                           context.translucent_bounds) {}

    void clear() { rays_.clear(), shadows_.clear(); }

    /// `arriving` is for the camera sample `slot`. `media`: around the surface, on the side of its
    /// wo.
    void add(const Surface& surface, const LightSample& light, const DirectLight& arriving,
             uint32_t slot, uint16_t light_group, const MediumStack& media);

    /// A ray from the ground, in no medium.
    void add(const Ray& ray, const DirectLight& arriving, uint32_t slot);

    /// Traces the rays and adds to the samples what arrives.
    void trace(Coherence coherence, SampleBuffer& samples);

    /// Traces the rays and calls `arrive` for each with its index and the light that has arrived.
    template <class Arrive>
    void trace(Coherence coherence, SampleBuffer& samples, const Arrive& arrive) {
        if (rays_.empty()) return;
        cross_layers(coherence, samples);
        for (size_t i = 0; i < rays_.size(); ++i)
            arrive(i, occluded_[i] ? Vec3(0) : shadows_[i].light.alone + shadows_[i].light.shared);
    }

    /// After trace(): where the ray with this index began, or the part of it behind the last layer
    /// that it has crossed.
    const Ray& ray(size_t i) const { return rays_[i]; }
    uint32_t slot(size_t i) const { return shadows_[i].slot; }
    uint16_t light_group(size_t i) const { return shadows_[i].light_group; }
    /// Whether its light is infinitely far.
    bool is_endless(size_t i) const { return shadows_[i].endless; }

  private:
    struct Shadow {
        DirectLight light;
        uint32_t slot;
        uint16_t light_group;
        bool endless;
        SurfaceId source;
        MediumStack media;
    };
    void cross_layers(Coherence coherence, SampleBuffer& samples);
    struct Layer {
        uint32_t ray;
        Hit hit;
        Surface surface;
        std::optional<size_t> coincident;  // index in coincident_hits_, if others may coincide
    };
    void list_rays(bool occluded);
    void trace_layers(Visible visible, Counters& counters);
    void find_layers(size_t begin, size_t end, bool last, Visible visible);
    bool blocks_all(const Hit& hit) const;
    void cross_coincident(Shadow& shadow, Ray& ray, Layer& layer);
    void attenuate_by_layer(Shadow& shadow, Surface& surface) const;

    const RenderContext& context_;
    CoincidentHits coincident_hits_;
    std::vector<Ray> rays_;
    std::vector<Shadow> shadows_;     // by ray
    std::vector<uint8_t> occluded_;   // by ray
    std::vector<uint32_t> crossing_;  // indices of rays that still cross layers
    std::vector<Ray> layer_rays_;     // of those
    std::vector<Hit> layer_hits_;
    std::vector<Layer> layers_;  // of a block of rays
};

}  // namespace sightline
