#include "shade/fresnel.h"

#include "shade/bsdf.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sightline {
namespace {

Vec3 direction(float theta, float phi) {
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

TEST(Fresnel, HasItsKnownValues) {
    EXPECT_NEAR(fresnel_dielectric(1, 1.5f), 0.04f, 1e-6f);
    EXPECT_NEAR(fresnel_dielectric(1, 1 / 1.5f), 0.04f, 1e-6f);
    EXPECT_NEAR(fresnel_dielectric(1, 2.42f), 0.17240f, 1e-5f);  // diamond
    EXPECT_NEAR(fresnel_dielectric(0, 1.5f), 1, 1e-6f);
    EXPECT_NEAR(fresnel_dielectric(0.3f, 1), 0, 1e-6f);
    // At Brewster's angle only half of the light, the s-polarised, reflects.
    const float brewster = std::cos(std::atan(1.5f));
    const float rs = (1.5f * 1.5f - 1) / (1.5f * 1.5f + 1);
    EXPECT_NEAR(fresnel_dielectric(brewster, 1.5f), 0.5f * rs * rs, 1e-6f);
}

TEST(Fresnel, IsTotalBeyondTheCriticalAngle) {
    const float critical = std::asin(1 / 1.5f);
    EXPECT_EQ(fresnel_dielectric(std::cos(critical + 1e-3f), 1 / 1.5f), 1);
    EXPECT_LT(fresnel_dielectric(std::cos(critical - 1e-3f), 1 / 1.5f), 0.9f);
    EXPECT_EQ(fresnel_dielectric(0.5f, 0), 1);  // KHR_materials_ior's special value
}

TEST(Fresnel, IsTheSameFromBothSides) {
    for (float theta = 0.05f; theta < 1.5f; theta += 0.1f) {
        const float inside = std::asin(std::sin(theta) / 1.5f);
        EXPECT_NEAR(fresnel_dielectric(std::cos(theta), 1.5f),
                    fresnel_dielectric(std::cos(inside), 1 / 1.5f), 1e-5f);
    }
}

TEST(Fresnel, OfAVanishingFilmIsThatOfItsBase) {
    for (const float f0 : {0.04f, 0.5f, 0.95f}) {
        EXPECT_NEAR(fresnel_thin_film(1, 1.3f, 0, Vec3(f0)).x, f0, 0.01f);
    }
    const Vec3 film = fresnel_thin_film(0.7f, 1.3f, 400, Vec3(0.04f));
    for (int i = 0; i < 3; ++i) EXPECT_TRUE(film[i] >= 0 && film[i] <= 1);
    EXPECT_GT(max_component(film) - std::min({film.x, film.y, film.z}), 0.005f);  // it has colour
}

TEST(Refract, ObeysSnellsLaw) {
    for (const float eta : {1.5f, 1 / 1.5f, 1.0f, 2.4f}) {
        for (float theta = 0; theta < 0.7f; theta += 0.05f) {
            Vec3 t;
            ASSERT_TRUE(refract(direction(theta, 0.3f), {0, 0, 1}, eta, t));
            EXPECT_NEAR(t.length(), 1, 1e-6f);
            EXPECT_LT(t.z, 0);
            EXPECT_NEAR(std::hypot(t.x, t.y) * eta, std::sin(theta), 1e-6f);
            EXPECT_LE(t.x, 0);  // on the far side
        }
    }
}

TEST(Refract, FailsAtAndBeyondTheCriticalAngle) {
    const float critical = std::asin(1 / 1.5f);
    Vec3 t;
    EXPECT_TRUE(refract(direction(critical - 1e-3f, 0), {0, 0, 1}, 1 / 1.5f, t));
    EXPECT_FALSE(refract(direction(critical + 1e-3f, 0), {0, 0, 1}, 1 / 1.5f, t));
}

TEST(Reflect, MirrorsAtTheNormal) {
    const Vec3 r = reflect(direction(0.6f, 1), {0, 0, 1});
    EXPECT_NEAR((r - direction(0.6f, 1 + pi)).length(), 0, 1e-6f);
}

}  // namespace
}  // namespace sightline
