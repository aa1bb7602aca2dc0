#pragma once
// The scene as plain data: vectors and indices, built once, then const.
#include "core/math.h"
#include "image/image.h"
#include "scene/frame.h"
#include "scene/gltf/faults.h"

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace sightline {

/// A triangle mesh, from one glTF primitive, in object space (world space if its instance is
/// `baked`).
struct Mesh {
    std::vector<Vec3> positions;  ///< with capacity for one more: Embree reads in place
    std::vector<Vec3> normals;    ///< unit; empty: flat shading
    std::vector<Vec4> tangents;   ///< unit xyz, w = ±1 bitangent sign; empty: not needed
    std::vector<std::vector<Vec2>> texcoords;        ///< [n][vertex] for TEXCOORD_n
    std::vector<Vec4> colors;                        ///< COLOR_0, linear; empty: white
    std::vector<std::array<uint32_t, 3>> triangles;  ///< counter-clockwise from the front
    uint32_t material = 0;
    std::string name;
};

enum class ShapeKind { sphere, box, capsule, cylinder, plane, torus, heart };

/// An analytic surface centred at the origin of its space, y up as in KHR_implicit_shapes.
struct Shape {
    ShapeKind kind = ShapeKind::sphere;
    float radius = 0.5f;        ///< sphere; torus: centre line (R)
    float tube_radius = 0.25f;  ///< torus: tube (r); its axis is y
    Vec3 size{1, 1, 1};         ///< box: full extents; plane: x and z extents, ≤ 0: endless
    float height = 0.5f;        ///< capsule (between the centres of its caps), cylinder
    float radius_top = 0.25f, radius_bottom = 0.25f;  ///< capsule, cylinder (a cone if they differ)
    float scale = 1;  ///< heart: (x²+9z²/4+y²−1)³ = x²y³+9z²y³/80 at 1, point down −y
    uint32_t material = 0;
    Mat4d to_object;  ///< shape space to object space (world space if its instance is `baked`)
    Mat4d to_shape;   ///< the inverse
    std::string name;
};

/// The meshes and shapes of one glTF mesh, which are instanced together.
struct Group {
    std::vector<uint32_t> meshes, shapes;
};

/// A group with a transform. A group with one instance is `baked`: its vertices are in world space,
/// and the instance's matrices are the identity.
struct Instance {
    uint32_t group = none;
    Mat4 object_to_world, world_to_object;
    bool baked = false;
    bool mirrored = false;  ///< the matrix has a negative determinant: front faces are clockwise
    std::string name;       ///< the node's, or the mesh's if the node has none
};

enum class Filter {
    nearest,
    linear,
    nearest_mipmap_nearest,
    linear_mipmap_nearest,
    nearest_mipmap_linear,
    linear_mipmap_linear
};
enum class Wrap { repeat, clamp_to_edge, mirrored_repeat };

/// An image with its sampler.
struct Texture {
    uint32_t image = none;  ///< into Scene::images
    Filter mag = Filter::linear, min = Filter::linear_mipmap_linear;
    Wrap wrap_s = Wrap::repeat, wrap_t = Wrap::repeat;
};

/// A material's reference to a texture. uv' = (uv·scale, rotated counter-clockwise) + offset
/// (KHR_texture_transform).
struct TextureRef {
    uint32_t texture = none;  ///< into Scene::textures
    uint32_t texcoord = 0;
    Vec2 offset{0, 0}, scale{1, 1};
    float rotation = 0;  ///< radians

    explicit operator bool() const { return texture != none; }
};

enum class AlphaMode { opaque, mask, blend };

/// glTF's metallic-roughness material with its extensions; names and defaults are glTF's.
struct Material {
    std::string name;
    Vec4 base_color_factor{1, 1, 1, 1};
    TextureRef base_color_texture;
    float metallic_factor = 1, roughness_factor = 1;
    TextureRef metallic_roughness_texture;
    TextureRef normal_texture;
    float normal_scale = 1;
    TextureRef occlusion_texture;
    float occlusion_strength = 1;
    Vec3 emissive_factor{0, 0, 0};  ///< times KHR_materials_emissive_strength
    TextureRef emissive_texture;
    AlphaMode alpha_mode = AlphaMode::opaque;
    float alpha_cutoff = 0.5f;
    bool double_sided = false;
    bool unlit = false;
    float ior = 1.5f;  ///< 0: Fresnel = 1, a special case of KHR_materials_ior
    float transmission_factor = 0;
    TextureRef transmission_texture;
    float thickness_factor = 0;  ///< 0: thin-walled; otherwise the mesh bounds a volume
    float attenuation_distance = std::numeric_limits<float>::infinity();  ///< world units
    Vec3 attenuation_color{1, 1, 1};
    float dispersion = 0;
    float specular_factor = 1;
    TextureRef specular_texture;  ///< A channel
    Vec3 specular_color_factor{1, 1, 1};
    TextureRef specular_color_texture;
    TextureRef glossiness_texture;  ///< A channel: a factor of 1 − roughness_factor
    float clearcoat_factor = 0;
    TextureRef clearcoat_texture;
    float clearcoat_roughness_factor = 0;
    TextureRef clearcoat_roughness_texture;
    TextureRef clearcoat_normal_texture;
    float clearcoat_normal_scale = 1;
    Vec3 sheen_color_factor{0, 0, 0};
    TextureRef sheen_color_texture;
    float sheen_roughness_factor = 0;
    TextureRef sheen_roughness_texture;
    float anisotropy_strength = 0, anisotropy_rotation = 0;
    TextureRef anisotropy_texture;
    float iridescence_factor = 0, iridescence_ior = 1.3f;
    TextureRef iridescence_texture;
    float iridescence_thickness_minimum = 100, iridescence_thickness_maximum = 400;  ///< nm
    TextureRef iridescence_thickness_texture;
    float diffuse_transmission_factor = 0;
    TextureRef diffuse_transmission_texture;
    Vec3 diffuse_transmission_color_factor{1, 1, 1};
    TextureRef diffuse_transmission_color_texture;
};

/// Calls `visit` with each texture reference of a material except the occlusion texture: occlusion
/// results from ray tracing.
void for_each_texture(const Material& material,
                      const std::function<void(const TextureRef&)>& visit);
void for_each_texture(Material& material, const std::function<void(TextureRef&)>& visit);

enum class LightKind { directional, point, spot };

/// KHR_lights_punctual, in world space.
struct Light {
    LightKind kind = LightKind::point;
    Vec3 color{1, 1, 1};
    float intensity = 1;  ///< candela (point, spot), lux (directional)
    Vec3 position{0, 0, 0};
    Vec3 direction{0, 0, -1};  ///< unit; the direction in which the light travels
    float range = std::numeric_limits<float>::infinity();
    float inner_cone_angle = 0, outer_cone_angle = pi / 4;
    std::string name;
};

/// A camera in world space that looks along −z of its matrix, with +y up.
struct Camera {
    bool orthographic = false;
    float yfov = pi / 4;       ///< radians
    float aspect = 0;          ///< width/height; 0: the picture's
    float xmag = 1, ymag = 1;  ///< half the view's width and height (orthographic)
    float znear = 0, zfar = std::numeric_limits<float>::infinity();
    Mat4 to_world;  ///< rigid: unit orthogonal axes
    std::string name;
    std::string fault;  ///< why nothing can be seen through it; empty: it can be used
};

/// A file that a scene was read from.
struct SourceFile {
    std::string path;
    uint64_t hash = 0;  ///< hash_bytes of its content
};

/// The names in a file that `--scene`, `--variant` and `--animation` accept, and the extensions
/// that it uses, in the file's order. Names may be empty, because an index selects as well.
struct FileContents {
    struct Animation {
        std::string name;
        double seconds = 0;  ///< time of the last keyframe
    };
    std::vector<std::string> scenes, variants, extensions;
    std::vector<Animation> animations;
};

/// All coordinates and lengths are in `frame`: world space, unless the scene is far from the
/// origin, tiny or huge. The comments say "world space" for both.
struct Scene {
    std::string path;  ///< of the glTF file
    Frame frame;
    std::vector<Mesh> meshes;
    std::vector<Shape> shapes;
    std::vector<Group> groups;
    std::vector<Instance> instances;
    std::vector<Material> materials;  ///< index 0 is glTF's default material
    std::vector<Texture> textures;
    std::vector<Image> images;  ///< empty if no geometry uses the image
    std::vector<Light> lights;
    std::vector<Camera> cameras;
    /// SIGHTLINE_background: radiance of rays that miss the scene. It does not light surfaces,
    /// and it replaces the default environment.
    std::optional<Vec3> background;
    Box3 bounds;  ///< union of each mesh's object-space box, transformed (for the fitted camera)
    FileContents contents;
    std::vector<std::string> warnings;     ///< with a line for each fault
    std::vector<FoundFault> faults;        ///< at most 200
    uint64_t fault_count = 0;              ///< of all faults
    std::vector<SourceFile> files;         ///< every file that was read: glTF, buffers, images
    std::vector<std::string> named_files;  ///< paths of its buffers and images, read or not
    uint64_t content_hash = 0;             ///< of every byte read: file, buffers, images

    bool is_mesh(uint32_t geometry) const { return geometry < meshes.size(); }
    const Shape& shape(uint32_t geometry) const { return shapes[geometry - meshes.size()]; }
    uint32_t material_of(uint32_t geometry) const {
        return is_mesh(geometry) ? meshes[geometry].material : shape(geometry).material;
    }
};

/// By material: whether some instance uses it.
std::vector<bool> used_materials(const Scene& scene);

}  // namespace sightline
