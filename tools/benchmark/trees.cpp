// The exact engine compared with Embree, ray by ray on one thread, in rooms full of uneven balls.
// trees TRIANGLES|cables [ROUNDS] prints one line of JSON: for each kind of ray and engine the
// median nanoseconds per ray, and the seconds and bytes of the builds. The engines take turns.
// `cables` is a room with 1,000 long diagonal cables instead, with Embree's spatial splits on.
#include "core/parallel.h"
#include "intersect/engines.h"
#include "scene/scene_builder.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <random>

namespace {

using namespace sightline;
using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

std::mt19937 generator(1);

float between(float low, float high) {
    return low + (high - low) * static_cast<float>(generator() >> 8) * 0x1p-24f;
}

Vec3 direction() {
    for (;;) {
        const float x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
        const float length2 = x * x + y * y + z * z;
        if (length2 > 0.01f && length2 <= 1) return Vec3(x, y, z) / std::sqrt(length2);
    }
}

/// A grid of columns × rows over the unit square, bent by `place(u, v)`.
template <class Place>
void add_sheet(Mesh& mesh, uint32_t columns, uint32_t rows, const Place& place) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (uint32_t i = 0; i <= rows; ++i)
        for (uint32_t j = 0; j <= columns; ++j)
            mesh.positions.push_back(place(static_cast<float>(j) / static_cast<float>(columns),
                                           static_cast<float>(i) / static_cast<float>(rows)));
    for (uint32_t i = 0; i < rows; ++i)
        for (uint32_t j = 0; j < columns; ++j) {
            const uint32_t a = first + i * (columns + 1) + j, b = a + columns + 1;
            mesh.triangles.push_back({a, b, a + 1});
            mesh.triangles.push_back({a + 1, b, b + 1});
        }
}

/// A ball with bumps of a few of its triangles' size.
void add_ball(Mesh& mesh, const Vec3& centre, float radius, uint32_t rows) {
    add_sheet(mesh, 2 * rows, rows, [&](float u, float v) {
        const float a = 2 * pi * u, b = pi * v;
        const float bump = 1 + 0.05f * std::sin(17 * a) * std::sin(13 * b);
        return centre + Vec3(std::sin(b) * std::cos(a), std::cos(b), std::sin(b) * std::sin(a)) *
                            (radius * bump);
    });
}

/// The walls of a room of 10 × 4 × 10.
Mesh walls() {
    Mesh mesh;
    const Vec3 corner(-5, 0, -5);
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {0.0f, 1.0f})
            add_sheet(mesh, 1, 1, [&](float u, float v) {
                Vec3 p;
                p[axis] = side, p[(axis + 1) % 3] = u, p[(axis + 2) % 3] = v;
                return corner + p * Vec3(10, 4, 10);
            });
    return mesh;
}

/// The mesh as a scene.
Scene scene_of(Mesh mesh) {
    SceneBuilder builder;
    builder.add_instance(builder.add_mesh(std::move(mesh)));
    return builder.finish();
}

/// A room with balls all over it, about `triangles` of them in 48 balls (fewer in small rooms).
Scene room(uint32_t triangles) {
    Mesh mesh = walls();
    const uint32_t balls = std::clamp(triangles / 72, 1u, 48u);
    const auto rows = static_cast<uint32_t>(
        std::sqrt(static_cast<float>(triangles) / static_cast<float>(4 * balls)));
    for (uint32_t i = 0; i < balls; ++i)
        add_ball(mesh, {between(-4.5f, 4.5f), between(0.3f, 3.5f), between(-4.5f, 4.5f)},
                 between(0.2f, 0.7f), rows);
    return scene_of(std::move(mesh));
}

/// A room with straight cables of six sides from one half to the other, all ways.
Scene room_of_cables(uint32_t cables) {
    Mesh mesh = walls();
    for (uint32_t i = 0; i < cables; ++i) {
        const Vec3 from(between(-4.8f, 0), between(0.2f, 3.8f), between(-4.8f, 4.8f));
        const Vec3 along = Vec3(between(0, 4.8f), between(0.2f, 3.8f), between(-4.8f, 4.8f)) - from;
        const Vec3 x = normalize(cross(along, Vec3(0.3f, 1, 0.2f))), y = cross(normalize(along), x);
        add_sheet(mesh, 6, 1, [&](float u, float v) {
            const float a = 2 * pi * u;
            return from + along * v + (x * std::cos(a) + y * std::sin(a)) * 0.006f;
        });
    }
    return scene_of(std::move(mesh));
}

