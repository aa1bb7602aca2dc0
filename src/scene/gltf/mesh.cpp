#include "scene/gltf/mesh.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "scene/gltf/accessor.h"
#include "scene/gltf/material.h"
#include "scene/gltf/pose.h"
#include "scene/tangents.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>

namespace sightline {
namespace {

using nlohmann::json;
using Triangle = std::array<uint32_t, 3>;

template <class T>
void for_each_in_parallel(std::vector<T>& values, const auto& apply) {
    parallel_ranges(values.size(), [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) apply(values[i]);
    });
}

bool is_within(const Vec3& v, float limit) {
    return std::abs(v.x) <= limit && std::abs(v.y) <= limit && std::abs(v.z) <= limit;
}

// Reads an attribute, which must have as many elements as POSITION; empty if it is absent.
template <class T>
std::vector<T> read_attribute(Document& document, const GltfPrimitive& primitive,
                              const std::string& name, const std::string& place) {
    const auto found = primitive.attributes.find(name);
    if (found == primitive.attributes.end()) return {};
    const std::string at = place + ".attributes." + name;
    document.require_usable(found->second, Fault::primitive, at);
    const GltfAccessor& accessor = document.accessors[found->second];
    if (accessor.component_type == ComponentType::uint32)
        document.fail_part(Fault::primitive, at,
                           "has 32-bit integers, which are not allowed in attributes");
    const uint64_t vertices = document.accessors[primitive.attributes.at("POSITION")].count;
    if (accessor.count != vertices)
        document.fail_part(
            Fault::primitive, at,
            fmt::format("has {} elements, but POSITION {}", accessor.count, vertices));
    return read_floats<T>(document, found->second, Fault::primitive, at);
}

std::vector<Vec4> read_colors(Document& document, const GltfPrimitive& primitive,
                              const std::string& place) {
    const auto found = primitive.attributes.find("COLOR_0");
    if (found == primitive.attributes.end()) return {};
    if (document.accessors[found->second].components() != 3)
        return read_attribute<Vec4>(document, primitive, "COLOR_0", place);
    std::vector<Vec4> colors;
    for (const Vec3& c : read_attribute<Vec3>(document, primitive, "COLOR_0", place))
        colors.emplace_back(c.x, c.y, c.z, 1.0f);
    return colors;
}

void clamp_colors(std::vector<Vec4>& colors) {
    for (Vec4& c : colors)
        for (int i = 0; i < 4; ++i) c[i] = c[i] >= 0 ? std::min(c[i], 1.0f) : 0.0f;  // NaN: 0
}

// Reads a set of texture coordinates. One that no texture of the material uses may be wrong.
std::vector<Vec2> read_texcoord(Document& document, const GltfPrimitive& primitive,
                                const std::string& name, const std::string& place, bool used) try {
    return read_attribute<Vec2>(document, primitive, name, place);
} catch (const FaultyPart& part) {
    if (used) throw;
    document.report(Fault::attribute, part.place, part.detail);
    return {};
}

constexpr uint32_t max_texcoord = 255;

// TEXCOORD_0 and the sets that the material uses; others stay empty.
std::vector<std::vector<Vec2>> read_texcoords(Document& document, const GltfPrimitive& primitive,
                                              const std::string& place, const Material& material) {
    std::vector<uint32_t> sets{0};
    for_each_texture(material, [&](const TextureRef& ref) { sets.push_back(ref.texcoord); });
    std::vector<std::vector<Vec2>> texcoords;
    for (size_t i = 0; i < sets.size(); ++i) {
        const uint32_t set = sets[i];
        const std::string name = fmt::format("TEXCOORD_{}", set);
        if (set > max_texcoord)
            document.fail_part(Fault::primitive, place,
                               name + " is above the limit of TEXCOORD_255");
        if (!primitive.attributes.contains(name)) {
            if (i > 0)
                document.warn(place, fmt::format("has no {} for its material's textures", name));
            continue;
        }
        if (set >= texcoords.size()) texcoords.resize(set + 1);
        if (!texcoords[set].empty()) continue;
        const bool used = i > 0 || std::find(sets.begin() + 1, sets.end(), set) != sets.end();
        texcoords[set] = read_texcoord(document, primitive, name, place, used);
    }
    return texcoords;
}

void repair_texcoords(Mesh& mesh) {
    for (std::vector<Vec2>& set : mesh.texcoords)
        for (Vec2& uv : set)
            if (!std::isfinite(uv.x) || !std::isfinite(uv.y)) uv = {0, 0};
}

// The indices three by three. The last triangle may be incomplete.
std::vector<Triangle> read_indices(Document& document, const GltfPrimitive& primitive,
                                   size_t vertices, const std::string& place) {
    std::vector<Triangle> triples;
    const auto reserve = [&](size_t count) -> uint32_t* {
        reserve_in_large_pages(triples, (count + 2) / 3);
        triples.resize((count + 2) / 3);
        return triples.empty() ? nullptr : triples[0].data();
    };
    if (primitive.indices == none) {
        uint32_t* const all = reserve(vertices);
        std::iota(all, all + vertices, 0u);
        return triples;
    }
    const std::string at = place + ".indices";
    const GltfAccessor& accessor = document.accessors[primitive.indices];
    if (accessor.components() != 1)
        document.fail_part(Fault::primitive, at, "is not an accessor of scalars");
    require_integers(document, primitive.indices, at);
    uint32_t* const all = reserve(accessor.count);
    copy_integers(document, primitive.indices, all);
    std::atomic<bool> in_range = true;
    parallel_ranges(accessor.count, [&](size_t begin, size_t end) {
        if (std::any_of(all + begin, all + end, [&](uint32_t i) { return i >= vertices; }))
            in_range = false;
    });
    if (in_range) return triples;
    const uint32_t* bad =
        std::find_if(all, all + accessor.count, [&](uint32_t i) { return i >= vertices; });
    document.fail_part(Fault::primitive, at,
                       fmt::format("index {} at {} is out of range: there are {} vertices", *bad,
                                   bad - all, vertices));
}

constexpr int mode_triangles = 4, mode_strip = 5;  // and 6, a fan

// The triangles of a strip or a fan.
std::vector<Triangle> triangulate(std::span<const uint32_t> indices, int mode) {
    std::vector<Triangle> triangles;
    for (size_t i = 0; i + 2 < indices.size(); ++i) {
        const size_t odd = i & 1;
        triangles.push_back(mode == mode_strip
                                ? Triangle{indices[i], indices[i + 1 + odd], indices[i + 2 - odd]}
                                : Triangle{indices[i + 1], indices[i + 2], indices[0]});
    }
    return triangles;
}

bool is_degenerate(const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

// Without degenerate triangles, which connect strips.
std::vector<Triangle> read_triangles(Document& document, const GltfPrimitive& primitive,
                                     size_t vertices, const std::string& place) {
    std::vector<Triangle> triangles = read_indices(document, primitive, vertices, place);
    const size_t count =
        primitive.indices == none ? vertices : size_t{document.accessors[primitive.indices].count};
    if (primitive.mode == mode_triangles)
        triangles.resize(count / 3);
    else if (count > 0)
        triangles = triangulate(std::span(triangles[0].data(), count), primitive.mode);
    std::atomic<bool> all_good = true;
    parallel_ranges(triangles.size(), [&](size_t begin, size_t end) {
        if (std::any_of(triangles.begin() + begin, triangles.begin() + end, is_degenerate))
            all_good = false;
    });
    if (!all_good) std::erase_if(triangles, is_degenerate);
    return triangles;
}

// Its length is twice the area.
Vec3 face_normal(const Mesh& mesh, const Triangle& t) {
    const Vec3& a = mesh.positions[t[0]];
    return cross(mesh.positions[t[1]] - a, mesh.positions[t[2]] - a);
}

// Normalises normals; replaces one without direction by the area-weighted mean of its triangles'.
void repair_normals(Mesh& mesh) {
    std::atomic<bool> any = false;
    parallel_ranges(mesh.normals.size(), [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            Vec3& n = mesh.normals[i];
            const float largest = max_abs_component(n);
            const bool is_broken = !is_finite(n) || largest == 0;
            n = is_broken ? Vec3(0) : normalize(n / largest);
            if (is_broken) any = true;
        }
    });
    if (!any) return;
    std::vector<bool> broken(mesh.normals.size());
    for (size_t i = 0; i < broken.size(); ++i) broken[i] = mesh.normals[i] == Vec3(0);
    for (const Triangle& t : mesh.triangles) {
        for (const uint32_t v : t)
            if (broken[v]) mesh.normals[v] += face_normal(mesh, t);
    }
    for (size_t i = 0; i < broken.size(); ++i) {
        if (!broken[i]) continue;
        const Vec3 n = normalize(mesh.normals[i]);
        mesh.normals[i] = is_finite(n) && dot(n, n) > 0 ? n : Vec3(0, 0, 1);
    }
}

void repair_tangents(Mesh& mesh) {
    for (Vec4& t : mesh.tangents) {
        const Vec3 direction(t.x, t.y, t.z), unit = normalize(direction);
        const bool good = is_finite(unit) && dot(unit, unit) > 0;
        t = {good ? unit.x : 1, good ? unit.y : 0, good ? unit.z : 0, t.w < 0 ? -1.0f : 1.0f};
    }
}

template <class T>
void gather(std::vector<T>& values, const std::vector<uint32_t>& from) {
    if (values.empty()) return;
    std::vector<T> gathered(from.size());
    for (size_t i = 0; i < from.size(); ++i) gathered[i] = values[from[i]];
    values = std::move(gathered);
}

void gather_vertices(Mesh& mesh, const std::vector<uint32_t>& from) {
    gather(mesh.positions, from);
    gather(mesh.normals, from);
    gather(mesh.tangents, from);
    gather(mesh.colors, from);
    for (auto& set : mesh.texcoords) gather(set, from);
}

// Primitives may share one large vertex buffer; keep the vertices that this one uses.
void drop_unused_vertices(Mesh& mesh) {
    std::vector<uint8_t> used(mesh.positions.size(), 0);
    parallel_ranges(mesh.triangles.size(), [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            for (const uint32_t v : mesh.triangles[i])
                std::atomic_ref(used[v]).store(1, std::memory_order_relaxed);
    });
    if (std::ranges::find(used, 0) == used.end()) return;
    std::vector<uint32_t> renamed(used.size(), none), kept;
    for (uint32_t v = 0; v < used.size(); ++v) {
        if (!used[v]) continue;
        renamed[v] = static_cast<uint32_t>(kept.size());
        kept.push_back(v);
    }
    gather_vertices(mesh, kept);
    for (Triangle& t : mesh.triangles)
        for (uint32_t& v : t) v = renamed[v];
}

// No other feature reads tangents.
bool needs_tangents(const Material& material) {
    return !material.unlit && (material.normal_texture || material.clearcoat_normal_texture ||
                               material.anisotropy_strength > 0);
}

// Along the texture coordinates of the normal map, as the specification requires.
void add_tangents(Mesh& mesh, const Material& material) {
    const TextureRef& map = material.normal_texture             ? material.normal_texture
                            : material.clearcoat_normal_texture ? material.clearcoat_normal_texture
                                                                : material.anisotropy_texture;
    const uint32_t set = map.texcoord;
    if (set >= mesh.texcoords.size() || mesh.texcoords[set].empty() || mesh.triangles.empty())
        return;
    if (mesh.normals.empty()) compute_flat_normals(mesh);
    compute_tangents(mesh, set);
}

bool has_skin_attributes(const GltfPrimitive& primitive) {
    return primitive.attributes.contains("JOINTS_0") && primitive.attributes.contains("WEIGHTS_0");
}

bool is_splats(const json& source) {
    const auto extensions = source.find("extensions");
    if (extensions == source.end() || !extensions->is_object()) return false;
    return std::ranges::any_of(extensions->items(), [](const auto& extension) {
        return extension.key().starts_with("KHR_gaussian_splatting");
    });
}

// Reads the attributes of a primitive's vertices and morphs them.
Mesh read_vertices(Document& document, const GltfPrimitive& primitive, const std::string& place,
                   const Material& material, const MeshPose& pose) {
    Mesh mesh;
    mesh.positions = read_attribute<Vec3>(document, primitive, "POSITION", place);
    if (primitive.mode >= mode_triangles) {
        mesh.normals = read_attribute<Vec3>(document, primitive, "NORMAL", place);
        if (needs_tangents(material) && !mesh.normals.empty())
            mesh.tangents = read_attribute<Vec4>(document, primitive, "TANGENT", place);
        mesh.texcoords = read_texcoords(document, primitive, place, material);
        mesh.colors = read_colors(document, primitive, place);
    }
    if (!primitive.targets.empty()) morph(document, primitive, pose.weights, place, mesh);
    repair_texcoords(mesh);
    clamp_colors(mesh.colors);
    return mesh;
}

// Takes a mesh to world space, or else to the frame of object space.
void place_mesh(Document& document, const GltfPrimitive& primitive, const std::string& place,
                const MeshPose& pose, Mesh& mesh) {
    if (pose.joints && has_skin_attributes(primitive)) {
        skin(document, primitive, *pose.joints, place, mesh);
    } else if (pose.joints) {
        document.report(Fault::unskinned_primitive, place);
        transform_mesh(mesh, pose.node_to_world);
    } else if (!pose.frame.is_identity()) {
        for (Vec3& p : mesh.positions) p = Vec3(pose.frame.enter(Vec3d(p)));
    }
}

}  // namespace

