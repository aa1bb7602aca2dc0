#include "lab/atlas/families.h"

#include "exact/triangle.h"
#include "intersect/embree/embree.h"
#include "lab/atlas/meshes.h"
#include "shade/surface.h"

#include <bit>

namespace sightline {
namespace {

/// A ray that hit a triangle, and its direction after that.
struct Bounce {
    Ray ray;
    Hit hit;
    Surface surface;
    Vec3 direction;
};

Vec3 point_on_ray(const Bounce& b) { return b.ray.origin + b.ray.direction * b.hit.t; }

/// The geometric normal on the side of the new direction.
Vec3 normal_towards_direction(const Bounce& b) {
    return dot(b.direction, b.surface.ng) >= 0 ? b.surface.ng : -b.surface.ng;
}

Ray from_error_bound(const Bounce& b) {
    return spawn_ray(b.surface, b.direction, std::numeric_limits<float>::infinity());
}
Ray from_point(const Bounce& b) { return {point_on_ray(b), 0, b.direction}; }
Ray from_normal(const Bounce& b) {
    return {point_on_ray(b) + normal_towards_direction(b) * 1e-4f, 0, b.direction};
}
Ray from_distance(const Bounce& b) { return {point_on_ray(b), 1e-4f, b.direction}; }

/// Wächter and Binder, A Fast and Robust Method for Avoiding Self-Intersection, Ray Tracing Gems
/// 2019, chapter 6: steps of 256·n units in the last place, or of n/65536 close to the origin.
Ray from_integers(const Bounce& b) {
    const Vec3 normal = normal_towards_direction(b), p = point_on_ray(b);
    Vec3 origin;
    for (int i = 0; i < 3; ++i) {
        const auto steps = static_cast<int32_t>(256 * normal[i]);
        const auto moved =
            std::bit_cast<float>(std::bit_cast<int32_t>(p[i]) + (p[i] < 0 ? -steps : steps));
        origin[i] = std::abs(p[i]) < 1.0f / 32 ? p[i] + normal[i] / 65536 : moved;
    }
    return {origin, 0, b.direction};
}

/// A way to start the bounce off its surface.
struct Offset {
    const char* name;
    Ray (*spawn)(const Bounce&);
};
constexpr Offset offsets[] = {{"offset-bound", from_error_bound},
                              {"offset-none", from_point},
                              {"offset-normal-1e-4", from_normal},
                              {"offset-tnear-1e-4", from_distance},
                              {"offset-wachter-binder", from_integers}};

/// The answer of a method that starts the bounce with `ray`: t is the height over the triangle at
/// which the ray starts, and a hit is one of the triangle that it leaves.
MethodAnswer answer_to(const Scene& scene, const Bounce& bounce, const Ray& ray) {
    const InstancedTriangle triangle = instanced_triangle(scene, surface_of(bounce.hit));
    const Vec3d corner(triangle.a);
    const Vec3d normal = normalize(cross(Vec3d(triangle.b) - corner, Vec3d(triangle.c) - corner));
    const Vec3d start = Vec3d(ray.origin) + Vec3d(ray.direction) * static_cast<double>(ray.tnear);
    MethodAnswer answer = answer_of(false, std::abs(dot(normal, start - corner)));
    if (exact_crossing(ray, triangle) == Crossing::hit) answer.hit = bounce.hit;
    return answer;
}

/// The truth is always a miss.
Problem<Bounce, bool> bounce_problem(const std::shared_ptr<const Scene>& scene) {
    std::vector<Method<Bounce>> methods;
    for (const Offset& offset : offsets)
        methods.push_back(case_method<Bounce>(
            offset.name, offset.spawn,
            [scene](const Bounce& b, const Ray& ray) { return answer_to(*scene, b, ray); }));
    return {.methods = std::move(methods),
            .solve = [](const Bounce&) { return false; },
            .is_hit = std::identity(),
            .measure = [](const Bounce&, bool,
                          const MethodAnswer& answer) { return Measures{.gap = answer.t}; }};
}

/// A bounce for each ray that hits something.
std::vector<Bounce> bounces_of(const Scene& scene, const std::vector<Ray>& rays,
                               const std::vector<Vec3>& directions) {
    const Surfaces surfaces(scene, false, 1);
    std::vector<Hit> hits(rays.size());
    make_embree(scene)->closest(rays, hits, Coherence::incoherent);
    std::vector<Bounce> bounces;
    for (size_t i = 0; i < rays.size(); ++i)
        if (hits[i])
            bounces.push_back({rays[i], hits[i], surfaces.at(rays[i], hits[i], 0), directions[i]});
    return bounces;
}

/// Triangles of size about 1 at a distance of about `offset` from the origin. Rays arrive and leave
/// at angles with the plane of about 1/steepness and more.
Experiment make_bounces(const ExperimentRequest& request, double offset, double steepness) {
    Rng rng(request.seed);
    const Vec3d centre = Vec3d(0.61, 0.64, -0.47) * offset;
    std::vector<Mesh> meshes(1);
    Mesh& mesh = meshes[0];
    constexpr uint32_t count = 256;
    for (uint32_t i = 0; i < count; ++i) {
        const Vec3d middle = centre + rng.in_cube(4);
        for (int k = 0; k < 3; ++k) mesh.positions.push_back(Vec3(middle + rng.in_cube(1)));
        mesh.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    std::vector<Ray> rays;
    std::vector<Vec3> directions;
    for (size_t i = 0; i < request.rays; ++i) {
        const auto& [a, b, c] = mesh.triangles[rng.below(count)];
        const Vec3d ab = Vec3d(mesh.positions[b]) - Vec3d(mesh.positions[a]);
        const Vec3d ac = Vec3d(mesh.positions[c]) - Vec3d(mesh.positions[a]);
        const Vec3d normal = normalize(cross(ab, ac)), x = normalize(ab), y = cross(normal, x);
        const double s = rng.uniform(0.05, 0.9), t = rng.uniform(0.05, 0.95 - s);
        const Vec3d target = Vec3d(mesh.positions[a]) + ab * s + ac * t;
        const double side = rng.sign();
        const auto leaving = [&] {
            const double turn = rng.uniform(0, 2 * M_PI), rise = rng.uniform(0.5, 1) / steepness;
            return x * std::cos(turn) + y * std::sin(turn) + normal * (side * rise);
        };
        rays.push_back(aimed_ray(target + leaving() * 0.3, target, rng));
        directions.push_back(Vec3(normalize(leaving())));
    }
    const auto scene = std::make_shared<const Scene>(scene_of_meshes(std::move(meshes)));
    return make_experiment(bounce_problem(scene), bounces_of(*scene, rays, directions));
}

}  // namespace

std::vector<Family> bounce_families() {
    const auto methods = names_of(offsets);
    return {{"N1", "bounces far from the origin", "offset / size", zero_and_powers(10, 0, 6),
             methods, [](const ExperimentRequest& r) { return make_bounces(r, r.knob, 1); }},
            {"N2", "grazing bounces at an offset of 1000", "1 / angle", powers(10, 0, 5), methods,
             [](const ExperimentRequest& r) { return make_bounces(r, 1e3, r.knob); }}};
}

}  // namespace sightline
