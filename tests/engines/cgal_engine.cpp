// An engine of another origin for engines_cgal_test.py: the AABB tree of CGAL answers recorded
// rays. It is written from docs/engines.md and docs/truth.md and shares no code with src/. Every
// decision is one of CGAL's exact predicates; the nearest hit is chosen by exact rational
// distances.
//
//   cgal_engine TRIANGLES RAYS ANSWERS [farthest]
//
// `farthest` answers with the last hit instead of the first, to show that the test can fail.
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>

#include <algorithm>
#include <array>
#include <cfloat>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Number = Kernel::FT;
using Point = Kernel::Point_3;
using Vector = Kernel::Vector_3;

constexpr uint32_t none = 0xFFFFFFFF;
constexpr size_t kinds = 4;

// The records of docs/engines.md.
struct RayRecord {
    float origin[3], tnear, direction[3], tfar;
    uint32_t kind, source[3];
};
struct Placement {
    uint32_t instance, geometry;
    float matrix[4][3];
};
struct Answer {
    uint32_t instance = none, geometry = none, primitive = none;
    float t = 0, u = 0, v = 0;
    uint32_t occluded = 0;
};
static_assert(sizeof(RayRecord) == 48 && sizeof(Placement) == 56 && sizeof(Answer) == 28);

struct Mesh {
    std::vector<std::array<float, 3>> positions;
    std::vector<std::array<uint32_t, 3>> triangles;
};

/// A triangle of the world and its instance, geometry and primitive.
struct Face {
    Kernel::Triangle_3 triangle;
    std::tuple<uint32_t, uint32_t, uint32_t> id;
};

/// How CGAL's tree gets at a face.
struct Primitive {
    using Id = const Face*;
    using Point = ::Point;
    using Datum = Kernel::Triangle_3;
    using Datum_reference = const Datum&;

    explicit Primitive(std::vector<Face>::const_iterator at) : face(&*at) {}
    Id id() const { return face; }
    Datum_reference datum() const { return face->triangle; }
    Point reference_point() const { return face->triangle.vertex(0); }

    const Face* face;
};
using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, Primitive>>;

template <class T>
std::vector<T> take(std::istream& file, uint64_t count) {
    std::vector<T> items(count);
    file.read(reinterpret_cast<char*>(items.data()),
              static_cast<std::streamsize>(count * sizeof(T)));
    if (!file) throw std::runtime_error("a file is truncated");
    return items;
}

std::ifstream open(const char* path, const std::string& magic) {
    std::ifstream file(path, std::ios::binary);
    const auto begin = take<char>(file, magic.size());
    if (std::string(begin.begin(), begin.end()) != magic)
        throw std::runtime_error(std::string(path) + " is of another format");
    return file;
}

/// p · m, without rounding.
Point placed(const std::array<float, 3>& p, const Placement& placement) {
    Number sums[3];
    for (int j = 0; j < 3; ++j) {
        sums[j] = Number(placement.matrix[3][j]);
        for (size_t i = 0; i < 3; ++i) sums[j] += Number(p[i]) * Number(placement.matrix[i][j]);
        CGAL::exact(sums[j]);
    }
    return {sums[0], sums[1], sums[2]};
}

/// All triangles that have an area; the others are not hit, and CGAL's predicates exclude them.
std::vector<Face> read_faces(const char* path, uint64_t& scene_hash) {
    std::ifstream file = open(path, "SLTRIS1\n");
    const auto header = take<uint64_t>(file, 3);
    scene_hash = header[0];
    std::vector<Mesh> meshes(header[1]);
    for (Mesh& mesh : meshes) {
        const auto counts = take<uint64_t>(file, 2);
        mesh.positions = take<std::array<float, 3>>(file, counts[0]);
        mesh.triangles = take<std::array<uint32_t, 3>>(file, counts[1]);
    }
    std::vector<Face> faces;
    for (const Placement& placement : take<Placement>(file, header[2])) {
        const Mesh& mesh = meshes.at(placement.geometry);
        std::vector<Point> points;
        for (const auto& position : mesh.positions) points.push_back(placed(position, placement));
        for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
            const auto& [a, b, c] = mesh.triangles[i];
            const Kernel::Triangle_3 triangle(points.at(a), points.at(b), points.at(c));
            if (triangle.is_degenerate()) continue;
            faces.push_back({triangle, {placement.instance, placement.geometry, i}});
        }
    }
    return faces;
}

bool is_valid(const RayRecord& ray) {
    bool finite = std::isfinite(ray.tnear), moves = false;
    for (int k = 0; k < 3; ++k) {
        finite &= std::isfinite(ray.origin[k]) && std::isfinite(ray.direction[k]);
        moves |= ray.direction[k] != 0;
    }
    return finite && moves && ray.tnear >= 0 && ray.tfar > ray.tnear;
}

