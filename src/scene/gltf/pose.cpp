#include "scene/gltf/pose.h"

#include "scene/gltf/accessor.h"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {
namespace {

/// Reads a vertex attribute of a morph target or skin; its count must be that of the vertices.
template <class T>
std::vector<T> read_attribute(Document& document, uint32_t accessor, const std::string& place,
                              size_t vertices) {
    document.require_usable(accessor, Fault::primitive, place);
    if (const uint64_t count = document.accessors[accessor].count; count != vertices)
        document.fail_part(Fault::primitive, place,
                           fmt::format("has {} elements for {} vertices", count, vertices));
    return read_floats<T>(document, accessor, Fault::primitive, place);
}

/// One set of four joints and weights per vertex.
struct Influences {
    std::vector<uint32_t> joints;
    std::vector<Vec4> weights;
};

/// Takes joint 0 for joints that are out of range and have no weight.
void check_joints(Document& document, const std::string& place, size_t joint_count,
                  Influences& read) {
    bool mended = false;
    for (size_t i = 0; i < read.joints.size(); ++i) {
        uint32_t& joint = read.joints[i];
        if (joint < joint_count) continue;
        if (read.weights[i / 4][int(i % 4)] > 0)
            document.fail_part(
                Fault::primitive, place,
                fmt::format("joint {} is out of range: the skin has {}", joint, joint_count));
        joint = 0;
        mended = true;
    }
    if (mended)
        document.report(
            Fault::unused_joint, place,
            fmt::format("joints without weight are out of range: the skin has {}", joint_count));
}

Influences read_influences(Document& document, const GltfPrimitive& primitive, int set,
                           const std::string& place, size_t vertices, size_t joint_count) {
    const std::string joints = fmt::format("JOINTS_{}", set);
    const std::string weights = fmt::format("WEIGHTS_{}", set);
    const auto joints_accessor = primitive.attributes.find(joints);
    const auto weights_accessor = primitive.attributes.find(weights);
    const std::string joints_place = place + ".attributes." + joints;
    const std::string weights_place = place + ".attributes." + weights;
    if (joints_accessor == primitive.attributes.end())
        document.fail_part(Fault::primitive, joints_place, "is missing");
    if (weights_accessor == primitive.attributes.end())
        document.fail_part(Fault::primitive, weights_place, "is missing");
    Influences read;
    read.weights =
        read_attribute<Vec4>(document, weights_accessor->second, weights_place, vertices);
    read.joints = read_integers(document, joints_accessor->second, joints_place);
    if (read.joints.size() != 4 * vertices)
        document.fail_part(
            Fault::primitive, joints_place,
            fmt::format("does not have four joints for each of {} vertices", vertices));
    check_joints(document, joints_place, joint_count, read);
    return read;
}

/// The mean of the joints' matrices, weighted by all sets of one vertex.
Mat4d blend(std::span<const Mat4d> joints, const std::vector<Influences>& sets, size_t vertex) {
    Mat4d sum(0.0);
    double total = 0;
    for (const Influences& set : sets) {
        for (size_t i = 0; i < 4; ++i) {
            const double weight = double(set.weights[vertex][int(i)]);
            if (!(weight > 0)) continue;
            sum += joints[set.joints[4 * vertex + i]] * weight;
            total += weight;
        }
    }
    return total > 0 ? sum * (1 / total) : joints[sets[0].joints[4 * vertex]];
}

/// Transforms a normal by the inverse transpose times the absolute determinant, which exists even
/// if joints flatten the mesh.
Vec3d transform_normal(const Vec3d& n, const Mat4d& m, bool mirrored) {
    const Vec3d x(m[0][0], m[0][1], m[0][2]), y(m[1][0], m[1][1], m[1][2]);
    const Vec3d z(m[2][0], m[2][1], m[2][2]);
    const Vec3d turned = cross(y, z) * n.x + cross(z, x) * n.y + cross(x, y) * n.z;
    return mirrored ? -turned : turned;
}

double determinant(const Mat4d& m) {
    const Vec3d x(m[0][0], m[0][1], m[0][2]), y(m[1][0], m[1][1], m[1][2]);
    return dot(cross(x, y), Vec3d(m[2][0], m[2][1], m[2][2]));
}

/// Adds a morph target times `weight` to what `posed` has.
void add_target(Document& document, const std::map<std::string, uint32_t>& target, float weight,
                const std::string& place, Mesh& posed) {
    const auto add = [&]<class Delta>(Delta, const std::string& name, auto& to) {
        const auto accessor = target.find(name);
        if (to.empty() || accessor == target.end()) return;
        const std::vector<Delta> by =
            read_attribute<Delta>(document, accessor->second, place + "." + name, to.size());
        for (size_t v = 0; v < to.size(); ++v)
            for (int k = 0; k < int(Delta::dimensions()); ++k) to[v][k] += by[v][k] * weight;
    };
    add(Vec3(), "POSITION", posed.positions);
    add(Vec3(), "NORMAL", posed.normals);
    add(Vec3(), "TANGENT", posed.tangents);
    for (size_t set = 0; set < posed.texcoords.size(); ++set)
        add(Vec2(), fmt::format("TEXCOORD_{}", set), posed.texcoords[set]);
    const auto colors = target.find("COLOR_0");
    if (colors == target.end()) return;
    if (document.accessors[colors->second].components() == 3)
        add(Vec3(), "COLOR_0", posed.colors);
    else
        add(Vec4(), "COLOR_0", posed.colors);
}

}  // namespace

