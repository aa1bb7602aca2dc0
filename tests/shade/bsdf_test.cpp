#include "support/surfaces.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(Bsdf, SmoothGlassLosesNothing) {
    for (const bool entering : {true, false}) {
        for (float theta = 0; theta < 1.55f; theta += 0.1f) {
            sample_many(glass(theta, 0, entering), 1, [&](const auto& rays, int count) {
                float sum = 0;
                for (int i = 0; i < count; ++i) sum += rays[static_cast<size_t>(i)].weight.x;
                EXPECT_NEAR(sum, 1, 1e-5f) << theta;
                EXPECT_EQ(rays[0].pdf, 0);
            });
        }
    }
}

TEST(Bsdf, SmoothGlassReflectsTotallyBeyondTheCriticalAngle) {
    sample_many(glass(0.9f, 0, false), 1, [](const auto& rays, int count) {
        ASSERT_EQ(count, 1);
        EXPECT_FALSE(rays[0].refracted);
        EXPECT_EQ(rays[0].weight.x, 1);
    });
}

TEST(Bsdf, GlassMarksRaysThatEnterOrLeaveAVolume) {
    for (const bool entering : {true, false}) {
        sample_many(glass(0.3f, 0, entering), 1, [&](const auto& rays, int count) {
            ASSERT_EQ(count, 2);
            EXPECT_TRUE(rays[1].refracted);
            EXPECT_EQ(rays[1].enters_volume, entering);
            EXPECT_EQ(rays[1].leaves_volume, !entering);
        });
    }
}

TEST(Bsdf, ThinGlassDoesNotBendLight) {
    const Surface s = thin_glass(0.7f, 0);
    sample_many(s, 1, [&](const auto& rays, int count) {
        ASSERT_EQ(count, 2);
        EXPECT_EQ(rays[1].direction, -s.wo);
        const float reflected = fresnel_dielectric(std::cos(0.7f), 1.5f);
        EXPECT_NEAR(rays[0].weight.x, reflected, 1e-6f);
        EXPECT_NEAR(rays[1].weight.x, 1 - reflected, 1e-6f);
        EXPECT_FALSE(rays[1].enters_volume);
    });
}

TEST(Bsdf, MirrorReflectsAllOfAWhiteFurnace) {
    sample_many(metal(0.5f, 0), 1, [](const auto& rays, int count) {
        ASSERT_EQ(count, 1);
        EXPECT_NEAR(rays[0].weight.x, 1, 1e-6f);
        EXPECT_EQ(rays[0].direction, reflect(direction(0.5f, 0.4f), {0, 0, 1}));
    });
}

/// Directional albedo of white GGX with height-correlated Smith masking: written out in double
/// from Walter et al. 2007 and Heitz 2014, in tangents, and integrated on its own grid.
double ggx_albedo(double theta, double alpha) {
    const double tau = 6.283185307179586, sin_o = std::sin(theta), cos_o = std::cos(theta);
    const auto lambda = [&](double c) {
        const double tan2 = (1 - c * c) / (c * c);
        return (std::sqrt(1 + alpha * alpha * tan2) - 1) / 2;
    };
    const int n = 600;
    double sum = 0;
    for (int i = 0; i < n; ++i) {
        const double cos_i = (i + 0.5) / n, sin_i = std::sqrt(1 - cos_i * cos_i);
        for (int j = 0; j < n; ++j) {
            const double cosine = sin_i * sin_o * std::cos(tau * (j + 0.5) / n) + cos_i * cos_o;
            const double cos_h = (cos_i + cos_o) / std::sqrt(2 + 2 * cosine);
            const double tan2_h = 1 / (cos_h * cos_h) - 1;
            const double k = 1 + tan2_h / (alpha * alpha);
            const double d = 2 / (tau * alpha * alpha * std::pow(cos_h, 4) * k * k);
            sum += d / (1 + lambda(cos_o) + lambda(cos_i)) / (4 * cos_o);
        }
    }
    return sum * tau / n / n;
}