/// A number as the nearest float in (low, high], which contains it.
float rounded(const Number& number, float low = -INFINITY, float high = INFINITY) {
    const auto nearest = static_cast<float>(CGAL::to_double(CGAL::exact(number)));
    return std::min(std::max(nearest, std::nextafter(low, INFINITY)), std::min(high, FLT_MAX));
}

/// Where a ray meets the plane of a triangle, if it crosses the plane.
std::optional<Number> crossing(const Point& origin, const Vector& direction,
                               const Kernel::Triangle_3& triangle) {
    const Vector normal = triangle.supporting_plane().orthogonal_vector();
    const Number speed = normal * direction;
    if (speed == 0) return {};
    return normal * (triangle.vertex(0) - origin) / speed;
}

/// The weights of the second and third vertex at a point of the triangle's plane.
std::pair<Number, Number> weights(const Point& point, const Kernel::Triangle_3& triangle) {
    const Vector ab = triangle.vertex(1) - triangle.vertex(0),
                 ac = triangle.vertex(2) - triangle.vertex(0), ap = point - triangle.vertex(0);
    const Vector normal = CGAL::cross_product(ab, ac);
    const Number whole = normal * normal;
    return {CGAL::cross_product(ap, ac) * normal / whole,
            CGAL::cross_product(ab, ap) * normal / whole};
}

Answer answer(const Tree& tree, const RayRecord& ray, bool farthest) {
    if (!is_valid(ray)) return {};
    const auto &o = ray.origin, &d = ray.direction;
    const Point origin(o[0], o[1], o[2]);
    const Vector direction(d[0], d[1], d[2]);
    std::vector<const Face*> touched;
    if (std::isinf(ray.tfar))
        tree.all_intersected_primitives(Kernel::Ray_3(origin, direction),
                                        std::back_inserter(touched));
    else
        tree.all_intersected_primitives(
            Kernel::Segment_3(origin, origin + Number(ray.tfar) * direction),
            std::back_inserter(touched));
    const Face* best = nullptr;
    Number best_t;
    for (const Face* face : touched) {
        const auto t = crossing(origin, direction, face->triangle);
        if (!t || *t <= Number(ray.tnear)) continue;
        const auto order = best ? CGAL::compare(*t, best_t) : CGAL::SMALLER;
        const bool first = order == CGAL::EQUAL ? face->id < best->id
                                                : !best || (order == CGAL::LARGER) == farthest;
        if (!first) continue;
        best = face;
        best_t = *t;
    }
    if (!best) return {};
    const auto [u, v] = weights(origin + best_t * direction, best->triangle);
    const auto [instance, geometry, primitive] = best->id;
    return {instance,   geometry,   primitive, rounded(best_t, ray.tnear, ray.tfar),
            rounded(u), rounded(v), 1};
}

template <class T>
void put(std::ostream& file, const T* items, size_t count) {
    file.write(reinterpret_cast<const char*>(items),
               static_cast<std::streamsize>(count * sizeof(T)));
}

void run(const char* triangles, const char* rays_path, const char* answers_path, bool farthest) {
    uint64_t scene_hash = 0;
    const std::vector<Face> faces = read_faces(triangles, scene_hash);
    Tree tree(faces.begin(), faces.end());
    tree.build();
    std::ifstream file = open(rays_path, "SLRAYS2\n");
    const auto header = take<uint64_t>(file, 3);
    take<double>(file, 4);  // the frame: the triangles are in the same coordinates
    const auto rays = take<RayRecord>(file, header[0]);
    std::vector<Answer> answers;
    double nanoseconds[kinds] = {}, counts[kinds] = {};
    for (const RayRecord& ray : rays) {
        const auto begin = std::chrono::steady_clock::now();
        answers.push_back(answer(tree, ray, farthest));
        const std::chrono::duration<double, std::nano> time =
            std::chrono::steady_clock::now() - begin;
        if (ray.kind >= kinds) throw std::runtime_error("a ray is of an unknown kind");
        nanoseconds[ray.kind] += time.count();
        ++counts[ray.kind];
    }
    for (size_t kind = 0; kind < kinds; ++kind) nanoseconds[kind] /= counts[kind];
    std::ofstream out(answers_path, std::ios::binary);
    const uint64_t out_header[] = {header[0], scene_hash, header[2]};
    out << "SLANSW1\n";
    put(out, out_header, 3);
    put(out, answers.data(), answers.size());
    put(out, nanoseconds, kinds);
    if (!out.flush()) throw std::runtime_error(std::string(answers_path) + " cannot be written");
}

}  // namespace

int main(int argc, char** argv) {
    const bool farthest = argc == 5 && std::string(argv[4]) == "farthest";
    if (argc != 4 && !farthest) {
        std::cerr << "usage: cgal_engine TRIANGLES RAYS ANSWERS [farthest]\n";
        return 2;
    }
    try {
        run(argv[1], argv[2], argv[3], farthest);
    } catch (const std::exception& error) {
        std::cerr << "cgal_engine: " << error.what() << "\n";
        return 1;
    }
    return 0;
}
