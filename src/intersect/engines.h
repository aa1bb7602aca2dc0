#pragma once
// The registry of engines: one vocabulary for --intersector, --methods and the tests.
#include "intersect/embree/embree.h"
#include "intersect/methods/method_intersector.h"
#include "intersect/ray_file.h"

#include <functional>
#include <optional>
#include <span>

namespace sightline {

/// An entry of the registry. Every engine answers closest-hit and any-hit queries and supports
/// instances, whatever the materials.
struct EngineEntry {
    std::string name;
    std::string description;  ///< one phrase
    bool has_structures;      ///< the name may be followed by ":bounds" or ":loop"
    bool (*supports)(const Scene&);
    std::function<std::unique_ptr<Intersector>(const Scene&, Structure, const EmbreeOptions&)> make;
};

/// All engines, the production engines first.
std::span<const EngineEntry> engine_registry();

/// The names in the order of the registry.
std::vector<std::string> engine_names();

/// An engine name is that of an entry, then ":bounds" or ":loop" if the entry has structures, then
/// optionally "@coherent" or "@incoherent", which overrides the coherence that callers pass.
/// Throws Error, listing all names, if `name` is not of this form.
void check_engine_name(std::string_view name);

/// The coherence that a valid name pins, if any.
std::optional<Coherence> pinned_coherence(std::string_view name);

/// Builds an engine over `scene`, which must outlive it. The name decides over `robust` and
/// `packets` of `embree`. Throws Error if the name is unknown, if the engine does not support the
/// scene, or if Embree fails.
std::unique_ptr<Intersector> make_engine(const Scene& scene, std::string_view name,
                                         const EmbreeOptions& embree = {});

/// An engine under the full name that selected it.
struct Engine {
    std::string name;
    std::unique_ptr<Intersector> intersector;
    /// ns a ray by kind, NaN for unknown, of an engine that is not timed here: its answers come
    /// from a file.
    std::optional<std::array<double, ray_kinds>> measured_ns = {};
};

/// Builds one engine for each distinct name. Throws Error as make_engine does; unknown names are
/// reported before anything is built.
std::vector<Engine> make_engines(const Scene& scene, std::span<const std::string> names,
                                 const EmbreeOptions& embree = {});

}  // namespace sightline
