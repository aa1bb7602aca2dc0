// The smallest program that renders scenes/whitted.gltf: one scalar loop over its three surfaces,
// known at compile time. It is the baseline for the cost of a general renderer. minimal_whitted
// [SAMPLES [THREADS [PICTURE.ppm]]] prints the seconds of the loop.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <thread>
#include <vector>

namespace {

struct Vec {
    float x, y, z;
};
Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
Vec operator*(Vec a, float s) { return {a.x * s, a.y * s, a.z * s}; }
float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
Vec normalize(Vec a) { return a * (1 / std::sqrt(dot(a, a))); }

constexpr int width = 640, height = 480, max_depth = 8;
constexpr float infinity = 1e30f, radius = 1.15f, glass_ior = 1.5f, smallest_weight = 0.5f / 255;
constexpr Vec sky{0.2f, 0.45f, 0.8f}, yellow{0.956f, 0.680f, 0.007f}, red{0.680f, 0.007f, 0.005f};
constexpr Vec eye{0.25f, 2.3f, 8}, at{0.25f, 1.85f, 0};
constexpr Vec light{-5, 14, 6};
constexpr float candela = 700;

enum class Surface { none, floor, glass, mirror };
constexpr Vec centre_of(Surface s) {
    return s == Surface::glass ? Vec{-0.35f, 2.35f, 1.9f} : Vec{1.35f, 1.55f, -0.6f};
}

void intersect_sphere(Surface sphere, Vec o, Vec d, float& t, Surface& nearest) {
    const Vec c = centre_of(sphere) - o;
    const float b = dot(c, d);
    const Vec aside = c - d * b;
    const float square = radius * radius - dot(aside, aside);
    if (square < 0) return;
    const float half = std::sqrt(square);
    const float root = b - half > 1e-3f ? b - half : b + half;
    if (root > 1e-3f && root < t) {
        t = root;
        nearest = sphere;
    }
}

Surface closest(Vec o, Vec d, float& t) {
    Surface nearest = Surface::none;
    const float down = -o.y / d.y;
    if (down > 1e-3f && down < t) {
        const Vec p = o + d * down;
        if (p.x > -7 && p.x < 5 && p.z > -18 && p.z < 6) {
            t = down;
            nearest = Surface::floor;
        }
    }
    intersect_sphere(Surface::glass, o, d, t, nearest);
    intersect_sphere(Surface::mirror, o, d, t, nearest);
    return nearest;
}

float fresnel(float cos_i, float eta) {
    const float sin2 = (1 - cos_i * cos_i) / (eta * eta);
    if (sin2 >= 1) return 1;
    const float cos_t = std::sqrt(1 - sin2);
    const float s = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    const float p = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    return 0.5f * (s * s + p * p);
}

/// The fraction of the light that the spheres transmit towards p.
float light_let_through(Vec p, Vec d, float distance) {
    Surface surface = Surface::none;
    float t = distance;
    intersect_sphere(Surface::mirror, p, d, t, surface);
    if (surface != Surface::none) return 0;
    intersect_sphere(Surface::glass, p, d, t, surface);
    if (surface == Surface::none) return 1;
    const Vec n = (p + d * t - centre_of(Surface::glass)) * (1 / radius);
    const float through = 1 - fresnel(std::fabs(dot(n, d)), glass_ior);
    return through * through;
}

Vec shade_floor(Vec p) {
    const int cell = int(std::floor(p.x + 7)) + int(std::floor(p.z + 18));
    const Vec to_light = light - p;
    const float distance2 = dot(to_light, to_light), distance = std::sqrt(distance2);
    const Vec d = to_light * (1 / distance);
    const float arriving = light_let_through(p, d, distance) * candela * d.y / distance2;
    return (cell % 2 ? red : yellow) * (arriving / 3.14159265f);
}

Vec trace(Vec o, Vec d, float weight, int depth) {
    float t = infinity;
    const Surface surface = closest(o, d, t);
    if (surface == Surface::none) return sky;
    const Vec p = o + d * t;
    if (surface == Surface::floor) return shade_floor(p);
    if (depth == max_depth) return {0, 0, 0};
    Vec n = (p - centre_of(surface)) * (1 / radius);
    const Vec mirrored = d - n * (2 * dot(n, d));
    if (surface == Surface::mirror) return trace(p, mirrored, weight * 0.85f, depth + 1) * 0.85f;
    const bool inside = dot(n, d) > 0;
    if (inside) n = n * -1.0f;
    const float eta = inside ? 1 / glass_ior : glass_ior, cos_i = -dot(n, d);
    const float reflected = fresnel(cos_i, eta), refracted = 1 - reflected;
    Vec sum{0, 0, 0};
    if (weight * reflected > smallest_weight)
        sum = trace(p, mirrored, weight * reflected, depth + 1) * reflected;
    if (weight * refracted > smallest_weight) {
        const float cos_t = std::sqrt(1 - (1 - cos_i * cos_i) / (eta * eta));
        const Vec through = normalize(d * (1 / eta) + n * (cos_i / eta - cos_t));
        sum = sum + trace(p, through, weight * refracted, depth + 1) * refracted;
    }
    return sum;
}

float random(uint32_t& state) {
    state = state * 747796405u + 2891336453u;
    const uint32_t word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737u;
    return float(((word >> 22) ^ word) >> 8) * 0x1p-24f;
}

void draw_row(int y, int samples, Vec* row) {
    const float tangent = std::tan(0.5f * 38 * 3.14159265f / 180);
    const Vec back = normalize(eye - at), right{1, 0, 0}, up{0, back.z, -back.y};
    for (int x = 0; x < width; ++x) {
        uint32_t state = uint32_t(y * width + x);
        Vec sum{0, 0, 0};
        for (int s = 0; s < samples; ++s) {
            const float px = (2 * (float(x) + random(state)) - width) / height * tangent;
            const float py = (height - 2 * (float(y) + random(state))) / height * tangent;
            sum = sum + trace(eye, normalize(right * px + up * py - back), 1, 0);
        }
        row[x] = sum * (1 / float(samples));
    }
}

void write_ppm(const char* path, const std::vector<Vec>& picture) {
    std::ofstream file(path, std::ios::binary);
    file << "P6\n" << width << ' ' << height << "\n255\n";
    const auto byte = [](float c) {
        return char(std::lround(255 * std::pow(std::min(c, 1.0f), 1 / 2.2f)));
    };
    for (const Vec& c : picture) file << byte(c.x) << byte(c.y) << byte(c.z);
}

}  // namespace

int main(int argc, char** argv) {
    const int samples = argc > 1 ? std::atoi(argv[1]) : 4;
    const int threads = argc > 2 ? std::atoi(argv[2]) : 1;
    std::vector<Vec> picture(width * height);
    const auto start = std::chrono::steady_clock::now();
    std::vector<std::jthread> workers;
    for (int i = 0; i < threads; ++i)
        workers.emplace_back([&, i] {
            for (int y = i; y < height; y += threads)
                draw_row(y, samples, &picture[size_t(y) * width]);
        });
    workers.clear();
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::printf("%.6f\n", seconds.count());
    if (argc > 3) write_ppm(argv[3], picture);
}
