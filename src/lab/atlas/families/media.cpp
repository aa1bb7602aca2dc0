// Glass in contact with liquid: in which of them is one behind faces that coincide?
#include "shade/media.h"
#include "core/parallel.h"
#include "exact/referee.h"
#include "intersect/engines.h"
#include "intersect/methods/inside.h"
#include "lab/atlas/families.h"
#include "lab/atlas/mesh_making.h"
#include "scene/scene_builder.h"
#include "shade/surface.h"

#include <algorithm>

namespace sightline {
namespace {

/// What a point lies in, as bits; the bit's index is the mesh, and one less than its material.
using MediaSet = int;
constexpr MediaSet glass = 1, liquid = 2;

/// A shell of glass, radii 1 and 2, and the liquid that fills it. The segment of each question,
/// t ≤ 1, leads from the air to the point that is asked about.
struct Vessel {
    Mesh outer, inner, content;
    std::vector<Ray> questions;

    /// Materials 1 and 2. The shell's inner side is the outer side of what it holds, turned round.
    Scene scene() const {
        Mesh shell = outer, filling = content;
        const auto first = static_cast<uint32_t>(shell.positions.size());
        shell.positions.insert(shell.positions.end(), inner.positions.begin(),
                               inner.positions.end());
        for (const auto& [a, b, c] : inner.triangles)
            shell.triangles.push_back({first + a, first + c, first + b});
        SceneBuilder builder;
        shell.material = builder.add_material({});
        filling.material = builder.add_material({});
        builder.add_instance(builder.add_group({std::move(shell), std::move(filling)}));
        return builder.finish();
    }
};

/// Where a walk along the segment goes on behind a hit.
using Onwards = Ray (*)(const Surface&, const Ray&, const Hit&);

/// As renders go on.
Ray from_bound(const Surface& surface, const Ray& ray, const Hit& hit) {
    return spawn_ray(surface, ray.direction, ray.tfar - hit.t);
}
Ray from_t(const Surface&, const Ray& ray, const Hit& hit) {
    Ray rest = ray;
    rest.tnear = hit.t;
    return rest;
}
Ray from_epsilon(const Surface&, const Ray& ray, const Hit& hit) {
    Ray rest = ray;
    rest.tnear = hit.t + 1e-4f;
    return rest;
}

struct WalkMethod {
    const char* name;
    bool exact;  ///< walks through the exact tree, else through Embree as renders call it
    Onwards onwards;
};
constexpr WalkMethod walks[] = {{"walk-rendered", false, from_bound},
                                {"walk-exact-tree", true, from_bound},
                                {"walk-tnear", true, from_t},
                                {"walk-tnear-1e-4", true, from_epsilon}};

class MediaTrial : public Trial {
  public:
    explicit MediaTrial(Vessel vessel)
        : vessel_(std::move(vessel)),
          scene_(vessel_.scene()),
          surfaces_(scene_, false, 1),
          truths_(size()) {
        const Scene parts[] = {scene_of_meshes({vessel_.outer}), scene_of_meshes({vessel_.inner}),
                               scene_of_meshes({vessel_.content})};
        const Referee outer(parts[0]), inner(parts[1]), content(parts[2]);
        parallel_for(size(), [&](size_t i) {
            // Each part is convex about the origin: the segment from there to a point leaves it or
            // not.
            const auto holds = [&](const Referee& part) {
                return !part.occluded({{0, 0, 0}, 0, end_of(vessel_.questions[i]), 1});
            };
            truths_[i] =
                (holds(outer) && !holds(inner) ? glass : 0) | (holds(content) ? liquid : 0);
        });
    }

    size_t size() const override { return vessel_.questions.size(); }

    std::vector<Entrant> entrants(const std::vector<std::string>& methods) override {
        std::vector<Entrant> result;
        for (const std::string& name : methods) {
            if (name == "parity")
                add(name,
                    asking([](const Mesh& m, const Vec3& p) { return inside_by_parity(m, p); }),
                    result);
            if (name == "winding-number")
                add(name,
                    asking([](const Mesh& m, const Vec3& p) { return winding_number(m, p) > 0.5; }),
                    result);
            for (const WalkMethod& walk : walks)
                if (name == walk.name) add(name, walking(walk), result);
        }
        return result;
    }

