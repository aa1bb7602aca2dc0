// Each triangle method against the referee: right in its safe region, wrong outside it at about
// the rates known of it.
#include "intersect/methods/triangle_methods.h"
#include "core/error.h"
#include "exact/arithmetic.h"
#include "exact/triangle.h"
#include "intersect/methods/watertight.h"
#include "support/rays.h"
#include "support/scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace sightline {
namespace {

std::vector<Corners<float>> corners_of(const Mesh& mesh) {
    std::vector<Corners<float>> result;
    for (const auto& [a, b, c] : mesh.triangles)
        result.push_back({mesh.positions[a], mesh.positions[b], mesh.positions[c]});
    return result;
}

/// The number of rays, all from inside the closed mesh, that each method loses.
std::map<std::string, int> leaks(const Mesh& mesh, Aim aim, int rays) {
    const auto triangles = corners_of(mesh);
    std::map<std::string, int> result;
    for (const TriangleMethod& method : triangle_methods()) {
        const auto set = method.prepare(triangles);
        TestRandom random;
        for (int i = 0; i < rays; ++i) {
            NearestTriangle best{std::numeric_limits<double>::infinity()};
            set->nearest(aimed_ray(mesh, aim, random), 0, static_cast<uint32_t>(triangles.size()),
                         best);
            result[method.name] += best.index == none;
        }
    }
    return result;
}

TEST(TriangleMethods, NoneLeaksRandomRays) {
    for (const auto& [name, count] : leaks(globe(16), Aim::anywhere, 500))
        EXPECT_EQ(count, 0) << name;
}

TEST(TriangleMethods, OnlyWatertightMethodsLoseNoRaysAimedAtEdges) {
    // Of 20,000: plane 3081, Snyder-Barr 1700, Möller-Trumbore 1646, Plücker and Woop none.
    auto count = leaks(globe(16), Aim::edge, 2000);
    EXPECT_NEAR(count["plane-inside"], 308, 150);
    EXPECT_NEAR(count["snyder-barr"], 170, 100);
    EXPECT_NEAR(count["moller-trumbore"], 165, 100);
    EXPECT_GT(count["baldwin-weber"], 50);
    for (const char* name :
         {"plucker", "woop", "woop-products", "exact-filtered", "moller-trumbore-double",
          "plucker-double", "woop-double", "exact-filtered-double"})
        EXPECT_EQ(count[name], 0) << name;
}

TEST(TriangleMethods, OnlyWatertightMethodsLoseNoRaysAimedAtVertices) {
    auto count = leaks(globe(16), Aim::vertex, 2000);
    EXPECT_NEAR(count["plane-inside"], 301, 150);
    EXPECT_NEAR(count["snyder-barr"], 107, 70);
    EXPECT_NEAR(count["moller-trumbore"], 107, 70);
    for (const char* name :
         {"woop", "woop-products", "exact-filtered", "woop-double", "exact-filtered-double"})
        EXPECT_EQ(count[name], 0) << name;
}

TEST(TriangleMethods, AgreeWithTheRefereeAwayFromEdges) {
    TestRandom random;
    int hits = 0;
    for (int i = 0; i < 500; ++i) {
        const Corners<float> p = {random.vector(1), random.vector(1), random.vector(1)};
        const Ray ray = {random.vector(2), 0, random.vector(1)};
        const InstancedTriangle exact = {p.a, p.b, p.c};
        const ExactHit line = exact_hit(ray, exact);
        const double clearance = std::min(
            {std::abs(line.u), std::abs(line.v), std::abs(line.t), std::abs(1 - line.u - line.v)});
        if (clearance < 1e-2) continue;
        const bool expected = exact_crossing(ray, exact) == Crossing::hit;
        hits += expected;
        for (const TriangleMethod& method : triangle_methods()) {
            const auto hit = method.prepare(std::span(&p, 1))->test(ray, 0);
            ASSERT_EQ(hit.has_value(), expected) << method.name;
            if (!hit) continue;
            EXPECT_NEAR(hit->t, line.t, 1e-3 * line.t) << method.name;
            EXPECT_NEAR(hit->u, line.u, 1e-3) << method.name;
            EXPECT_NEAR(hit->v, line.v, 1e-3) << method.name;
        }
    }
    EXPECT_GT(hits, 5);
}

/// Slivers of aspect 10,000 at 100 times their length, aimed at within their own size.
TEST(TriangleMethods, OnDistantSliversExactIsNeverWrongAndFloatOftenIs) {
    TestRandom random;
    std::map<std::string, int> wrong;
    for (int i = 0; i < 3000; ++i) {
        const Vec3 a = random.vector(1) + Vec3(100, 0, 0);
        const Vec3 along = random.vector(1), across = random.vector(1e-4f);
        const Corners<float> p = {a, a + along, a + along * 0.5f + across};
        const Vec3 origin = random.vector(1);
        const Ray ray = {origin, 0, a + along * random.between(0, 1) + across * 0.2f - origin};
        const bool expected = exact_crossing(ray, {p.a, p.b, p.c}) == Crossing::hit;
        for (const TriangleMethod& method : triangle_methods())
            wrong[method.name] +=
                method.prepare(std::span(&p, 1))->test(ray, 0).has_value() != expected;
    }
    EXPECT_EQ(wrong["exact-filtered"], 0);
    EXPECT_EQ(wrong["exact-filtered-double"], 0);
    EXPECT_EQ(wrong["moller-trumbore-double"], 0);
    EXPECT_GT(wrong["moller-trumbore"], 3);
    EXPECT_GT(wrong["baldwin-weber"], wrong["moller-trumbore"]);
}

TEST(TriangleMethods, ExactIsRightAtEveryScale) {
    for (const float size : {1e-18f, 1e-9f, 1.0f, 1e9f, 1e12f})
        for (const float speed : {1e-15f, 1.0f, 1e15f}) {
            const Corners<float> p = {{0, 0, 0}, {size, 0, 0}, {0, size, 0}};
            const Ray ray = {{size / 4, size / 4, size}, 0, {0, 0, -speed}};
            EXPECT_TRUE(triangle_method("exact-filtered").prepare(std::span(&p, 1))->test(ray, 0));
        }
}

TEST(TriangleMethods, AnUnknownNameIsAnErrorThatListsAllNames) {
    try {
        triangle_method("moller");
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("'moller'"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("woop-products-double"), std::string::npos);
    }
}

/// A float that counts its operations.
struct Counted {
    static inline int divisions, multiplications, additions;
    float value = 0;

