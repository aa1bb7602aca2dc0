#include "support/pictures.h"

#include <functional>
#include <random>

namespace sightline {
namespace {

/// A mesh that shows a texture of black and white texels as they are, by mipmaps.
Scene textured_scene(Mesh mesh, int size, const std::function<bool(int, int)>& is_white) {
    Material card = matte({1, 1, 1});
    card.unlit = true;
    card.base_color_texture.texture = 0;
    Scene scene = scene_of(std::move(mesh), card);
    Texture texture;
    texture.image = 0;
    scene.textures.push_back(texture);
    Image image;
    image.width = image.height = size;
    image.channels = 1;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) image.bytes.push_back(is_white(x, y) ? 255 : 0);
    scene.images.push_back(std::move(image));
    return scene;
}

/// White noise of 128 × 128 texels, in a view of 64 × 64 pixels that it fills.
Scene noise_scene() {
    std::mt19937 generator(3);
    return textured_scene(quad_mesh({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), 128,
                          [&](int, int) { return generator() % 2 == 0; });
}

RenderSettings noise_settings(int samples) {
    Camera camera = look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 1);
    camera.orthographic = true;
    return small_settings(camera, samples, 64, 64);
}

/// Standard deviation of the red channel.
double contrast(const Film& film) {
    double sum = 0, squares = 0;
    const std::vector<float>& red = film.find("R")->values;
    for (const float r : red) {
        sum += static_cast<double>(r);
        squares += static_cast<double>(r) * static_cast<double>(r);
    }
    const auto n = static_cast<double>(red.size());
    return std::sqrt(squares / n - sum * sum / (n * n));
}

// Two texels a pixel along each axis. The bilinear texture averaged over the pixel has the weights
// 1/16, 7/16, 7/16, 1/16 along an axis, whose squares add up to 25/64; noise of the deviation 1/2
// keeps 25/128. The deviation of 4096 pixels varies by 1.1 %.
constexpr double sharp_contrast = 25.0 / 128;

TEST(TextureFilter, IsAsSharpAsTheSamplesAllow) {
    EXPECT_NEAR(contrast(render_scene(noise_scene(), noise_settings(64)).film), sharp_contrast,
                0.03 * sharp_contrast);
}

TEST(TextureFilter, OfOneSampleCoversThePixel) {
    // The mean of four texels; a texel alone has the deviation 1/2.
    EXPECT_NEAR(contrast(render_scene(noise_scene(), noise_settings(1)).film), 0.25, 0.03 * 0.25);
}

TEST(TextureFilter, WithATargetErrorFollowsTheFirstRound) {
    RenderSettings settings = noise_settings(1);
    settings.error = 1e3f;
    const auto one_a_pixel = render_scene(noise_scene(), settings);
    EXPECT_LT(one_a_pixel.counters.samples, 2u * 64 * 64);  // tiles also sample the ring around
    EXPECT_NEAR(contrast(one_a_pixel.film), 0.25, 0.03 * 0.25);
    settings.aperture = 1e-4f;  // which is noise
    settings.error = 1e-4f;
    settings.max_samples = 16;
    const auto round = render_scene(noise_scene(), settings);
    EXPECT_EQ(round.counters.samples, 16u * 64 * 64);
    EXPECT_NEAR(contrast(round.film), sharp_contrast, 0.03 * sharp_contrast);
}

/// A plane to the horizon, 256 texels over 10 units, half a unit below the camera.
Scene floor_scene(const std::function<bool(int, int)>& is_white) {
    Mesh mesh = quad_mesh({-80, 0, 0}, {160, 0, 0}, {0, 0, -160});
    for (Vec2& uv : mesh.texcoords[0]) uv *= 16;
    return textured_scene(std::move(mesh), 256, is_white);
}

TEST(TextureFilter, IsSharpAcrossAGrazingViewAndSmoothAlongItAtOneSample) {
    const Camera camera = look_at({0, 0.5f, 0}, {0, 0.5f, -1}, {0, 1, 0}, 0.6f);
    const Scene along = floor_scene([](int x, int) { return x / 4 % 2 == 0; });
    const Scene across = floor_scene([](int, int y) { return y / 4 % 2 == 0; });
    for (const Scene* scene : {&along, &across}) {
        const Film one = render_scene(*scene, small_settings(camera, 1, 96, 96)).film;
        const Film many = render_scene(*scene, small_settings(camera, 256, 96, 96)).film;
        // Where a pixel covers 5 to 12 times as much along the view as across.
        double squares = 0, sum = 0, contrast = 0;
        int count = 0;
        for (int y = 62; y < 79; ++y) {
            for (int x = 0; x < 96; ++x, ++count) {
                const auto truth = static_cast<double>(beauty_at(many, x, y).x);
                const auto error = static_cast<double>(beauty_at(one, x, y).x) - truth;
                squares += error * error;
                sum += truth;
                contrast += truth * truth;
            }
        }
        if (scene == &along) {
            EXPECT_GT(std::sqrt(contrast / count - sum * sum / count / count), 0.4);
        }
        // A tenth of the stripes' own deviation, 1/2.
        EXPECT_LT(std::sqrt(squares / count), 0.05);
    }
}

}  // namespace
}  // namespace sightline
