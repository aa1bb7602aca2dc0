#include "intersect/ray_file.h"

#include "core/error.h"
#include "core/files.h"

#include <fmt/format.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>

namespace sightline {
namespace {

constexpr std::string_view magic = "SLRAYS1\n";
constexpr size_t header_bytes = 16, ray_bytes = sizeof(Ray) + sizeof(uint32_t);

void check_header(const std::string& path, std::span<const std::byte> file) {
    const auto begins_with = [&](std::string_view text) {
        return file.size() >= text.size() &&
               std::memcmp(file.data(), text.data(), text.size()) == 0;
    };
    if (!begins_with(magic))
        throw Error(begins_with("SLRAYS")
                        ? path + ": a ray file of another version; expected SLRAYS1"
                        : path + ": not a ray file (--record-rays)");
    if (file.size() < header_bytes) throw Error(path + ": truncated within its header");
}

}  // namespace

void write_rays(const std::string& path, std::span<const RecordedRay> rays) {
    write_atomically(path, [&](const std::string& temporary) {
        std::ofstream file(temporary, std::ios::binary);
        const uint64_t count = rays.size();
        file.write(magic.data(), magic.size());
        file.write(reinterpret_cast<const char*>(&count), sizeof count);
        for (const RecordedRay& r : rays) {
            file.write(reinterpret_cast<const char*>(&r.ray), sizeof r.ray);
            file.write(reinterpret_cast<const char*>(&r.kind), sizeof r.kind);
        }
        file.flush();
        if (!file) throw Error(path + ": cannot write the rays: disk full?");
    });
}

std::vector<RecordedRay> read_rays(const std::string& path) {
    const auto file = read_file(path, uint64_t{1} << 36);
    check_header(path, file);
    uint64_t count = 0;
    std::memcpy(&count, file.data() + magic.size(), sizeof count);
    const uint64_t held = (file.size() - header_bytes) / ray_bytes;
    if (count != held || (file.size() - header_bytes) % ray_bytes != 0)
        throw Error(fmt::format("{}: the header declares {} rays, the file holds {}: truncated?",
                                path, count, held));
    std::vector<RecordedRay> rays(count);
    for (size_t i = 0; i < count; ++i) {
        const std::byte* at = file.data() + header_bytes + i * ray_bytes;
        uint32_t kind = 0;
        std::memcpy(static_cast<void*>(&rays[i].ray), at, sizeof(Ray));
        std::memcpy(&kind, at + sizeof(Ray), sizeof kind);
        if (kind >= ray_kinds)
            throw Error(fmt::format("{}: ray {} is of the unknown kind {}", path, i, kind));
        rays[i].kind = static_cast<RayKind>(kind);
    }
    return rays;
}

Ray parse_ray(const std::string& text) {
    float values[8];
    const char* at = text.c_str();
    for (int i = 0; i < 8; ++i) {
        char* end = nullptr;
        values[i] = std::strtof(at, &end);
        if (end == at || *end != (i < 7 ? ',' : '\0'))
            throw std::invalid_argument(
                fmt::format("'{}' is not a ray ox,oy,oz,dx,dy,dz,tnear,tfar", text));
        at = end + 1;
    }
    return {
        {values[0], values[1], values[2]}, values[6], {values[3], values[4], values[5]}, values[7]};
}

std::string ray_literal(const Ray& ray) {
    const Vec3 &o = ray.origin, &d = ray.direction;
    std::string text;
    for (const float value : {o.x, o.y, o.z, d.x, d.y, d.z, ray.tnear, ray.tfar})
        text += fmt::format("{}{:a}", text.empty() ? "" : ",", value);
    return text;
}

}  // namespace sightline