TEST(Bsdf, TheTableOfTheLobeHoldsItsAlbedo) {
    for (const float roughness : {0.5f, 0.8f, 0.93f, 1.0f}) {
        for (const float theta : {0.0f, 0.2f, 0.9f, 1.3f, 1.5f}) {
            const double alpha = static_cast<double>(roughness * roughness);
            // The sum over 600² cells has an error of 5e-4 for the narrowest lobe.
            EXPECT_NEAR(white_ggx_albedo(std::cos(theta), roughness),
                        ggx_albedo(static_cast<double>(theta), alpha), 1e-3)
                << roughness << " " << theta;
        }
    }
}

/// Radiance towards wo in a white uniform environment, by all lobes that are not smooth.
double reflected_and_transmitted(const Surface& s) {
    return over_sphere([&](const Vec3& wi) {
               const BsdfEval v = eval_bsdf(s, wi);
               return v.diffuse + v.glossy;
           })
        .x;
}

TEST(Bsdf, RoughMaterialsReturnAllLightThatTheyDoNotAbsorb) {
    for (const Named& n : rough_surfaces()) {
        EXPECT_LT(reflected_and_transmitted(n.surface), 1.002) << n.name;
        // The coated metal, of 0.8 at normal incidence, absorbs a fifth or more.
        EXPECT_GT(reflected_and_transmitted(n.surface), n.surface.clearcoat > 0 ? 0.77 : 0.985)
            << n.name;
    }
}

TEST(Bsdf, DielectricMixesDiffuseAndSpecularByFresnel) {
    // At normal incidence and for wi = wo, times cos = 1. Smooth, so that all albedos are
    // Fresnel's: (1 − 0.04)²·color/π over the mean of 1 − F, which is 0.9082 for an index of 1.5.
    Surface s = dielectric(0, 0);
    s.base_color = {0.5f, 0.2f, 0.1f};
    EXPECT_NEAR(eval_bsdf(s, {0, 0, 1}).diffuse.x, 0.96f * 0.96f / 0.9082f * 0.5f / pi, 5e-5f);
    // D = 1/(π α²) with α = ¼, masking 1, over 4; and 1 + 0.04 (1 − E)/E with E = 0.9158.
    s.roughness = 0.5f;
    const BsdfEval v = eval_bsdf(s, {0, 0, 1});
    EXPECT_NEAR(v.glossy.x, 0.04f * 16 / (4 * pi) * 1.00368f, 1e-5f);
    EXPECT_EQ(v.glossy.x, v.glossy.y);
}

TEST(Bsdf, MetalReflectsItsColourAndHasNoDiffuseLobe) {
    Surface s = metal(0, 0.5f);
    s.base_color = {0.9f, 0.6f, 0.3f};
    const BsdfEval v = eval_bsdf(s, {0, 0, 1});
    EXPECT_EQ(v.diffuse, Vec3(0));
    // Light that is scattered again has lost more of its blue: (1 − E)/E = 0.0919.
    EXPECT_NEAR(v.glossy.x / v.glossy.z, 3 * (1 + 0.9f * 0.0919f) / (1 + 0.3f * 0.0919f), 2e-3f);
}

TEST(Bsdf, SpecularExtensionScalesAndTintsTheDielectric) {
    Surface s = dielectric(0, 0.5f);
    s.features = feature_specular;
    s.specular = 0.5f;
    s.specular_color = {1, 0.5f, 0};
    const BsdfEval v = eval_bsdf(s, {0, 0, 1});
    // Multiple scattering adds less than 2e-3 of it.
    EXPECT_NEAR(v.glossy.x, 0.02f * 16 / (4 * pi), 5e-5f);
    EXPECT_NEAR(v.glossy.y, 0.01f * 16 / (4 * pi), 5e-5f);
    EXPECT_NEAR(v.glossy.z, 0, 1e-5f);
    // The diffuse lobe is below the reflectance of the brightest channel, for all channels.
    EXPECT_EQ(v.diffuse.x, v.diffuse.z);
    s.specular_color = Vec3(1);
    EXPECT_EQ(v.diffuse.x, eval_bsdf(s, {0, 0, 1}).diffuse.x);
}

