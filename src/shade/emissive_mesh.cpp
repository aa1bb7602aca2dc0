#include "shade/emissive_mesh.h"

#include "core/parallel.h"

#include <algorithm>

namespace sightline {
namespace {

constexpr double max_divisions = 256;

double area(const Mesh& mesh, uint32_t triangle, const Mat4* to_world) {
    const auto [i0, i1, i2] = mesh.triangles[triangle];
    Vec3d edge1 = Vec3d(mesh.positions[i1]) - Vec3d(mesh.positions[i0]);
    Vec3d edge2 = Vec3d(mesh.positions[i2]) - Vec3d(mesh.positions[i0]);
    if (to_world) {
        const Mat4d m(*to_world);
        edge1 = transform_vector(edge1, m);
        edge2 = transform_vector(edge2, m);
    }
    return 0.5 * cross(edge1, edge2).length();
}

/// Where in a divided triangle a cell lies: its corner, in units of 1/n, and its orientation.
struct Cell {
    uint32_t a, b;
    bool upside_down;
};

Cell cell_at(uint32_t index, uint32_t n) {
    const uint32_t a = index / n, b = index % n;
    return a + b < n ? Cell{a, b, false} : Cell{n - 1 - a, n - 1 - b, true};
}

uint32_t cell_of(float u, float v, uint32_t n) {
    const auto scale = static_cast<float>(n);
    const uint32_t a = std::min(static_cast<uint32_t>(u * scale), n - 1);
    const uint32_t b = std::min(static_cast<uint32_t>(v * scale), n - 1 - a);
    const float x = u * scale - static_cast<float>(a), y = v * scale - static_cast<float>(b);
    const bool upside_down = x + y > 1 && a + b < n - 1;
    return upside_down ? (n - 1 - a) * n + (n - 1 - b) : a * n + b;
}

}  // namespace

EmissiveMesh::EmissiveMesh(const Scene& scene, const Surfaces& surfaces, uint32_t instance,
                           uint32_t geometry, unsigned threads)
    : scene_(scene), surfaces_(surfaces), instance_(instance), geometry_(geometry) {
    const Mesh& mesh = scene.meshes[geometry];
    const Material& m = scene.materials[mesh.material];
    const size_t count = mesh.triangles.size();
    const bool uniform_alpha =
        m.alpha_mode == AlphaMode::opaque || (!m.base_color_texture && mesh.colors.empty());
    area_.resize(count);
    for (uint32_t t = 0; t < count; ++t) area_[t] = area(mesh, t, nullptr);
    if (!m.emissive_texture && uniform_alpha) {
        emission_.assign(count, count > 0 ? estimate(0, {0, 0}, 1) : 0);
    } else {
        potential_ = luminance(m.emissive_factor);
        emission_.resize(count);
        constexpr size_t triangles_at_once = 256;
        const auto estimate_some = [&](size_t begin, size_t end) {
            for (size_t t = begin; t < end; ++t) estimate_triangle(static_cast<uint32_t>(t));
        };
        run_with_threads(threads,
                         [&] { parallel_ranges(count, estimate_some, triangles_at_once); });
    }
}

/// The mean over the part with the corner `corner` whose edges are `size` times the triangle's.
float EmissiveMesh::estimate(uint32_t triangle, Vec2 corner, float size) const {
    Hit hit;
    hit.instance = instance_;
    hit.geometry = geometry_;
    hit.primitive = triangle;
    hit.u = corner.x + size / 3;
    hit.v = corner.y + size / 3;
    return surfaces_.mean_emission(hit, std::fabs(size));
}

void EmissiveMesh::estimate_triangle(uint32_t triangle) {
    float mean = estimate(triangle, {0, 0}, 1);
    if (mean > 0) {
        mean = (estimate(triangle, {0, 0}, 0.5f) + estimate(triangle, {0.5f, 0}, 0.5f) +
                estimate(triangle, {0, 0.5f}, 0.5f) + estimate(triangle, {0.5f, 0.5f}, -0.5f)) /
               4;
    }
    emission_[triangle] = mean;
}

EmissiveMesh::Integral EmissiveMesh::over(const Instance& instance) const {
    const Mesh& mesh = scene_.meshes[geometry_];
    Integral sum;
    for (uint32_t t = 0; t < emission_.size(); ++t) {
        const double a = instance.baked ? area_[t] : area(mesh, t, &instance.object_to_world);
        sum.emission += a * static_cast<double>(emission_[t]);
        sum.potential += a * static_cast<double>(potential_);
    }
    sum.weight = sum.emission + static_cast<double>(floor_) * sum.potential;
    return sum;
}

double EmissiveMesh::weight(uint32_t triangle) const {
    return area_[triangle] * static_cast<double>(emission_[triangle] + floor_ * potential_);
}

void EmissiveMesh::prepare(float floor, double cells, unsigned threads) {
    floor_ = floor;
    std::vector<double> weights(emission_.size());
    double sum = 0;
    for (uint32_t t = 0; t < weights.size(); ++t) sum += weights[t] = weight(t);
    if (potential_ > 0) {
        std::vector<std::pair<uint32_t, uint32_t>> divided;  // triangle, n
        for (uint32_t t = 0; t < weights.size(); ++t) {
            const double n = std::min(std::sqrt(cells * weights[t] / sum), max_divisions);
            if (n >= 2) divided.emplace_back(t, static_cast<uint32_t>(n));
        }
        divided_triangles_.resize(divided.size());
        if (!divided.empty()) divided_.assign(emission_.size(), none);
        const auto divide_one = [&](size_t i) {
            const auto [triangle, n] = divided[i];
            divide(triangle, n, divided_triangles_[i]);
            divided_[triangle] = static_cast<uint32_t>(i);
            weights[triangle] = weight(triangle);
        };
        run_with_threads(threads, [&] { parallel_for(divided.size(), divide_one); });
    }
    triangles_ = DiscreteDistribution(weights);
}

/// Also replaces the estimate of the triangle by the mean over its cells.
void EmissiveMesh::divide(uint32_t triangle, uint32_t n, DividedTriangle& divided) {
    std::vector<double> weights(size_t{n} * n);
    const float size = 1 / static_cast<float>(n);
    double sum = 0;
    for (uint32_t i = 0; i < weights.size(); ++i) {
        const Cell cell = cell_at(i, n);
        const Vec2 corner(static_cast<float>(cell.a) * size, static_cast<float>(cell.b) * size);
        const float mean = cell.upside_down ? estimate(triangle, corner + Vec2(size), -size)
                                            : estimate(triangle, corner, size);
        sum += static_cast<double>(mean);
        weights[i] = static_cast<double>(mean + floor_ * potential_);
    }
    emission_[triangle] = static_cast<float>(sum / static_cast<double>(weights.size()));
    divided = {n, DiscreteDistribution(weights)};
}

EmissiveMesh::Point EmissiveMesh::sample(double pick, Vec2 u) const {
    Point point;
    point.triangle = static_cast<uint32_t>(triangles_.sample(pick));
    Cell cell{0, 0, false};
    float scale = 1;
    if (!divided_.empty() && divided_[point.triangle] != none) {
        const DividedTriangle& divided = divided_triangles_[divided_[point.triangle]];
        cell = cell_at(static_cast<uint32_t>(divided.cells.sample(pick)), divided.n);
        scale = static_cast<float>(divided.n);
    }
    // Folding the unit square along its diagonal gives uniform points on a half of it.
    if ((u.x + u.y > 1) != cell.upside_down) u = Vec2(1) - u;
    point.u = (static_cast<float>(cell.a) + u.x) / scale;
    point.v = (static_cast<float>(cell.b) + u.y) / scale;
    return point;
}

double EmissiveMesh::density(const Point& point) const {
    const double probability = triangles_.probability(point.triangle);
    if (divided_.empty() || divided_[point.triangle] == none) return probability;
    const auto& [n, cells] = divided_triangles_[divided_[point.triangle]];
    return probability * cells.probability(cell_of(point.u, point.v, n)) * n * n;
}

uint64_t EmissiveMesh::count() const {
    uint64_t count = 0;
    for (uint32_t t = 0; t < emission_.size(); ++t) count += weight(t) > 0;
    return count;
}

}  // namespace sightline
