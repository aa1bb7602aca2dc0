#include "intersect/ray_file.h"

#include "core/binary_file.h"
#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "scene/geometry_hash.h"

#include <fmt/format.h>

#include <algorithm>
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

/// The next number of a list, after which `at` is at its comma or at the end.
template <class Number, class Convert>
Number next_number(const char*& at, bool& valid, const Convert& convert) {
    char* end = nullptr;
    const auto value = static_cast<Number>(convert(at, &end));
    valid &= end != at && (*end == ',' || *end == '\0');
    at = end;
    return value;
}

}  // namespace

RecordedRay parse_ray(const std::string& text) {
    float values[8];
    uint32_t source[3] = {none, none, none};
    const char* at = text.c_str();
    bool valid = true;
    for (int i = 0; i < 8 && valid; ++i) {
        values[i] = next_number<float>(at, valid, std::strtof);
        if (i < 7) valid &= *at++ == ',';
    }
    RayKind kind = RayKind::camera;
    if (valid && *at == ',') {
        const std::string_view rest = std::string_view(at + 1).substr(0, std::strcspn(at + 1, ","));
        const auto found = std::ranges::find(ray_kind_names, rest);
        valid &= found != std::end(ray_kind_names);
        kind = static_cast<RayKind>(found - std::begin(ray_kind_names));
        at += 1 + rest.size();
        for (int i = 0; i < 3 && valid && (i > 0 || *at == ','); ++i) {
            valid &= *at++ == ',';
            if (valid)
                source[i] = next_number<uint32_t>(at, valid, [](const char* from, char** end) {
                    return std::strtoul(from, end, 10);
                });
        }
    }
    if (!valid || *at != '\0')
        throw std::invalid_argument(
            fmt::format("'{}' is not a ray ox,oy,oz,dx,dy,dz,tnear,tfar, perhaps with its kind and "
                        "the instance, geometry and primitive that it leaves",
                        text));
    return {{{values[0], values[1], values[2]},
             values[6],
             {values[3], values[4], values[5]},
             values[7]},
            kind,
            -1,
            -1,
            {source[0], source[1], source[2]}};
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