/// The factor by which multiple scattering raises the lobe of a metal without film.
float raised(const Surface& s) {
    return 1 + s.base_color.x * (1 / white_ggx_albedo(s.wo.z, s.roughness) - 1);
}

TEST(Bsdf, IsReciprocalButForMultipleScattering) {
    std::mt19937 generator(3);
    std::uniform_real_distribution<float> uniform(0, 1);
    Surface gold = metal(0, 0.8f);
    gold.base_color = {0.7f, 0.4f, 0.2f};
    for (Surface s : {metal(0, 0.5f), gold}) {
        for (int i = 0; i < 200; ++i) {
            const Vec3 a = direction(1.5f * uniform(generator), 6 * uniform(generator));
            const Vec3 b = direction(1.5f * uniform(generator), 6 * uniform(generator));
            s.wo = a;
            const float forth = eval_bsdf(s, b).glossy.x / b.z / raised(s);
            s.wo = b;
            const float back = eval_bsdf(s, a).glossy.x / a.z / raised(s);
            EXPECT_NEAR(forth, back, 2e-4f * forth);
        }
    }
}

TEST(Bsdf, RoughGlassIsReciprocalUpToItsIndexSquared) {
    std::mt19937 generator(4);
    std::uniform_real_distribution<float> uniform(0, 1);
    int seen = 0;
    for (int i = 0; i < 500; ++i) {
        const Vec3 above = direction(0.6f * uniform(generator), 6 * uniform(generator));
        const Vec3 below = -direction(0.6f * uniform(generator), 6 * uniform(generator));
        Surface in = glass(0, 0.2f), out = glass(0, 0.2f, false);
        in.wo = above;
        out.wo = below;
        out.ns = out.ng = {0, 0, -1};
        const float forth = eval_bsdf(in, below).glossy.x / -below.z;
        const float back = eval_bsdf(out, above).glossy.x / above.z;
        if (forth > 1e-4f) ++seen;
        // What is lost and given back, towards each side by its own albedo, is up to 3 %.
        EXPECT_NEAR(forth, back * 1.5f * 1.5f, 0.03f * forth + 1e-6f);
    }
    EXPECT_GT(seen, 100);
}

TEST(Bsdf, SmoothLobesAreNotEvaluated) {
    EXPECT_EQ(eval_bsdf(metal(0.5f, 0), reflect(direction(0.5f, 0.4f), {0, 0, 1})).glossy, Vec3(0));
}

TEST(Bsdf, UnlitSurfacesReflectNothing) {
    Surface s = dielectric(0.3f, 0.5f);
    s.features = feature_unlit;
    EXPECT_EQ(eval_bsdf(s, {0, 0, 1}).diffuse, Vec3(0));
    sample_many(s, 1, [](const auto&, int count) { EXPECT_EQ(count, 0); });
}

TEST(Bsdf, NoSampleCrossesTheGeometricSurface) {
    std::mt19937 generator(5);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (int i = 0; i < 500; ++i) {
        Surface s = glass(1.2f, i % 2 ? 0.5f : 0, true);
        s.ns = direction(0.6f * uniform(generator), 6.28f * uniform(generator));
        if (dot(s.ns, s.wo) <= 0) continue;
        sample_many(s, 5, [&](const auto& rays, int count) {
            for (int k = 0; k < count; ++k) {
                const BsdfSample& ray = rays[static_cast<size_t>(k)];
                EXPECT_EQ(dot(ray.direction, s.ng) < 0, ray.refracted);
            }
        });
    }
}

TEST(Bsdf, MaxReflectanceIsZeroForChalkAndUnlitSurfacesAndOneForMetal) {
    Material chalk;
    chalk.metallic_factor = 0;
    chalk.specular_factor = 0;
    EXPECT_EQ(max_reflectance(chalk), 0);
    EXPECT_EQ(max_reflectance(Material{}), 1);
    Material unlit;
    unlit.unlit = true;
    EXPECT_EQ(max_reflectance(unlit), 0);
}

}  // namespace
}  // namespace sightline
