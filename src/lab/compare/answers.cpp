#include "lab/compare/answers.h"

#include "core/binary_file.h"
#include "core/error.h"
#include "core/files.h"
#include "core/hash.h"
#include "intersect/ray_rules.h"
#include "scene/geometry_hash.h"

#include <fmt/format.h>

#include <cstring>
#include <unordered_map>

namespace sightline {
namespace {

constexpr std::string_view answers_magic = "SLANSW1\n";

/// The file's header after the magic.
struct Header {
    uint64_t count, geometry_hash, rays_hash;
};

/// An answer as the file holds it.
struct Record {
    uint32_t instance, geometry, primitive;
    float t, u, v;
    uint32_t occluded;

    bool operator==(const Record&) const = default;
};

/// Nanoseconds per ray by kind, at the end of the file; NaN: not measured. Optional.
using Times = std::array<double, ray_kinds>;

constexpr size_t header_bytes = answers_magic.size() + sizeof(Header);

struct Answers {
    std::vector<Record> records;
    std::optional<Times> times;
};

/// Answers closest-hit and any-hit queries for recorded rays, which it knows by their bits.
class AnswerReplay : public Intersector {
  public:
    AnswerReplay(std::vector<Record> records, std::span<const RecordedRay> rays,
                 const std::string& path)
        : records_(std::move(records)) {
        index_.reserve(rays.size());
        for (uint32_t i = 0; i < rays.size(); ++i) {
            const auto [known, is_new] = index_.try_emplace(hash_of(rays[i].ray), i);
            if (!is_new && records_[i] != records_[known->second])
                throw Error(fmt::format("{}: rays {} and {} are the same, their answers differ",
                                        path, known->second, i));
        }
    }

    void closest(std::span<const Ray> rays, std::span<Hit> hits, Coherence,
                 Visible) const override {
        for (size_t i = 0; i < rays.size(); ++i) {
            const Record* record = find(rays[i]);
            hits[i] = record && record->geometry != none
                          ? Hit{record->t,         record->u,        record->v,
                                record->primitive, record->geometry, record->instance}
                          : Hit{};
        }
    }
    void occluded(std::span<const Ray> rays, std::span<uint8_t> occluded, Coherence,
                  Visible) const override {
        for (size_t i = 0; i < rays.size(); ++i) {
            const Record* record = find(rays[i]);
            occluded[i] = record && record->occluded != 0;
        }
    }
    void all(std::span<const Ray>, std::vector<RayHit>&, Visible) const override {}
    std::string description() const override { return "answers from a file"; }
    size_t memory() const override { return 0; }

  private:
    static uint64_t hash_of(const Ray& ray) {
        return hash_bytes(std::as_bytes(std::span(&ray, 1)));
    }
    const Record* find(const Ray& ray) const {
        const auto found = index_.find(hash_of(ray));
        return found == index_.end() ? nullptr : &records_[found->second];
    }

    std::vector<Record> records_;
    std::unordered_map<uint64_t, uint32_t> index_;
};

Answers read_file_of_answers(const std::string& path, const Header& expected) {
    const auto bytes = read_file(path, uint64_t{1} << 36);
    if (bytes.size() < header_bytes ||
        std::memcmp(bytes.data(), answers_magic.data(), answers_magic.size()) != 0)
        throw Error(path + ": not a file of answers of version 1 (docs/engines.md)");
    Header header;
    std::memcpy(&header, bytes.data() + answers_magic.size(), sizeof header);
    if (header.geometry_hash != expected.geometry_hash)
        throw Error(path +
                    ": these answers belong to another scene, or to one that is stored "
                    "otherwise (--flatten)");
    if (header.rays_hash != expected.rays_hash || header.count != expected.count)
        throw Error(fmt::format("{}: these are answers to {} rays of another file than --rays",
                                path, header.count));
    const size_t body = header.count * sizeof(Record), left = bytes.size() - header_bytes;
    if (left != body && left != body + sizeof(Times))
        throw Error(fmt::format("{}: has {} bytes after its header, not {} or {}: truncated?", path,
                                left, body, body + sizeof(Times)));
    Answers answers;
    answers.records.resize(header.count);
    std::memcpy(answers.records.data(), bytes.data() + header_bytes, body);
    if (left > body)
        std::memcpy(&answers.times.emplace(), bytes.data() + header_bytes + body, sizeof(Times));
    return answers;
}

/// Why an answer cannot be one, or nothing.
std::optional<std::string> fault_of(const Record& record, const Ray& ray, const Scene& scene) {
    if (record.occluded > 1) return fmt::format("occluded is {}, not 0 or 1", record.occluded);
    if (record.geometry == none) return {};
    if (record.instance >= scene.instances.size())
        return fmt::format("there is no instance {}: there are {}", record.instance,
                           scene.instances.size());
    const Group& group = scene.groups[scene.instances[record.instance].group];
    const bool mesh = scene.is_mesh(record.geometry);
    const uint32_t local =
        mesh ? record.geometry : record.geometry - static_cast<uint32_t>(scene.meshes.size());
    if (std::ranges::count(mesh ? group.meshes : group.shapes, local) == 0)
        return fmt::format("instance {} has no geometry {}", record.instance, record.geometry);
    const size_t primitives = mesh ? scene.meshes[record.geometry].triangles.size() : 1;
    if (record.primitive >= primitives)
        return fmt::format("there is no primitive {} in geometry {}: there are {}",
                           record.primitive, record.geometry, primitives);
    for (const float number : {record.t, record.u, record.v})
        if (!std::isfinite(number)) return fmt::format("t, u or v is {}", number);
    if (is_valid(ray) && !(record.t > ray.tnear && record.t <= ray.tfar))
        return fmt::format("t {} is not in the ray's segment, {} < t <= {}", record.t, ray.tnear,
                           ray.tfar);
    return {};
}

}  // namespace

Engine read_answers(const std::string& name, const std::string& path, const Scene& scene,
                    const RayFile& rays) {
    Answers answers =
        read_file_of_answers(path, {rays.rays.size(), hash_geometry(scene), rays.hash});
    for (size_t i = 0; i < rays.rays.size(); ++i)
        if (const auto fault = fault_of(answers.records[i], rays.rays[i].ray, scene))
            throw Error(fmt::format("{}: ray {}: {}", path, i, *fault));
    Engine engine{name, std::make_unique<AnswerReplay>(std::move(answers.records), rays.rays, path),
                  Times()};
    engine.measured_ns->fill(std::numeric_limits<double>::quiet_NaN());
    if (answers.times) engine.measured_ns = answers.times;
    return engine;
}

void write_answers(const std::string& path, std::span<const Hit> hits,
                   std::span<const uint8_t> occluded, const Scene& scene, const RayFile& rays) {
    const Header header{rays.rays.size(), hash_geometry(scene), rays.hash};
    write_binary_file(path, "the answers", [&](std::ostream& file) {
        file << answers_magic;
        put(file, header);
        for (size_t i = 0; i < hits.size(); ++i) {
            const Hit& hit = hits[i];
            const Record record{hit.instance, hit.geometry, hit.primitive, hit.t,
                                hit.u,        hit.v,        occluded[i]};
            put(file, record);
        }
    });
}

}  // namespace sightline
