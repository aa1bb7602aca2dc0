#include "shade/bsdf.h"

#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace sightline {
namespace {

Vec3 direction(float theta, float phi) {
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

/// A surface in the xy plane seen from `theta` off its normal +z, of white metal.
Surface metal(float theta, float roughness) {
    Surface s;
    s.wo = direction(theta, 0.4f);
    s.ng = s.ns = s.coat_normal = {0, 0, 1};
    s.tangent = {1, 0, 0};
    s.metallic = 1;
    s.roughness = roughness;
    return s;
}

Surface dielectric(float theta, float roughness) {
    Surface s = metal(theta, roughness);
    s.metallic = 0;
    return s;
}

Surface thin_glass(float theta, float roughness) {
    Surface s = dielectric(theta, roughness);
    s.features = feature_transmission;
    s.transmission = 1;
    return s;
}

Surface glass(float theta, float roughness, bool entering = true) {
    Surface s = thin_glass(theta, roughness);
    s.features |= feature_volume;
    s.front = entering;
    s.eta = entering ? 1.5f : 1 / 1.5f;
    return s;
}

Surface coated(float theta, float roughness, float coat_roughness) {
    Surface s = metal(theta, roughness);
    s.features = feature_clearcoat;
    s.clearcoat = 1;
    s.clearcoat_roughness = coat_roughness;
    s.base_color = {0.8f, 0.3f, 0.1f};
    return s;
}

Surface brushed(float theta) {
    Surface s = metal(theta, 0.4f);
    s.features = feature_anisotropy;
    s.anisotropy = 0.7f;
    return s;
}

struct Named {
    const char* name;
    Surface surface;
};

/// Every kind of rough lobe, seen from several sides.
std::vector<Named> rough_surfaces() {
    std::vector<Named> all;
    for (const float theta : {0.1f, 0.8f, 1.3f}) {
        all.push_back({"metal", metal(theta, 0.5f)});
        all.push_back({"rough metal", metal(theta, 1)});
        all.push_back({"dielectric", dielectric(theta, 0.4f)});
        all.push_back({"brushed", brushed(theta)});
        all.push_back({"thin glass", thin_glass(theta, 0.5f)});
        all.push_back({"glass", glass(theta, 0.5f)});
        all.push_back({"glass from inside", glass(theta, 0.5f, false)});
        all.push_back({"coated", coated(theta, 0.6f, 0.3f)});
    }
    return all;
}

/// Integral over the whole sphere, by the midpoint rule in θ and φ.
Vec3d over_sphere(const std::function<Vec3(const Vec3&)>& f) {
    constexpr int rows = 240;
    const float step = pi / rows;
    Vec3d sum(0);
    for (int i = 0; i < rows; ++i) {
        const float theta = step * (static_cast<float>(i) + 0.5f);
        for (int j = 0; j < 2 * rows; ++j) {
            const Vec3 d = direction(theta, step * (static_cast<float>(j) + 0.5f));
            sum += Vec3d(f(d) * (std::sin(theta) * step * step));
        }
    }
    return sum;
}

/// Calls `visit(rays, count)` for `n` random choices.
template <class Visit>
void sample_many(const Surface& s, int n, const Visit& visit) {
    std::mt19937 generator(7);
    std::uniform_real_distribution<float> uniform(0, 1);
    const auto u = [&] { return std::min(uniform(generator), 0.99999994f); };
    std::array<SecondaryRay, 2> rays;
    for (int i = 0; i < n; ++i) {
        const Vec2 u1(u(), u()), u2(u(), u());
        const int count = sample_secondary(s, u1, u2, u(), rays);
        visit(rays, count);
    }
}

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

TEST(Bsdf, GlassSaysWhenAVolumeIsEnteredAndLeft) {
    for (const bool entering : {true, false}) {
        sample_many(glass(0.3f, 0, entering), 1, [&](const auto& rays, int count) {
            ASSERT_EQ(count, 2);
            EXPECT_TRUE(rays[1].refracted);
            EXPECT_EQ(rays[1].enters_volume, entering);
            EXPECT_EQ(rays[1].leaves_volume, !entering);
        });
    }
}

TEST(Bsdf, ThinGlassLetsLightStraightThrough) {
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

TEST(Bsdf, RoughMetalLosesWhatSingleScatteringLosesInAWhiteFurnace) {
    for (const float roughness : {0.5f, 0.8f, 1.0f}) {
        for (const float theta : {0.2f, 0.9f, 1.3f}) {
            double sum = 0;
            const int n = 40000;
            sample_many(metal(theta, roughness), n, [&](const auto& rays, int count) {
                if (count) sum += static_cast<double>(rays[0].weight.x) / n;
            });
            const double alpha = static_cast<double>(roughness * roughness);
            EXPECT_NEAR(sum, ggx_albedo(static_cast<double>(theta), alpha), 0.01)
                << roughness << " " << theta;
        }
    }
}

/// What of a white uniform surround leaves towards wo by all lobes that are not mirrors.
double reflected_and_transmitted(const Surface& s) {
    return over_sphere([&](const Vec3& wi) {
               const BsdfValue v = evaluate_bsdf(s, wi);
               return v.diffuse + v.glossy;
           })
        .x;
}

TEST(Bsdf, GlossyMaterialsNeverReflectMoreThanArrives) {
    for (const Named& n : rough_surfaces()) {
        if (n.surface.metallic < 1 && n.surface.transmission < 1) continue;
        EXPECT_LT(reflected_and_transmitted(n.surface), 1.001) << n.name;
        EXPECT_GT(reflected_and_transmitted(n.surface), 0.3) << n.name;
    }
}

TEST(Bsdf, DiffuseMaterialsStayWithinWhatGltfsMixGains) {
    // Appendix B takes Fresnel's split at the half vector for both layers, which is reciprocal but
    // gains energy at grazing views; with exact terms never more than a tenth.
    for (const float theta : {0.1f, 0.8f, 1.3f}) {
        Surface plain = dielectric(theta, 0.4f), sheen = plain, leaf = plain;
        sheen.features = feature_sheen;
        sheen.sheen_color = Vec3(1);
        sheen.sheen_roughness = 0.5f;
        leaf.features = feature_diffuse_transmission;
        leaf.diffuse_transmission = 0.6f;
        EXPECT_GT(reflected_and_transmitted(plain), 0.9);
        EXPECT_LT(reflected_and_transmitted(plain), theta < 1 ? 1.01 : 1.1);
        EXPECT_LT(reflected_and_transmitted(sheen), 1.06);
        EXPECT_GT(reflected_and_transmitted(sheen), 0.9);
        EXPECT_NEAR(reflected_and_transmitted(leaf), reflected_and_transmitted(plain), 2e-3);
    }
}

TEST(Bsdf, DielectricIsFresnelsMixOfDiffuseAndSpecular) {
    // At normal incidence and for wi = wo: (1 − 0.04)·albedo/π, times cos = 1.
    Surface s = dielectric(0, 0.5f);
    s.base_color = {0.5f, 0.2f, 0.1f};
    const BsdfValue v = evaluate_bsdf(s, {0, 0, 1});
    EXPECT_NEAR(v.diffuse.x, 0.96f * 0.5f / pi, 1e-6f);
    // D = 1/(π α²) with α = ¼, masking 1, over 4.
    EXPECT_NEAR(v.glossy.x, 0.04f * 16 / (4 * pi), 1e-5f);
    EXPECT_EQ(v.glossy.x, v.glossy.y);
}

TEST(Bsdf, MetalHasNoDiffuseAndItsOwnColour) {
    Surface s = metal(0, 0.5f);
    s.base_color = {0.9f, 0.6f, 0.3f};
    const BsdfValue v = evaluate_bsdf(s, {0, 0, 1});
    EXPECT_EQ(v.diffuse, Vec3(0));
    EXPECT_NEAR(v.glossy.x / v.glossy.z, 3, 1e-5f);
}

TEST(Bsdf, SpecularExtensionScalesAndTintsTheDielectric) {
    Surface s = dielectric(0, 0.5f);
    s.features = feature_specular;
    s.specular = 0.5f;
    s.specular_color = {1, 0.5f, 0};
    const BsdfValue v = evaluate_bsdf(s, {0, 0, 1});
    EXPECT_NEAR(v.glossy.x, 0.02f * 16 / (4 * pi), 1e-5f);
    EXPECT_NEAR(v.glossy.y, 0.01f * 16 / (4 * pi), 1e-5f);
    EXPECT_NEAR(v.glossy.z, 0, 1e-5f);
    EXPECT_NEAR(v.diffuse.x, 0.98f / pi, 1e-5f);  // less the largest component
}

TEST(Bsdf, IsReciprocal) {
    std::mt19937 generator(3);
    std::uniform_real_distribution<float> uniform(0, 1);
    Surface mixed = dielectric(0, 0.6f);
    mixed.metallic = 0.5f;
    mixed.base_color = {0.7f, 0.4f, 0.2f};
    for (Surface s : {metal(0, 0.5f), dielectric(0, 0.3f), brushed(0), mixed}) {
        for (int i = 0; i < 200; ++i) {
            const Vec3 a = direction(1.5f * uniform(generator), 6 * uniform(generator));
            const Vec3 b = direction(1.5f * uniform(generator), 6 * uniform(generator));
            s.wo = a;
            const BsdfValue forth = evaluate_bsdf(s, b);
            s.wo = b;
            const BsdfValue back = evaluate_bsdf(s, a);
            const float f = (forth.diffuse + forth.glossy).x / b.z;
            EXPECT_NEAR(f, (back.diffuse + back.glossy).x / a.z, 2e-4f * f);
        }
    }
}

TEST(Bsdf, RoughGlassIsReciprocalUpToTheSquareOfItsIndex) {
    std::mt19937 generator(4);
    std::uniform_real_distribution<float> uniform(0, 1);
    int seen = 0;
    for (int i = 0; i < 500; ++i) {
        const Vec3 above = direction(1.5f * uniform(generator), 6 * uniform(generator));
        const Vec3 below = -direction(1.5f * uniform(generator), 6 * uniform(generator));
        Surface in = glass(0, 0.7f), out = glass(0, 0.7f, false);
        in.wo = above;
        out.wo = below;
        out.ns = out.ng = {0, 0, -1};
        const float forth = evaluate_bsdf(in, below).glossy.x / -below.z;
        const float back = evaluate_bsdf(out, above).glossy.x / above.z;
        if (forth > 1e-4f) ++seen;
        EXPECT_NEAR(forth, back * 1.5f * 1.5f, 1e-3f * forth + 1e-6f);
    }
    EXPECT_GT(seen, 100);
}

TEST(Bsdf, SampledRaysCarryTheirEvaluatedWeightAndDensity) {
    for (const Named& n : rough_surfaces()) {
        int rays_seen = 0;
        sample_many(n.surface, 500, [&](const auto& rays, int count) {
            for (int i = 0; i < count; ++i) {
                const SecondaryRay& ray = rays[static_cast<size_t>(i)];
                const BsdfValue v = evaluate_bsdf(n.surface, ray.direction);
                ASSERT_GT(ray.pdf, 0);
                EXPECT_NEAR(v.glossy_pdf / ray.pdf, 1, 5e-3f) << n.name;
                EXPECT_NEAR((v.glossy / v.glossy_pdf).x, ray.weight.x, 5e-3f) << n.name;
                EXPECT_NEAR(ray.direction.length(), 1, 1e-5f);
                ++rays_seen;
            }
        });
        EXPECT_GT(rays_seen, 200) << n.name;
    }
}

TEST(Bsdf, DensityIntegratesToTheShareOfRaysThatLeave) {
    // Visible-normal sampling may send a ray below the horizon, where it is dropped.
    for (const Named& n : rough_surfaces()) {
        const Vec3d share = over_sphere([&](const Vec3& wi) {
            const float pdf = evaluate_bsdf(n.surface, wi).glossy_pdf;
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

TEST(Bsdf, MeanOfSampledWeightsIsTheIntegralOfTheLobe) {
    for (const Named& n : rough_surfaces()) {
        const Vec3d truth =
            over_sphere([&](const Vec3& wi) { return evaluate_bsdf(n.surface, wi).glossy; });
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

TEST(Bsdf, SmoothCoatOverRoughBaseIsChosenAtRandomWithoutBias) {
    const Surface s = coated(0.9f, 0.5f, 0);
    const float coat = fresnel_dielectric(std::cos(0.9f), 1.5f);
    double smooth = 0, rough = 0;
    const int n = 40000;
    sample_many(s, n, [&](const auto& rays, int count) {
        if (count == 0) return;
        (rays[0].pdf == 0 ? smooth : rough) += static_cast<double>(rays[0].weight.x) / n;
    });
    EXPECT_NEAR(smooth, static_cast<double>(coat), 5e-3);
    const Vec3d base = over_sphere([&](const Vec3& wi) { return evaluate_bsdf(s, wi).glossy; });
    EXPECT_NEAR(rough, base.x, 0.01);
}

TEST(Bsdf, SmoothLobesAreNotEvaluated) {
    EXPECT_EQ(evaluate_bsdf(metal(0.5f, 0), reflect(direction(0.5f, 0.4f), {0, 0, 1})).glossy,
              Vec3(0));
}

TEST(Bsdf, UnlitSurfacesNeitherReflectNorSendRays) {
    Surface s = dielectric(0.3f, 0.5f);
    s.features = feature_unlit;
    EXPECT_EQ(evaluate_bsdf(s, {0, 0, 1}).diffuse, Vec3(0));
    sample_many(s, 1, [](const auto&, int count) { EXPECT_EQ(count, 0); });
}

TEST(Bsdf, NoRayLeavesThroughTheGeometricSurface) {
    std::mt19937 generator(5);
    std::uniform_real_distribution<float> uniform(0, 1);
    for (int i = 0; i < 500; ++i) {
        Surface s = glass(1.2f, i % 2 ? 0.5f : 0, true);
        s.ns = direction(0.6f * uniform(generator), 6.28f * uniform(generator));
        if (dot(s.ns, s.wo) <= 0) continue;
        sample_many(s, 5, [&](const auto& rays, int count) {
            for (int k = 0; k < count; ++k) {
                const SecondaryRay& ray = rays[static_cast<size_t>(k)];
                EXPECT_EQ(dot(ray.direction, s.ng) < 0, ray.refracted);
            }
        });
    }
}

TEST(Bsdf, MaxReflectanceBoundsEveryWeight) {
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