PrimitiveMesh read_primitive(Document& document, const GltfPrimitive& primitive,
                             const nlohmann::json& source, const std::string& place,
                             const Material& material, const MeshPose& pose) {
    PrimitiveMesh result;
    if (primitive.attributes.empty()) return result;
    if (!primitive.attributes.contains("POSITION")) {
        document.warn(place, "has no POSITION: not drawn");
        return result;
    }
    Mesh& mesh = result.mesh;
    mesh = read_vertices(document, primitive, place, material, pose);
    const bool drawn = primitive.mode >= mode_triangles;
    if (drawn) mesh.triangles = read_triangles(document, primitive, mesh.positions.size(), place);
    place_mesh(document, primitive, place, pose, mesh);
    for (const Vec3& p : mesh.positions)
        if (is_finite(p)) result.bounds.extendBy(p);
    if (!drawn) {
        document.report(is_splats(source) ? Fault::splats : Fault::points_and_lines, "meshes");
        mesh = {};
        return result;
    }
    drop_out_of_range_triangles(document, mesh, place, std::numeric_limits<float>::max());
    drop_unused_vertices(mesh);
    repair_normals(mesh);
    repair_tangents(mesh);
    if (needs_tangents(material) && mesh.tangents.empty()) add_tangents(mesh, material);
    return result;
}