std::vector<Mat4d> joint_matrices(const GltfSkin& skin, std::span<const Mat4d> node_to_world) {
    std::vector<Mat4d> matrices(skin.joints.size());
    for (size_t i = 0; i < matrices.size(); ++i)
        matrices[i] = Mat4d(skin.inverse_binds[i]) * node_to_world[skin.joints[i]];
    return matrices;
}

void morph(Document& document, const GltfPrimitive& primitive, std::span<const float> weights,
           const std::string& place, Mesh& posed) {
    if (!weights.empty() && weights.size() != primitive.targets.size())
        document.report(
            Fault::morph_weights, place + ".targets",
            fmt::format("{} targets but {} weights", primitive.targets.size(), weights.size()));
    for (size_t i = 0; i < std::min(weights.size(), primitive.targets.size()); ++i) {
        if (weights[i] == 0) continue;
        add_target(document, primitive.targets[i], weights[i],
                   fmt::format("{}.targets[{}]", place, i), posed);
    }
    for (Vec3& normal : posed.normals) normal = normalize(normal);
    for (Vec4& tangent : posed.tangents) {
        const Vec3 unit = normalize(Vec3(tangent.x, tangent.y, tangent.z));
        tangent = {unit.x, unit.y, unit.z, tangent.w};
    }
}

void skin(Document& document, const GltfPrimitive& primitive, std::span<const Mat4d> joints,
          const std::string& place, Mesh& posed) {
    std::vector<Influences> sets;
    do {
        sets.push_back(read_influences(document, primitive, int(sets.size()), place,
                                       posed.positions.size(), joints.size()));
    } while (primitive.attributes.contains(fmt::format("JOINTS_{}", sets.size())) ||
             primitive.attributes.contains(fmt::format("WEIGHTS_{}", sets.size())));
    std::vector<bool> mirrored_vertices(posed.positions.size());
    for (size_t v = 0; v < posed.positions.size(); ++v) {
        const Mat4d matrix = blend(joints, sets, v);
        const bool mirrored = determinant(matrix) < 0;
        mirrored_vertices[v] = mirrored;
        posed.positions[v] = Vec3(transform_point(Vec3d(posed.positions[v]), matrix));
        if (!posed.normals.empty())
            posed.normals[v] =
                Vec3(normalize(transform_normal(Vec3d(posed.normals[v]), matrix, mirrored)));
        if (!posed.tangents.empty()) {
            const Vec4 old = posed.tangents[v];
            const Vec3 unit(normalize(
                transform_vector(Vec3d(double(old.x), double(old.y), double(old.z)), matrix)));
            posed.tangents[v] = {unit.x, unit.y, unit.z, mirrored ? -old.w : old.w};
        }
    }
    for (auto& [a, b, c] : posed.triangles)
        if (mirrored_vertices[a] + mirrored_vertices[b] + mirrored_vertices[c] >= 2)
            std::swap(b, c);
}

}  // namespace sightline