    /// Lost is a medium that one is in, false one that one is not in.
    Verdict judge(size_t i, const MethodAnswer& answer) const override {
        const MediaSet lost = truths_[i] & ~answer.count, added = answer.count & ~truths_[i];
        if (lost != 0) return added != 0 ? Verdict::wrong_primitive : Verdict::missed;
        return added != 0 ? Verdict::false_hit : Verdict::same;
    }
    Measures measure(size_t, const MethodAnswer&) const override { return no_measures; }
    bool hits(size_t i) const override { return truths_[i] != 0; }
    double condition(size_t) const override { return not_measured; }
    /// The points lie far from all faces.
    bool decidable(size_t) const override { return true; }

  private:
    using Method = std::function<MediaSet(const Ray&)>;

    static Vec3 end_of(const Ray& question) { return question.origin + question.direction; }

    /// Asks of each mesh whether the point is inside, whatever lies before it.
    template <class Inside>
    Method asking(Inside inside) const {
        return [this, inside](const Ray& question) {
            MediaSet media = 0;
            for (size_t k = 0; k < 2; ++k)
                if (inside(scene_.meshes[k], end_of(question))) media |= 1 << k;
            return media;
        };
    }

    /// Goes from hit to hit and keeps count of what is entered and left, as renders do.
    Method walking(const WalkMethod& walk) const {
        const std::shared_ptr<Intersector> engine =
            make_engine(scene_, walk.exact ? "exact" : "embree");
        return [this, engine, onwards = walk.onwards](const Ray& question) {
            MediumStack media;
            Ray ray = question;
            for (int step = 0; step < 32 && ray.tnear < ray.tfar; ++step) {
                Hit hit;
                engine->closest({&ray, 1}, {&hit, 1}, Coherence::incoherent);
                if (!hit) break;
                const Surface surface = surfaces_.at(ray, hit, 0);
                surface.front ? media.enter(surface.material) : media.leave(surface.material);
                ray = onwards(surface, ray, hit);
            }
            MediaSet result = 0;
            for (uint16_t i = 0; i < media.count; ++i) result |= 1 << (media.material[i] - 1);
            return result;
        };
    }

    void add(const std::string& name, Method method, std::vector<Entrant>& result) const {
        const auto found = std::make_shared<std::vector<MediaSet>>(size());
        result.push_back({name,
                          [this, found, method] {
                              for (size_t i = 0; i < size(); ++i)
                                  (*found)[i] = method(vessel_.questions[i]);
                          },
                          [found](size_t i) {
                              MethodAnswer answer;
                              answer.count = (*found)[i];
                              if (answer.count != 0) answer.hit.geometry = 0;
                              return answer;
                          }});
    }

    Vessel vessel_;
    Scene scene_;
    Surfaces surfaces_;
    std::vector<MediaSet> truths_;
};

/// The liquid's radius is `change` larger than the hole's; 10⁻⁹ is no change of its floats. Rays
/// pass through vertices, edges and anything else of the hole on their way to points in the liquid,
/// in the glass behind it and in the air behind that.
std::unique_ptr<Trial> touching_media(const TrialRequest& request, double change) {
    Dice dice(request.seed);
    const Mat4d turn = random_rotation(dice);
    const auto globe = [&](double radius) {
        return closed_globe(8, scale_and_offset(Vec3d(radius, radius, radius), {0, 0, 0}) * turn);
    };
    Vessel vessel{globe(2), globe(1), globe(1 + change), {}};
    for (size_t i = 0; i < request.rays; ++i) {
        const Vec3d gate = aimed_point(vessel.inner, static_cast<Target>(i % 3), dice);
        const double distances[] = {0, 1.35, 4};
        const Vec3d end = gate * -distances[i / 3 % 3] + dice.vector(0.15);
        const Vec3 from(gate * 6 - end * 5), to(end);
        vessel.questions.push_back({from, 0, to - from, 1});
    }
    return std::make_unique<MediaTrial>(std::move(vessel));
}

}  // namespace

void add_media_family(std::vector<Family>& families) {
    std::vector<std::string> methods = {"parity", "winding-number"};
    for (const WalkMethod& walk : walks) methods.push_back(walk.name);
    families.push_back({"R3g", "what one is in behind glass and liquid with a gap between",
                        "size / gap", powers(10, 1, 9, 2), methods,
                        [](const TrialRequest& r) { return touching_media(r, -1 / r.knob); }});
    families.push_back({"R3o", "what one is in behind glass and liquid that overlap",
                        "size / overlap", powers(10, 1, 9, 2), methods,
                        [](const TrialRequest& r) { return touching_media(r, 1 / r.knob); }});
}

}  // namespace sightline
