// Bounces: a ray that leaves a triangle must not meet it again, and should start close to it.
#include "exact/triangle.h"
#include "intersect/embree/embree.h"
#include "lab/atlas/families.h"
#include "lab/atlas/mesh_making.h"
#include "shade/surface.h"

#include <bit>

namespace sightline {
namespace {

/// A ray that met a triangle, and where it goes from there.
struct Bounce {
    Ray ray;
    Hit hit;
    Vec3 direction;
};

/// Where a method lets the bounce start.
using Start = Ray (*)(const Surface&, const Bounce&);

Vec3 point_on_ray(const Bounce& b) { return b.ray.origin + b.ray.direction * b.hit.t; }

/// The geometric normal on the side of the new direction.
Vec3 side_of(const Surface& s, const Bounce& b) {
    return dot(b.direction, s.ng) >= 0 ? s.ng : -s.ng;
}

Ray from_error_bound(const Surface& s, const Bounce& b) {
    return spawn_ray(s, b.direction, std::numeric_limits<float>::infinity());
}
Ray from_point(const Surface&, const Bounce& b) { return {point_on_ray(b), 0, b.direction}; }
Ray from_normal(const Surface& s, const Bounce& b) {
    return {point_on_ray(b) + side_of(s, b) * 1e-4f, 0, b.direction};
}
Ray from_distance(const Surface&, const Bounce& b) { return {point_on_ray(b), 1e-4f, b.direction}; }

/// Wächter and Binder, A Fast and Robust Method for Avoiding Self-Intersection, Ray Tracing Gems
/// 2019, chapter 6: steps of 256·n units in the last place, or of n/65536 close to the origin.
Ray from_integers(const Surface& s, const Bounce& b) {
    const Vec3 normal = side_of(s, b), p = point_on_ray(b);
    Vec3 origin;
    for (int i = 0; i < 3; ++i) {
        const auto steps = static_cast<int32_t>(256 * normal[i]);
        const auto moved =
            std::bit_cast<float>(std::bit_cast<int32_t>(p[i]) + (p[i] < 0 ? -steps : steps));
        origin[i] = std::abs(p[i]) < 1.0f / 32 ? p[i] + normal[i] / 65536 : moved;
    }
    return {origin, 0, b.direction};
}

struct Offset {
    const char* name;
    Start start;
};
constexpr Offset offsets[] = {{"offset-bound", from_error_bound},
                              {"offset-none", from_point},
                              {"offset-normal-1e-4", from_normal},
                              {"offset-tnear-1e-4", from_distance},
                              {"offset-wachter-binder", from_integers}};

class BounceTrial : public Trial {
  public:
    BounceTrial(Scene scene, std::span<const Ray> rays, std::span<const Vec3> directions)
        : scene_(std::move(scene)), surfaces_(scene_, false, 1) {
        std::vector<Hit> hits(rays.size());
        make_embree(scene_)->closest(rays, hits, Coherence::incoherent);
        for (size_t i = 0; i < rays.size(); ++i) {
            if (!hits[i]) continue;
            bounces_.push_back({rays[i], hits[i], directions[i]});
            points_.push_back(surfaces_.at(rays[i], hits[i], 0));
        }
    }

    size_t size() const override { return bounces_.size(); }

    std::vector<Entrant> entrants(const std::vector<std::string>& methods) override {
        std::vector<Entrant> result;
        for (const Offset& offset : offsets) {
            if (std::find(methods.begin(), methods.end(), offset.name) == methods.end()) continue;
            const auto rays = std::make_shared<std::vector<Ray>>(size());
            result.push_back({offset.name,
                              [this, rays, start = offset.start] {
                                  for (size_t i = 0; i < size(); ++i)
                                      (*rays)[i] = start(points_[i], bounces_[i]);
                              },
                              [this, rays](size_t i) { return answer_of(i, (*rays)[i]); }});
        }
        return result;
    }

