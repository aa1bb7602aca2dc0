#include "intersect/ray_file.h"

#include "core/binary_file.h"
#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "scene/geometry_hash.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace sightline {
namespace {

constexpr std::string_view magics[] = {"SLRAYS1\n", "SLRAYS2\n"};  // by version

/// Bytes of the header and of a ray in each version.
constexpr size_t header_bytes[] = {16, 64}, ray_bytes[] = {36, 48};

/// Reads numbers, in the byte order of x86 and ARM: little-endian.
struct Reader {
    const std::byte* at;

    template <class T>
    T next() {
        T value;
        std::memcpy(static_cast<void*>(&value), at, sizeof value);
        at += sizeof value;
        return value;
    }
};

/// The version of the format, counted from 0. Throws Error.
size_t version_of(const std::string& path, std::span<const std::byte> file) {
    const auto begins_with = [&](std::string_view text) {
        return file.size() >= text.size() &&
               std::memcmp(file.data(), text.data(), text.size()) == 0;
    };
    for (size_t version = 0; version < std::size(magics); ++version) {
        if (!begins_with(magics[version])) continue;
        if (file.size() < header_bytes[version])
            throw Error(path + ": truncated within its header");
        return version;
    }
    throw Error(begins_with("SLRAYS")
                    ? path + ": a ray file of another version; this program reads 1 and 2"
                    : path + ": not a ray file (--record-rays)");
}

RecordedRay read_ray(Reader& reader, size_t version) {
    RecordedRay ray;
    ray.ray = reader.next<Ray>();
    ray.kind = static_cast<RayKind>(reader.next<uint32_t>());
    if (version > 0) {
        ray.source.instance = reader.next<uint32_t>();
        ray.source.geometry = reader.next<uint32_t>();
        ray.source.primitive = reader.next<uint32_t>();
    }
    return ray;
}

}  // namespace

uint64_t hash_rays(std::span<const RecordedRay> rays) {
    uint64_t hash = 0;
    for (const RecordedRay& r : rays) {
        hash = hash_bytes(std::as_bytes(std::span(&r.ray, 1)), hash);
        hash = hash_bytes(std::as_bytes(std::span(&r.kind, 1)), hash);
    }
    return hash;
}

void write_rays(const std::string& path, std::span<const RecordedRay> rays, const Scene& scene) {
    const uint64_t hash = hash_geometry(scene);
    write_binary_file(path, "the rays", [&](std::ostream& file) {
        file << magics[1];
        put(file, uint64_t{rays.size()});
        put(file, hash);
        put(file, hash_rays(rays));
        put(file, scene.frame.origin);
        put(file, scene.frame.scale);
        for (const RecordedRay& r : rays) {
            put(file, r.ray);
            put(file, r.kind);
            put(file, r.source);
        }
    });
}

RayFile read_rays(const std::string& path) {
    const auto bytes = read_file(path, uint64_t{1} << 36);
    const size_t version = version_of(path, bytes);
    Reader reader{bytes.data() + magics[version].size()};
    const auto count = reader.next<uint64_t>();
    const size_t size = bytes.size() - header_bytes[version];
    const uint64_t held = size / ray_bytes[version];
    if (count != held || size % ray_bytes[version] != 0)
        throw Error(fmt::format("{}: the header declares {} rays, the file holds {}: truncated?",
                                path, count, held));
    RayFile file;
    if (version > 0) {
        file.geometry_hash = reader.next<uint64_t>();
        file.hash = reader.next<uint64_t>();
        file.frame.origin = reader.next<Vec3d>();
        file.frame.scale = reader.next<double>();
    }
    file.rays.reserve(count);
    for (size_t i = 0; i < count; ++i) {
        file.rays.push_back(read_ray(reader, version));
        const auto kind = static_cast<uint32_t>(file.rays.back().kind);
        if (kind >= ray_kinds)
            throw Error(fmt::format("{}: ray {} is of the unknown kind {}", path, i, kind));
    }
    if (version > 0 && file.hash != hash_rays(file.rays))
        throw Error(path + ": the rays are not those that its header was written for: damaged?");
    file.hash = hash_rays(file.rays);
    return file;
}

namespace {

/// The whole word as a number. Throws std::invalid_argument.
template <class Convert>
auto number_of(const std::string& word, const Convert& convert) {
    char* end = nullptr;
    const auto value = convert(word.c_str(), &end);
    if (word.empty() || *end != '\0') throw std::invalid_argument(word);
    return value;
}

std::vector<std::string> split_at_commas(const std::string& text) {
    std::vector<std::string> words(1);
    for (const char c : text) {
        if (c == ',')
            words.emplace_back();
        else
            words.back() += c;
    }
    return words;
}

/// Of 8, 9 or 12 words. Throws std::invalid_argument.
RecordedRay ray_of(std::span<const std::string> words) {
    std::array<float, 8> n{};
    for (size_t i = 0; i < n.size(); ++i) n[i] = number_of(words[i], std::strtof);
    RecordedRay ray{{{n[0], n[1], n[2]}, n[6], {n[3], n[4], n[5]}, n[7]}, RayKind::camera};
    if (words.size() > 8) {
        const auto kind = std::ranges::find(ray_kind_names, words[8]);
        if (kind == std::end(ray_kind_names)) throw std::invalid_argument(words[8]);
        ray.kind = static_cast<RayKind>(kind - std::begin(ray_kind_names));
    }
    if (words.size() == 12) {
        const auto id = [&](size_t i) {
            return static_cast<uint32_t>(number_of(
                words[i], [](const char* at, char** end) { return std::strtoul(at, end, 10); }));
        };
        ray.source = {id(9), id(10), id(11)};
    }
    return ray;
}

}  // namespace

RecordedRay parse_ray(const std::string& text) try {
    const std::vector<std::string> words = split_at_commas(text);
    if (words.size() != 8 && words.size() != 9 && words.size() != 12)
        throw std::invalid_argument(text);
    return ray_of(words);
} catch (const std::invalid_argument&) {
    throw std::invalid_argument(
        fmt::format("'{}' is not a ray ox,oy,oz,dx,dy,dz,tnear,tfar, perhaps with its kind and "
                    "the instance, geometry and primitive that it leaves",
                    text));
}

std::string ray_literal(const RecordedRay& recorded) {
    std::string text = ray_literal(recorded.ray);
    const SurfaceId& s = recorded.source;
    if (recorded.kind != RayKind::camera || s != SurfaceId())
        text += fmt::format(",{}", ray_kind_names[static_cast<size_t>(recorded.kind)]);
    if (s != SurfaceId()) text += fmt::format(",{},{},{}", s.instance, s.geometry, s.primitive);
    return text;
}

std::string ray_literal(const Ray& ray) {
    const Vec3 &o = ray.origin, &d = ray.direction;
    std::string text;
    for (const float value : {o.x, o.y, o.z, d.x, d.y, d.z, ray.tnear, ray.tfar})
        text += fmt::format("{}{:a}", text.empty() ? "" : ",", value);
    return text;
}

}  // namespace sightline
