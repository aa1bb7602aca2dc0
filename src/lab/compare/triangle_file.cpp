#include "lab/compare/triangle_file.h"

#include "core/binary_file.h"
#include "scene/geometry_hash.h"

#include <string_view>

namespace sightline {
namespace {

constexpr std::string_view triangle_magic = "SLTRIS1\n";

/// A mesh of an instance.
struct Placement {
    uint32_t instance, geometry;
};

std::vector<Placement> placements_of(const Scene& scene) {
    std::vector<Placement> placements;
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        for (const uint32_t mesh : scene.groups[scene.instances[i].group].meshes)
            placements.push_back({i, mesh});
    return placements;
}

void put_mesh(std::ostream& file, const Mesh& mesh) {
    put(file, uint64_t{mesh.positions.size()});
    put(file, uint64_t{mesh.triangles.size()});
    for (const Vec3& position : mesh.positions) put(file, position);
    for (const auto& triangle : mesh.triangles) put(file, triangle);
}

/// A row of the matrix for each axis of the object, then the translation.
void put_matrix(std::ostream& file, const Mat4& matrix) {
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 3; ++column) put(file, matrix[row][column]);
}

}  // namespace

void write_triangles(const std::string& path, const Scene& scene) {
    const std::vector<Placement> placements = placements_of(scene);
    write_binary_file(path, "the triangles", [&](std::ostream& file) {
        file << triangle_magic;
        put(file, hash_geometry(scene));
        put(file, uint64_t{scene.meshes.size()});
        put(file, uint64_t{placements.size()});
        for (const Mesh& mesh : scene.meshes) put_mesh(file, mesh);
        for (const Placement& placement : placements) {
            const Instance& instance = scene.instances[placement.instance];
            put(file, placement);
            put_matrix(file, instance.baked ? Mat4() : instance.object_to_world);
        }
    });
}

Scene flatten(const Scene& scene) {
    Scene flat = scene;
    flat.meshes.clear();
    flat.groups.clear();
    const auto add_group = [&flat](Instance& instance) -> Group& {
        instance.group = static_cast<uint32_t>(flat.groups.size());
        return flat.groups.emplace_back();
    };
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& from = scene.instances[i];
        const Group& group = scene.groups[from.group];
        Group& meshes = add_group(flat.instances[i]);
        for (const uint32_t mesh : group.meshes) {
            meshes.meshes.push_back(static_cast<uint32_t>(flat.meshes.size()));
            std::vector<Vec3>& positions = flat.meshes.emplace_back(scene.meshes[mesh]).positions;
            if (!from.baked)
                for (Vec3& p : positions) p = transform_point(p, from.object_to_world);
            positions.reserve(positions.size() + 1);
        }
        flat.instances[i].baked = true;
        flat.instances[i].object_to_world = flat.instances[i].world_to_object = Mat4();
        if (group.shapes.empty()) continue;
        Instance shapes = from;
        add_group(shapes).shapes = group.shapes;
        flat.instances.push_back(shapes);
    }
    return flat;
}

}  // namespace sightline
