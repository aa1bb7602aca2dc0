#pragma once
// What the laboratory charts: ways to meet a scene, by name.
#include "intersect/intersector.h"

#include <optional>
#include <span>

namespace sightline {

/// An engine over a scene, under the name by which `--methods` asks for it.
struct Engine {
    std::string name;
    std::unique_ptr<Intersector> intersector;
    std::optional<Coherence> coherence;  ///< of every call, where the name pins it

    /// As Intersector has them; `usual` is how the renderer would call.
    void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence usual) const {
        intersector->closest(rays, hits, coherence.value_or(usual));
    }
    void occluded(std::span<const Ray> rays, std::span<uint8_t> blocked, Coherence usual) const {
        intersector->occluded(rays, blocked, coherence.value_or(usual));
    }
};

/// The names, the production engines first:
/// - "embree": ROBUST, sixteen rays a call; "embree-default": without that flag; either followed
///   by "-single": each ray by a call of its own;
/// - "few-shapes": make_few_shapes;
/// - "exact" and those of triangle_methods(), as make_reference has them.
/// A triangle method may be followed by ":bounds" or ":loop"; any name by "@coherent" or
/// "@incoherent", which pins how it is called.
std::vector<std::string> engine_names();

/// Throws Error, with all names, where `name` is none.
void check_engine_name(std::string_view name);

/// Builds one. `scene` must outlive it; `embree` says how Embree builds. Throws Error as
/// check_engine_name, and where few-shapes is asked for a scene that has too many of them.
Engine make_engine(const Scene& scene, std::string_view name, const EmbreeOptions& embree = {});

/// Builds one of each; names that occur twice count once. Throws Error before anything is built.
std::vector<Engine> make_engines(const Scene& scene, std::span<const std::string> names,
                                 const EmbreeOptions& embree = {});

}  // namespace sightline