struct Kind {
    const char* name;
    std::vector<Ray> rays;
    bool any_hit;
};

/// Camera rays in 4 × 4 blocks, one bounce from each of their hits in a random direction of the
/// hemisphere, one shadow ray to a lamp; and rays from anywhere in the room to anywhere.
std::vector<Kind> make_rays(const Scene& scene, const Intersector& engine, int width) {
    Kind camera{"camera", {}, false}, bounce{"bounce", {}, false}, shadow{"shadow", {}, true},
        random{"random", {}, false};
    for (int i = 0; i < width * width; ++i) {
        const int block = i / 16, in = i % 16;
        const int x = block % (width / 4) * 4 + in % 4, y = block / (width / 4) * 4 + in / 4;
        const Vec3 to((static_cast<float>(x) + 0.5f) / static_cast<float>(width) - 0.5f,
                      0.5f - (static_cast<float>(y) + 0.5f) / static_cast<float>(width), -0.6f);
        camera.rays.push_back({{0.1f, 1.9f, 4.9f}, 0, normalize(to)});
    }
    std::vector<Hit> hits(camera.rays.size());
    engine.closest(camera.rays, hits, Coherence::coherent);
    const Vec3 lamp(0.5f, 3.9f, 0.3f);
    const Mesh& mesh = scene.meshes[0];
    for (size_t i = 0; i < hits.size(); ++i) {
        if (!hits[i]) continue;
        const Ray& ray = camera.rays[i];
        const auto [a, b, c] = mesh.triangles[hits[i].primitive];
        Vec3 n = normalize(
            cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]));
        if (dot(n, ray.direction) > 0) n = -n;
        const Vec3 p = ray.origin + ray.direction * hits[i].t + n * 1e-4f;
        const Vec3 d = direction();
        bounce.rays.push_back({p, 0, dot(d, n) < 0 ? -d : d});
        shadow.rays.push_back({p, 0, lamp - p, 1});
    }
    for (int i = 0; i < width * width; ++i)
        random.rays.push_back({{between(-5, 5), between(0, 4), between(-5, 5)}, 0, direction()});
    return {camera, bounce, shadow, random};
}

double trace(const Engine& engine, const Kind& kind) {
    std::vector<Hit> hits(kind.rays.size());
    std::vector<uint8_t> blocked(kind.rays.size());
    const Clock::time_point start = Clock::now();
    if (kind.any_hit)
        engine.intersector->occluded(kind.rays, blocked, Coherence::coherent);
    else
        engine.intersector->closest(kind.rays, hits, Coherence::coherent);
    return seconds_since(start) * 1e9 / static_cast<double>(kind.rays.size());
}

double median(std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

}  // namespace

int main(int argc, char** argv) {
    const std::string_view what = argc > 1 ? argv[1] : "100000";
    const int rounds = argc > 2 ? std::atoi(argv[2]) : 7;
    const bool cables = what == "cables";
    const Scene scene =
        cables ? room_of_cables(1000) : room(static_cast<uint32_t>(std::atol(what.data())));
    const size_t count = scene.meshes[0].triangles.size();
    fmt::print("{{\"triangles\": {}", count);
    std::vector<Engine> engines;
    EmbreeOptions one_thread;
    one_thread.threads = 1;
    if (cables) one_thread.quality = BuildQuality::high;
    for (const char* name : {"embree-single", "embree-default-single", "embree@incoherent",
                             "exact@coherent", "exact@incoherent"}) {
        const Clock::time_point start = Clock::now();
        engines.push_back({name, make_engine(scene, name, one_thread)});
        fmt::print(
            ", \"{} build\": [{:.4f}, {:.1f}]", name, seconds_since(start),
            static_cast<double>(engines.back().intersector->memory()) / static_cast<double>(count));
    }
    for (const Kind& kind : make_rays(scene, *engines[0].intersector, 512)) {
        std::vector<std::vector<double>> times(engines.size());
        for (int round = 0; round <= rounds; ++round)
            for (size_t i = 0; i < engines.size(); ++i) {
                const double t = trace(engines[i], kind);
                if (round > 0) times[i].push_back(t);
            }
        for (size_t i = 0; i < engines.size(); ++i)
            fmt::print(", \"{} {}\": {:.1f}", engines[i].name, kind.name, median(times[i]));
    }
    fmt::print("}}\n");
    return 0;
}