void transform_mesh(Mesh& mesh, const Mat4d& m) {
    const auto row = [&](int r) { return Vec3d(m[r][0], m[r][1], m[r][2]); };
    // The cofactors are the inverse transpose times the determinant; they exist for singular
    // matrices too.
    const Vec3d cofactors[3] = {cross(row(1), row(2)), cross(row(2), row(0)),
                                cross(row(0), row(1))};
    // A flattening matrix mirrors nothing: what its determinant differs from 0 is rounding.
    const double size = row(0).length() * row(1).length() * row(2).length();
    const bool mirrors = dot(row(0), cofactors[0]) < -1e-12 * size;
    const double sign = mirrors ? -1 : 1;
    for_each_in_parallel(mesh.positions, [&](Vec3& p) {
        p = Vec3(row(0) * double(p.x) + row(1) * double(p.y) + row(2) * double(p.z) + row(3));
    });
    for_each_in_parallel(mesh.normals, [&](Vec3& n) {
        const Vec3d v =
            (cofactors[0] * double(n.x) + cofactors[1] * double(n.y) + cofactors[2] * double(n.z)) *
            sign;
        const double length = std::sqrt(dot(v, v));
        if (length > 0) n = Vec3(v / length);
    });
    for_each_in_parallel(mesh.tangents, [&](Vec4& t) {
        const Vec3d v = row(0) * double(t.x) + row(1) * double(t.y) + row(2) * double(t.z);
        const double length = std::sqrt(dot(v, v));
        if (length > 0) {
            const Vec3 unit(v / length);
            t = {unit.x, unit.y, unit.z, mirrors ? -t.w : t.w};
        }
    });
    if (!mirrors) return;
    for (Triangle& t : mesh.triangles) std::swap(t[1], t[2]);
}

void drop_out_of_range_triangles(Document& document, Mesh& mesh, const std::string& place,
                                 float limit) {
    std::atomic<bool> all_within = true;
    for_each_in_parallel(mesh.positions, [&](const Vec3& p) {
        if (!is_within(p, limit)) all_within = false;
    });
    if (all_within) return;
    const auto dropped = std::erase_if(mesh.triangles, [&](const Triangle& t) {
        return !std::ranges::all_of(
            t, [&](uint32_t v) { return is_within(mesh.positions[v], limit); });
    });
    if (dropped == 0) return;
    drop_unused_vertices(mesh);
    document.warn(place, fmt::format("{} triangles with vertices that are NaN, infinite or too far "
                                     "away are dropped",
                                     dropped));
}

}  // namespace sightline
