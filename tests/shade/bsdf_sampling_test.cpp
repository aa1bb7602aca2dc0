#include "support/surfaces.h"

#include <gtest/gtest.h>

namespace sightline {
namespace {

TEST(BsdfSampling, SamplesCarryTheirEvaluatedWeightAndPdf) {
    for (const Named& n : rough_surfaces()) {
        int rays_seen = 0;
        sample_many(n.surface, 500, [&](const auto& rays, int count) {
            for (int i = 0; i < count; ++i) {
                const BsdfSample& ray = rays[static_cast<size_t>(i)];
                const BsdfEval v = eval_bsdf(n.surface, ray.direction);
                ASSERT_GT(ray.pdf, 0);
                EXPECT_NEAR(v.pdf / ray.pdf, 1, 5e-3f) << n.name;
                EXPECT_NEAR((v.glossy / v.pdf).x, ray.weight.x, 5e-3f) << n.name;
                EXPECT_NEAR(ray.direction.length(), 1, 1e-5f);
                ++rays_seen;
            }
        });
        EXPECT_GT(rays_seen, 200) << n.name;
    }
}

TEST(BsdfSampling, PdfIntegratesToTheFractionOfSamplesThatAreNotLost) {
    // Visible-normal sampling may send a ray below the horizon, where it is dropped.
    for (const Named& n : rough_surfaces()) {
        const Vec3d share = over_sphere([&](const Vec3& wi) {
            const float pdf = eval_bsdf(n.surface, wi).pdf;
            return wi.z > 0 ? Vec3(pdf, 0, 0) : Vec3(0, pdf, 0);
        });
        double reflected = 0, refracted = 0;
        const int trials = 20000;
        sample_many(n.surface, trials, [&](const auto& rays, int count) {
            for (int i = 0; i < count; ++i) {
                (rays[static_cast<size_t>(i)].refracted ? refracted : reflected) += 1.0 / trials;
            }
        });
        EXPECT_NEAR(share.x, reflected, 0.015) << n.name;
        EXPECT_NEAR(share.y, refracted, 0.015) << n.name;
    }
}

TEST(BsdfSampling, MeanOfSampledWeightsIsTheIntegralOfTheLobe) {
    for (const Named& n : rough_surfaces()) {
        const Vec3d truth =
            over_sphere([&](const Vec3& wi) { return eval_bsdf(n.surface, wi).glossy; });
        double sum = 0;
        const int trials = 20000;
        sample_many(n.surface, trials, [&](const auto& rays, int count) {
            for (int i = 0; i < count; ++i) {
                sum += static_cast<double>(rays[static_cast<size_t>(i)].weight.x) / trials;
            }
        });
        EXPECT_NEAR(sum, truth.x, 0.01) << n.name;
    }
}

// Secondary rays and shadow rays lose the same at a pane.
TEST(BsdfSampling, ALayerTransmitsAsMuchAsItsSmoothLobe) {
    for (const float theta : {0.1f, 0.9f, 1.4f}) {
        Surface s = thin_glass(theta, 0);
        s.features |= feature_specular | feature_sheen | feature_clearcoat;
        s.base_color = {0.9f, 0.6f, 0.3f};
        s.metallic = 0.2f;
        s.transmission = 0.7f;
        s.specular = 0.8f;
        s.sheen_color = {0.2f, 0.1f, 0};
        s.sheen_roughness = 0.5f;
        s.clearcoat = 0.5f;
        std::array<BsdfSample, 2> rays;
        ASSERT_EQ(sample_bsdf(s, {0, 0}, {0, 0}, 0, rays), 2);
        EXPECT_TRUE(rays[1].unbent);
        expect_near(layer_transmittance(s).unbent, rays[1].weight);
        EXPECT_EQ(layer_transmittance(s).bent, Vec3(0));
        s.alpha = 0.25f;
        expect_near(layer_transmittance(s).unbent, Vec3(0.75f) + rays[1].weight * 0.25f);
    }
}

TEST(BsdfSampling, OnlyWhatBlursOrRefractsBendsLight) {
    EXPECT_TRUE(transmission_is_unbent(thin_glass(0.5f, 0)));
    EXPECT_FALSE(transmission_is_unbent(thin_glass(0.5f, 0.5f)));
    EXPECT_FALSE(transmission_is_unbent(glass(0.5f, 0)));
    Surface equal_media = glass(0.5f, 0.5f);
    equal_media.eta = 1;
    EXPECT_TRUE(transmission_is_unbent(equal_media));
}

// alpha · clamp(2 ior − 2, 0, 1), as for the reflection from 1.5 on and none at all at 1.
TEST(BsdfSampling, AThinWallBlursByItsRefractiveIndex) {
    const auto widest = [](float ior) {
        Surface s = thin_glass(0, 0.7f);
        s.ior = s.eta = ior;
        float cosine = 1;
        sample_many(s, 2000, [&](const auto& rays, int count) {
            for (int i = 0; i < count; ++i)
                if (rays[static_cast<size_t>(i)].refracted)
                    cosine = std::min(cosine, -rays[static_cast<size_t>(i)].direction.z);
        });
        return cosine;
    };
    EXPECT_EQ(widest(1), 1);
    EXPECT_GT(widest(1.1f), widest(1.25f));
    EXPECT_GT(widest(1.25f), widest(1.5f));
    EXPECT_NEAR(widest(1.5f), widest(1.9f), 1e-5f);
    Surface s = thin_glass(0.4f, 0.7f);
    s.ior = s.eta = 1;
    EXPECT_FALSE(is_rough(s) && eval_bsdf(s, {0, 0, -1}).pdf > 0);
}

TEST(BsdfSampling, ChoosingBetweenASmoothCoatAndARoughBaseIsUnbiased) {
    const Surface s = coated(0.9f, 0.5f, 0);
    const float coat = fresnel_dielectric(std::cos(0.9f), 1.5f);
    double smooth = 0, rough = 0;
    const int n = 40000;
    sample_many(s, n, [&](const auto& rays, int count) {
        if (count == 0) return;
        (rays[0].pdf == 0 ? smooth : rough) += static_cast<double>(rays[0].weight.x) / n;
    });
    EXPECT_NEAR(smooth, static_cast<double>(coat), 5e-3);
    const Vec3d base = over_sphere([&](const Vec3& wi) { return eval_bsdf(s, wi).glossy; });
    EXPECT_NEAR(rough, base.x, 0.01);
}

}  // namespace
}  // namespace sightline