    /// Any hit is one of the triangle that the ray has left.
    Verdict judge(size_t, const MethodAnswer& answer) const override {
        return answer.hit ? Verdict::false_hit : Verdict::same;
    }
    Measures measure(size_t, const MethodAnswer& answer) const override {
        Measures measures = no_measures;
        measures[static_cast<size_t>(Measure::gap)] = answer.t;
        return measures;
    }
    bool hits(size_t) const override { return false; }
    double condition(size_t) const override { return not_measured; }
    bool decidable(size_t) const override { return true; }

  private:
    /// t is the height over the triangle at which the ray starts to count.
    MethodAnswer answer_of(size_t i, const Ray& ray) const {
        const Mesh& mesh = scene_.meshes[0];
        const auto& [a, b, c] = mesh.triangles[bounces_[i].hit.primitive];
        const InstancedTriangle triangle = {mesh.positions[a], mesh.positions[b],
                                            mesh.positions[c]};
        const Vec3d corner(triangle.a);
        const Vec3d normal =
            normalize(cross(Vec3d(triangle.b) - corner, Vec3d(triangle.c) - corner));
        const Vec3d start =
            Vec3d(ray.origin) + Vec3d(ray.direction) * static_cast<double>(ray.tnear);
        MethodAnswer answer;
        answer.t = std::abs(dot(normal, start - corner));
        if (exact_crossing(ray, triangle) == Crossing::hit) answer.hit = bounces_[i].hit;
        return answer;
    }

    Scene scene_;
    Surfaces surfaces_;
    std::vector<Bounce> bounces_;
    std::vector<Surface> points_;
};

/// Triangles of size about 1 at `offset` from the origin; rays arrive and leave at angles with the
/// plane of about 1/steepness and more.
std::unique_ptr<Trial> bounces(const TrialRequest& request, double offset, double steepness) {
    Dice dice(request.seed);
    const Vec3d centre = Vec3d(0.61, 0.64, -0.47) * offset;
    std::vector<Mesh> meshes(1);
    Mesh& mesh = meshes[0];
    constexpr uint32_t count = 256;
    for (uint32_t i = 0; i < count; ++i) {
        const Vec3d place = centre + dice.vector(4);
        for (int k = 0; k < 3; ++k) mesh.positions.push_back(Vec3(place + dice.vector(1)));
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    std::vector<Ray> rays;
    std::vector<Vec3> directions;
    for (size_t i = 0; i < request.rays; ++i) {
        const auto& [a, b, c] = mesh.triangles[dice.below(count)];
        const Vec3d ab = Vec3d(mesh.positions[b]) - Vec3d(mesh.positions[a]);
        const Vec3d ac = Vec3d(mesh.positions[c]) - Vec3d(mesh.positions[a]);
        const Vec3d normal = normalize(cross(ab, ac)), x = normalize(ab), y = cross(normal, x);
        const double s = dice.between(0.05, 0.9), t = dice.between(0.05, 0.95 - s);
        const Vec3d target = Vec3d(mesh.positions[a]) + ab * s + ac * t;
        const double side = dice.sign();
        const auto leaving = [&] {
            const double turn = dice.between(0, 2 * M_PI), rise = dice.between(0.5, 1) / steepness;
            return x * std::cos(turn) + y * std::sin(turn) + normal * (side * rise);
        };
        rays.push_back(aimed_ray(target + leaving() * 0.3, target, dice));
        directions.push_back(Vec3(normalize(leaving())));
    }
    return std::make_unique<BounceTrial>(scene_of_meshes(std::move(meshes)), rays, directions);
}

}  // namespace

void add_bounce_families(std::vector<Family>& families) {
    std::vector<std::string> methods;
    for (const Offset& offset : offsets) methods.push_back(offset.name);
    auto distances = powers(10, 0, 6);
    distances.insert(distances.begin(), KnobValue{0});
    families.push_back({"N1", "bounces far from the origin", "offset / size", distances, methods,
                        [](const TrialRequest& r) { return bounces(r, r.knob, 1); }});
    families.push_back({"N2", "grazing bounces at an offset of 1000", "1 / angle", powers(10, 0, 5),
                        methods, [](const TrialRequest& r) { return bounces(r, 1e3, r.knob); }});
}

}  // namespace sightline