    Counted() = default;
    explicit Counted(float v) : value(v) {}
    explicit Counted(int v) : value(static_cast<float>(v)) {}
    friend Counted operator+(Counted a, Counted b) {
        return ++additions, Counted(a.value + b.value);
    }
    friend Counted operator-(Counted a, Counted b) {
        return ++additions, Counted(a.value - b.value);
    }
    friend Counted operator*(Counted a, Counted b) {
        return ++multiplications, Counted(a.value * b.value);
    }
    friend Counted operator/(Counted a, Counted b) {
        return ++divisions, Counted(a.value / b.value);
    }
    friend bool operator==(Counted a, Counted b) { return a.value == b.value; }
    friend bool operator<(Counted a, Counted b) { return a.value < b.value; }
    friend bool operator>(Counted a, Counted b) { return a.value > b.value; }
    static void reset() { divisions = multiplications = additions = 0; }
};

Imath::Vec3<Counted> counted(float x, float y, float z) {
    return {Counted(x), Counted(y), Counted(z)};
}

TEST(TriangleMethods, MollerTrumboreDividesOnceMultiplies27TimesAdds17) {
    using Method = MollerTrumbore<Counted>;
    const auto triangle = Method::prepare({counted(0, 0, 0), counted(1, 0, 0), counted(0, 1, 0)});
    const Method method(counted(0.25f, 0.25f, 1), counted(0, 0, -1));
    Counted::reset();
    ASSERT_TRUE(method(triangle));
    EXPECT_EQ(Counted::divisions, 1);
    EXPECT_EQ(Counted::multiplications, 27);
    EXPECT_EQ(Counted::additions, 17 + 1);  // and one to compare u + v with 1
}

TEST(PlaneMethods, AxisAlignedNeedsOneSubtractionAndOneDivision) {
    Counted::reset();
    const auto t = axis_plane_t(counted(0, 0, 3), counted(0, 0, -2), 2, Counted(1));
    ASSERT_TRUE(t);
    EXPECT_EQ(t->value, 1);
    EXPECT_EQ(Counted::divisions, 1);
    EXPECT_EQ(Counted::additions, 1);
    EXPECT_EQ(Counted::multiplications, 0);
    EXPECT_FALSE(axis_plane_t(counted(0, 0, 3), counted(1, 0, 0), 2, Counted(1)));
    EXPECT_EQ(
        plane_t(counted(0, 0, 3), counted(0, 0, -2), counted(5, 5, 1), counted(0, 0, 7))->value, 1);
}

TEST(Arithmetic, IsNeitherContractedNorFlushed) {
    EXPECT_NO_THROW(check_arithmetic());
    const float x = 1 + 0x1p-12f;
    EXPECT_NE(std::fma(x, x, -(x * x)), 0);  // the value of a contracted x·x − x·x
    EXPECT_EQ(widened_edge(x, x, x, x), 0);
}

}  // namespace
}  // namespace sightline
