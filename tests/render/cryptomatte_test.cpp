#include "render/cryptomatte.h"
#include "support/pictures.h"

#include <bit>
#include <cmath>

namespace sightline {
namespace {

TEST(Cryptomatte, HashesNamesByMurmurHash3) {
    EXPECT_EQ(murmur3(""), 0u);
    EXPECT_EQ(murmur3("hello"), 0x248bfa47u);
    EXPECT_EQ(murmur3("hello, world"), 0x149bbb7fu);
    EXPECT_EQ(murmur3("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
    // From the sample images of the specification.
    EXPECT_EQ(cryptomatte_id("bunny"), 0x13851a76u);
    EXPECT_EQ(cryptomatte_id("default"), 0x42c9679fu);
}

TEST(Cryptomatte, NoIdIsZeroDenormalInfiniteOrNan) {
    int changed = 0;
    for (int i = 0; i < 10000; ++i) {
        const std::string name = std::to_string(i);
        EXPECT_TRUE(std::isnormal(std::bit_cast<float>(cryptomatte_id(name)))) << name;
        const uint32_t difference = cryptomatte_id(name) ^ murmur3(name);
        changed += difference != 0;
        EXPECT_TRUE(difference == 0 || difference == 1u << 23);
    }
    EXPECT_GT(changed, 20);  // 1 in 128
}

TEST(Cryptomatte, RanksByCoverageAndKeepsSix) {
    const auto ranks = rank({{7, 0.25f}, {3, 0.5f}, {7, 0.5f}});
    ASSERT_EQ(ranks.size(), 2u);
    EXPECT_EQ(ranks[0], Coverage(7, 0.75f));
    EXPECT_EQ(ranks[1], Coverage(3, 0.5f));
    std::vector<Coverage> many;
    for (uint32_t id = 1; id <= 9; ++id) many.push_back({id, static_cast<float>(id)});
    ASSERT_EQ(rank(many).size(), 6u);
    EXPECT_EQ(rank(many)[5], Coverage(4, 4.0f));
}

float sum_of_coverage(const Film& film, const std::string& kind, size_t pixel) {
    float sum = 0;
    for (const char* channel : {"00.G", "00.A", "01.G", "01.A", "02.G", "02.A"})
        sum += film.find(kind + channel)->values[pixel];
    return sum;
}

TEST(Cryptomatte, CoverageIsTheFractionOfThePixel) {
    Scene scene = rich_scene();
    // Glass counts whole, whereas alpha lets what lies behind it through.
    for (Material& m : scene.materials) m.transmission_factor = 0;
    RenderSettings settings = rich_settings(16);
    settings.background = Background::transparent;
    const Environment sky = uniform_environment({0.3f, 0.4f, 0.6f});
    const Film film = render_scene(scene, settings, &sky).film;
    const auto& alpha = film.find("A")->values;
    size_t whole = 0, partial = 0;
    for (size_t i = 0; i < alpha.size(); ++i) {
        EXPECT_NEAR(sum_of_coverage(film, "CryptoObject", i), alpha[i], 1e-5f) << i;
        EXPECT_NEAR(sum_of_coverage(film, "CryptoMaterial", i), alpha[i], 1e-5f) << i;
        whole += alpha[i] == 1;
        partial += alpha[i] > 0 && alpha[i] < 1;
    }
    EXPECT_GT(whole, 100u);
    EXPECT_GT(partial, 10u);
}

TEST(Cryptomatte, LayersBehindABlendedSurfaceShareThePixel) {
    Material film = matte({1, 0, 0});
    film.base_color_factor.w = 0.25f;
    film.alpha_mode = AlphaMode::blend;
    film.name = "film";
    Material wall = matte({1, 1, 1});
    wall.name = "wall";
    SceneBuilder builder;
    draw(builder, quad_mesh({-9, -9, -1}, {18, 0, 0}, {0, 18, 0}), wall);
    draw(builder, quad_mesh({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), film);
    RenderSettings settings =
        small_settings(look_at({0, 0, 4}, {0, 0, 0}, {0, 1, 0}, pi / 4), 1, 17, 17);
    settings.aovs = {"cryptomatte"};
    const Film picture = render_scene(builder.finish(), settings).film;
    const auto value = [&](const char* channel) {
        return picture.find(std::string("CryptoMaterial00.") + channel)->values[8 * 17 + 8];
    };
    EXPECT_EQ(std::bit_cast<uint32_t>(value("R")), cryptomatte_id("wall"));
    EXPECT_FLOAT_EQ(value("G"), 0.75f);
    EXPECT_EQ(std::bit_cast<uint32_t>(value("B")), cryptomatte_id("film"));
    EXPECT_FLOAT_EQ(value("A"), 0.25f);
}

TEST(LightGroups, SumToTheBeautyLayer) {
    Scene scene = rich_scene();
    scene.lights[0].name = "key.1";
    scene.lights.push_back(point_light({-3, 4, 3}, 20));
    scene.lights.push_back(point_light({-3, 4, 2}, 10));
    scene.lights[2].name = "key.1";  // the same group
    const Environment sky = uniform_environment({0.3f, 0.4f, 0.6f});
    for (const auto integrator : {Integrator::whitted, Integrator::appel}) {
        RenderSettings settings = rich_settings(8);
        settings.integrator = integrator;
        const Film film = render_scene(scene, settings, &sky).film;
        for (const char* color : {"R", "G", "B"}) {
            const auto& beauty = film.find(color)->values;
            std::vector<float> sum(beauty.size());
            for (const char* group : {"key_1", "unnamed", "environment", "emission"}) {
                const Channel* channel = film.find(std::string("light.") + group + "." + color);
                ASSERT_TRUE(channel) << group;
                float most = 0;
                for (size_t i = 0; i < sum.size(); ++i) {
                    sum[i] += channel->values[i];
                    most = std::max(most, channel->values[i]);
                }
                EXPECT_GT(most, 0) << group;
            }
            for (size_t i = 0; i < sum.size(); ++i)
                EXPECT_NEAR(sum[i], beauty[i], 1e-5f * std::max(1.0f, beauty[i]));
        }
    }
}

TEST(LightGroups, DoNotChangeThePicture) {
    RenderSettings settings = rich_settings(2);
    const Film with = render_scene(rich_scene(), settings).film;
    settings.aovs.clear();
    const Film without = render_scene(rich_scene(), settings).film;
    for (const Channel& channel : without.channels)
        EXPECT_TRUE(same_bits(channel, *with.find(channel.name))) << channel.name;
}

}  // namespace
}  // namespace sightline
