// What the glTF 2.0 specification says about the properties that Sightline reads, as a table.
#include "scene/gltf_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>
#include <unordered_map>

namespace sightline {
namespace {

using nlohmann::json;

enum class Kind {
    boolean,
    number,
    numbers,
    string,
    strings,
    natural,  // an integer from 0 to 2^53
    small,    // an integer from 0 to 2^31 − 1
    stride,   // a multiple of 4 up to 252
    choice,   // one of the words, or integers, in `of`
    index,    // below the size of the array at the JSON pointer `of`
    indices,
    dictionary,  // an object whose values are indices
    dictionaries,
    object,  // checked by the rules of `of`
    objects,
};

struct Rule {
    std::string_view owner, name;
    Kind kind;
    std::string_view of = {};
    size_t size = 0;  // of numbers; 0: any
    bool required = false;
};

constexpr bool required = true;

// Rows of one owner stand together.
constexpr Rule rules[] = {
    {"", "asset", Kind::object, "asset", 0, required},
    {"", "extensionsUsed", Kind::strings},
    {"", "extensionsRequired", Kind::strings},
    {"", "accessors", Kind::objects, "accessor"},
    {"", "animations", Kind::objects, "animation"},
    {"", "buffers", Kind::objects, "buffer"},
    {"", "bufferViews", Kind::objects, "bufferView"},
    {"", "cameras", Kind::objects, "camera"},
    {"", "images", Kind::objects, "image"},
    {"", "materials", Kind::objects, "material"},
    {"", "meshes", Kind::objects, "mesh"},
    {"", "nodes", Kind::objects, "node"},
    {"", "samplers", Kind::objects, "sampler"},
    {"", "scene", Kind::index, "/scenes"},
    {"", "scenes", Kind::objects, "scene"},
    {"", "skins", Kind::objects, "skin"},
    {"", "textures", Kind::objects, "texture"},
    {"", "extensions", Kind::object, "extensions"},
    {"asset", "version", Kind::string, {}, 0, required},
    {"asset", "minVersion", Kind::string},
    {"extensions", "KHR_lights_punctual", Kind::object, "lights"},
    {"extensions", "KHR_materials_variants", Kind::object, "variants"},
    {"extensions", "KHR_implicit_shapes", Kind::object, "shapes"},
    {"lights", "lights", Kind::objects, "light", 0, required},
    {"light", "type", Kind::choice, "directional point spot", 0, required},
    {"light", "name", Kind::string},
    {"light", "color", Kind::numbers, {}, 3},
    {"light", "intensity", Kind::number},
    {"light", "range", Kind::number},
    {"light", "spot", Kind::object, "spot"},
    {"spot", "innerConeAngle", Kind::number},
    {"spot", "outerConeAngle", Kind::number},
    {"shapes", "shapes", Kind::objects, "shape", 0, required},
    {"shape", "type", Kind::string, {}, 0, required},
    {"shape", "sphere", Kind::object, "shape.parameters"},
    {"shape", "box", Kind::object, "shape.parameters"},
    {"shape", "capsule", Kind::object, "shape.parameters"},
    {"shape", "cylinder", Kind::object, "shape.parameters"},
    {"shape", "plane", Kind::object, "shape.parameters"},
    {"shape", "torus", Kind::object, "shape.parameters"},
    {"shape", "heart", Kind::object, "shape.parameters"},
    {"shape.parameters", "radius", Kind::number},
    {"shape.parameters", "tubeRadius", Kind::number},
    {"shape.parameters", "size", Kind::numbers, {}, 3},
    {"shape.parameters", "sizeX", Kind::number},
    {"shape.parameters", "sizeZ", Kind::number},
    {"shape.parameters", "height", Kind::number},
    {"shape.parameters", "radiusTop", Kind::number},
    {"shape.parameters", "radiusBottom", Kind::number},
    {"shape.parameters", "scale", Kind::number},
    {"variants", "variants", Kind::objects, "variant", 0, required},
    {"variant", "name", Kind::string, {}, 0, required},

    {"buffer", "uri", Kind::string},
    {"buffer", "byteLength", Kind::natural, {}, 0, required},
    {"bufferView", "buffer", Kind::index, "/buffers", 0, required},
    {"bufferView", "byteOffset", Kind::natural},
    {"bufferView", "byteLength", Kind::natural, {}, 0, required},
    {"bufferView", "byteStride", Kind::stride},
    {"bufferView", "extensions", Kind::object, "bufferView.extensions"},
    {"bufferView.extensions", "EXT_meshopt_compression", Kind::object, "meshopt"},
    {"meshopt", "buffer", Kind::index, "/buffers", 0, required},
    {"meshopt", "byteOffset", Kind::natural},
    {"meshopt", "byteLength", Kind::natural, {}, 0, required},
    {"meshopt", "byteStride", Kind::small, {}, 0, required},
    {"meshopt", "count", Kind::natural, {}, 0, required},
    {"meshopt", "mode", Kind::choice, "ATTRIBUTES TRIANGLES INDICES", 0, required},
    {"meshopt", "filter", Kind::choice, "NONE OCTAHEDRAL QUATERNION EXPONENTIAL"},
    {"accessor", "bufferView", Kind::index, "/bufferViews"},
    {"accessor", "byteOffset", Kind::natural},
    {"accessor", "componentType", Kind::choice, "5120 5121 5122 5123 5125 5126", 0, required},
    {"accessor", "normalized", Kind::boolean},
    {"accessor", "count", Kind::natural, {}, 0, required},
    {"accessor", "type", Kind::choice, "SCALAR VEC2 VEC3 VEC4 MAT2 MAT3 MAT4", 0, required},
    {"accessor", "sparse", Kind::object, "sparse"},
    {"sparse", "count", Kind::small, {}, 0, required},
    {"sparse", "indices", Kind::object, "sparse.indices", 0, required},
    {"sparse", "values", Kind::object, "sparse.values", 0, required},
    {"sparse.indices", "bufferView", Kind::index, "/bufferViews", 0, required},
    {"sparse.indices", "byteOffset", Kind::small},
    {"sparse.indices", "componentType", Kind::choice, "5121 5123 5125", 0, required},
    {"sparse.values", "bufferView", Kind::index, "/bufferViews", 0, required},
    {"sparse.values", "byteOffset", Kind::small},

    {"mesh", "name", Kind::string},
    {"mesh", "primitives", Kind::objects, "primitive", 0, required},
    {"mesh", "weights", Kind::numbers},
    {"primitive", "attributes", Kind::dictionary, "/accessors", 0, required},
    {"primitive", "indices", Kind::index, "/accessors"},
    {"primitive", "material", Kind::index, "/materials"},
    {"primitive", "mode", Kind::choice, "0 1 2 3 4 5 6"},
    {"primitive", "targets", Kind::dictionaries, "/accessors"},
    {"primitive", "extensions", Kind::object, "primitive.extensions"},
    {"primitive.extensions", "KHR_draco_mesh_compression", Kind::object, "draco"},
    {"primitive.extensions", "KHR_materials_variants", Kind::object, "mappings"},
    {"draco", "bufferView", Kind::index, "/bufferViews", 0, required},
    {"draco", "attributes", Kind::object, "draco.attributes", 0, required},
    {"mappings", "mappings", Kind::objects, "mapping", 0, required},
    {"mapping", "material", Kind::index, "/materials", 0, required},
    {"mapping", "variants", Kind::indices, "/extensions/KHR_materials_variants/variants", 0,
     required},

    {"scene", "name", Kind::string},
    {"scene", "nodes", Kind::indices, "/nodes"},
    {"scene", "extensions", Kind::object, "scene.extensions"},
    {"scene.extensions", "SIGHTLINE_background", Kind::object, "background"},
    {"background", "color", Kind::numbers, {}, 3, required},
    {"node", "name", Kind::string},
    {"node", "children", Kind::indices, "/nodes"},
    {"node", "camera", Kind::index, "/cameras"},
    {"node", "mesh", Kind::index, "/meshes"},
    {"node", "skin", Kind::index, "/skins"},
    {"node", "matrix", Kind::numbers, {}, 16},
    {"node", "rotation", Kind::numbers, {}, 4},
    {"node", "scale", Kind::numbers, {}, 3},
    {"node", "translation", Kind::numbers, {}, 3},
    {"node", "weights", Kind::numbers},
    {"node", "extensions", Kind::object, "node.extensions"},
    {"node.extensions", "KHR_lights_punctual", Kind::object, "node.light"},
    {"node.extensions", "SIGHTLINE_implicit_shapes", Kind::object, "node.shape"},
    {"node.extensions", "EXT_mesh_gpu_instancing", Kind::object, "instancing"},
    {"node.extensions", "KHR_node_visibility", Kind::object, "visibility"},
    {"node.light", "light", Kind::index, "/extensions/KHR_lights_punctual/lights", 0, required},
    {"node.shape", "shape", Kind::index, "/extensions/KHR_implicit_shapes/shapes", 0, required},
    {"node.shape", "material", Kind::index, "/materials"},
    {"instancing", "attributes", Kind::dictionary, "/accessors", 0, required},
    {"visibility", "visible", Kind::boolean},
    {"skin", "joints", Kind::indices, "/nodes", 0, required},
    {"skin", "inverseBindMatrices", Kind::index, "/accessors"},
    {"skin", "skeleton", Kind::index, "/nodes"},
    {"animation", "name", Kind::string},
    {"animation", "channels", Kind::objects, "channel", 0, required},
    {"animation", "samplers", Kind::objects, "animation.sampler", 0, required},
    {"channel", "sampler", Kind::small, {}, 0, required},
    {"channel", "target", Kind::object, "target", 0, required},
    {"target", "node", Kind::index, "/nodes"},
    {"target", "path", Kind::string, {}, 0, required},
    {"animation.sampler", "input", Kind::index, "/accessors", 0, required},
    {"animation.sampler", "output", Kind::index, "/accessors", 0, required},
    {"animation.sampler", "interpolation", Kind::choice, "LINEAR STEP CUBICSPLINE"},
    {"camera", "name", Kind::string},
    {"camera", "type", Kind::choice, "perspective orthographic", 0, required},
    {"camera", "perspective", Kind::object, "perspective"},
    {"camera", "orthographic", Kind::object, "orthographic"},
    {"perspective", "yfov", Kind::number, {}, 0, required},
    {"perspective", "znear", Kind::number, {}, 0, required},
    {"perspective", "zfar", Kind::number},
    {"perspective", "aspectRatio", Kind::number},
    {"orthographic", "xmag", Kind::number, {}, 0, required},
    {"orthographic", "ymag", Kind::number, {}, 0, required},
    {"orthographic", "znear", Kind::number, {}, 0, required},
    {"orthographic", "zfar", Kind::number, {}, 0, required},

    {"image", "uri", Kind::string},
    {"image", "bufferView", Kind::index, "/bufferViews"},
    {"sampler", "magFilter", Kind::choice, "9728 9729"},
    {"sampler", "minFilter", Kind::choice, "9728 9729 9984 9985 9986 9987"},
    {"sampler", "wrapS", Kind::choice, "33071 33648 10497"},
    {"sampler", "wrapT", Kind::choice, "33071 33648 10497"},
    {"texture", "source", Kind::index, "/images"},
    {"texture", "sampler", Kind::index, "/samplers"},
    {"texture", "extensions", Kind::object, "texture.extensions"},
    {"texture.extensions", "EXT_texture_webp", Kind::object, "texture.source"},
    {"texture.extensions", "EXT_texture_avif", Kind::object, "texture.source"},
    {"texture.extensions", "KHR_texture_basisu", Kind::object, "texture.source"},
    {"texture.source", "source", Kind::index, "/images"},

    {"material", "name", Kind::string},
    {"material", "pbrMetallicRoughness", Kind::object, "pbr"},
    {"material", "normalTexture", Kind::object, "texture.info"},
    {"material", "occlusionTexture", Kind::object, "texture.info"},
    {"material", "emissiveTexture", Kind::object, "texture.info"},
    {"material", "emissiveFactor", Kind::numbers, {}, 3},
    {"material", "alphaMode", Kind::choice, "OPAQUE MASK BLEND"},
    {"material", "alphaCutoff", Kind::number},
    {"material", "doubleSided", Kind::boolean},
    {"material", "extensions", Kind::object, "material.extensions"},
    {"pbr", "baseColorFactor", Kind::numbers, {}, 4},
    {"pbr", "baseColorTexture", Kind::object, "texture.info"},
    {"pbr", "metallicFactor", Kind::number},
    {"pbr", "roughnessFactor", Kind::number},
    {"pbr", "metallicRoughnessTexture", Kind::object, "texture.info"},
    {"texture.info", "index", Kind::index, "/textures", 0, required},
    {"texture.info", "texCoord", Kind::small},
    {"texture.info", "scale", Kind::number},
    {"texture.info", "strength", Kind::number},
    {"texture.info", "extensions", Kind::object, "texture.info.extensions"},
    {"texture.info.extensions", "KHR_texture_transform", Kind::object, "transform"},
    {"transform", "offset", Kind::numbers, {}, 2},
    {"transform", "rotation", Kind::number},
    {"transform", "scale", Kind::numbers, {}, 2},
    {"transform", "texCoord", Kind::small},
    {"material.extensions", "KHR_materials_anisotropy", Kind::object, "anisotropy"},
    {"material.extensions", "KHR_materials_clearcoat", Kind::object, "clearcoat"},
    {"material.extensions", "KHR_materials_diffuse_transmission", Kind::object, "diffuse"},
    {"material.extensions", "KHR_materials_dispersion", Kind::object, "dispersion"},
    {"material.extensions", "KHR_materials_emissive_strength", Kind::object, "emissive"},
    {"material.extensions", "KHR_materials_ior", Kind::object, "ior"},
    {"material.extensions", "KHR_materials_iridescence", Kind::object, "iridescence"},
    {"material.extensions", "KHR_materials_sheen", Kind::object, "sheen"},
    {"material.extensions", "KHR_materials_specular", Kind::object, "specular"},
    {"material.extensions", "KHR_materials_transmission", Kind::object, "transmission"},
    {"material.extensions", "KHR_materials_unlit", Kind::object, "unlit"},
    {"material.extensions", "KHR_materials_volume", Kind::object, "volume"},
    {"material.extensions", "KHR_materials_pbrSpecularGlossiness", Kind::object, "glossiness"},
    {"anisotropy", "anisotropyStrength", Kind::number},
    {"anisotropy", "anisotropyRotation", Kind::number},
    {"anisotropy", "anisotropyTexture", Kind::object, "texture.info"},
    {"clearcoat", "clearcoatFactor", Kind::number},
    {"clearcoat", "clearcoatTexture", Kind::object, "texture.info"},
    {"clearcoat", "clearcoatRoughnessFactor", Kind::number},
    {"clearcoat", "clearcoatRoughnessTexture", Kind::object, "texture.info"},
    {"clearcoat", "clearcoatNormalTexture", Kind::object, "texture.info"},
    {"diffuse", "diffuseTransmissionFactor", Kind::number},
    {"diffuse", "diffuseTransmissionTexture", Kind::object, "texture.info"},
    {"diffuse", "diffuseTransmissionColorFactor", Kind::numbers, {}, 3},
    {"diffuse", "diffuseTransmissionColorTexture", Kind::object, "texture.info"},
    {"dispersion", "dispersion", Kind::number},
    {"emissive", "emissiveStrength", Kind::number},
    {"ior", "ior", Kind::number},
    {"iridescence", "iridescenceFactor", Kind::number},
    {"iridescence", "iridescenceTexture", Kind::object, "texture.info"},
    {"iridescence", "iridescenceIor", Kind::number},
    {"iridescence", "iridescenceThicknessMinimum", Kind::number},
    {"iridescence", "iridescenceThicknessMaximum", Kind::number},
    {"iridescence", "iridescenceThicknessTexture", Kind::object, "texture.info"},
    {"sheen", "sheenColorFactor", Kind::numbers, {}, 3},
    {"sheen", "sheenColorTexture", Kind::object, "texture.info"},
    {"sheen", "sheenRoughnessFactor", Kind::number},
    {"sheen", "sheenRoughnessTexture", Kind::object, "texture.info"},
    {"specular", "specularFactor", Kind::number},
    {"specular", "specularTexture", Kind::object, "texture.info"},
    {"specular", "specularColorFactor", Kind::numbers, {}, 3},
    {"specular", "specularColorTexture", Kind::object, "texture.info"},
    {"transmission", "transmissionFactor", Kind::number},
    {"transmission", "transmissionTexture", Kind::object, "texture.info"},
    {"volume", "thicknessFactor", Kind::number},
    {"volume", "attenuationDistance", Kind::number},
    {"volume", "attenuationColor", Kind::numbers, {}, 3},
    {"glossiness", "diffuseFactor", Kind::numbers, {}, 4},
    {"glossiness", "diffuseTexture", Kind::object, "texture.info"},
    {"glossiness", "specularFactor", Kind::numbers, {}, 3},
    {"glossiness", "glossinessFactor", Kind::number},
    {"glossiness", "specularGlossinessTexture", Kind::object, "texture.info"},
};

// A JSON path, spelled out only when something is wrong there.
struct Place {
    const Place* parent = nullptr;
    std::string_view name = {};  // empty: an array's item
    size_t index = 0;

    std::string text() const {
        if (!parent) return "";
        std::string before = parent->text();
        if (name.empty()) return fmt::format("{}[{}]", before, index);
        return before.empty() ? std::string(name) : fmt::format("{}.{}", before, name);
    }
};

class StructureCheck {
  public:
    explicit StructureCheck(Document& document) : document_(document) {
        for (const Rule& rule : rules) {
            std::span<const Rule>& rows = rules_of_[rule.owner];
            rows = {rows.empty() ? &rule : rows.data(), rows.size() + 1};
        }
    }

    void check(json& object, std::string_view owner, const Place& place) {
        need(object.is_object(), place, "is not an object");
        for (const Rule& rule : rules_of_[owner]) {
            const auto property = object.find(rule.name);
            const Place at{&place, rule.name};
            if (property != object.end()) {
                check_value(*property, rule, at);
            } else {
                need(!rule.required, at, "is missing");
            }
        }
    }

  private:
    [[noreturn]] void fail(const Place& at, const std::string& reason) {
        const std::string text = at.text();
        document_.fail(text.empty() ? "JSON" : text, reason);
    }

    void need(bool condition, const Place& at, const char* reason) {
        if (!condition) fail(at, reason);
    }

    void check_value(json& value, const Rule& rule, const Place& at) {
        switch (rule.kind) {
            case Kind::boolean:
                return need(value.is_boolean(), at, "is not true or false");
            case Kind::number:
                return check_number(value, at);
            case Kind::string:
                return need(value.is_string(), at, "is not a string");
            case Kind::natural:
                return check_natural(value, uint64_t{1} << 53, at);
            case Kind::small:
                return check_natural(value, (uint64_t{1} << 31) - 1, at);
            case Kind::stride:
                return check_stride(value, at);
            case Kind::choice:
                return check_choice(value, rule.of, at);
            case Kind::index:
                return check_index(value, rule.of, at);
            case Kind::object:
                return check(value, rule.of, at);
            case Kind::dictionary:
                return check_dictionary(value, rule.of, at);
            default:
                return check_array(value, rule, at);
        }
    }

    void check_array(json& value, const Rule& rule, const Place& at) {
        need(value.is_array(), at, "is not an array");
        if (rule.size != 0 && value.size() != rule.size) {
            fail(at, fmt::format("has {} numbers, not {}", value.size(), rule.size));
        }
        for (size_t i = 0; i < value.size(); ++i) {
            const Place item{&at, {}, i};
            switch (rule.kind) {
                case Kind::numbers:
                    check_number(value[i], item);
                    break;
                case Kind::strings:
                    need(value[i].is_string(), item, "is not a string");
                    break;
                case Kind::indices:
                    check_index(value[i], rule.of, item);
                    break;
                case Kind::dictionaries:
                    check_dictionary(value[i], rule.of, item);
                    break;
                default:
                    check(value[i], rule.of, item);
            }
        }
    }

    void check_dictionary(json& value, std::string_view array, const Place& at) {
        need(value.is_object(), at, "is not an object");
        for (auto& [key, item] : value.items()) check_index(item, array, Place{&at, key});
    }

    // Numbers become floats, so they must not overflow one.
    void check_number(const json& value, const Place& at) {
        need(value.is_number(), at, "is not a number");
        need(std::abs(value.get<double>()) <= double{std::numeric_limits<float>::max()}, at,
             "is too large for a float");
    }

    void check_natural(json& value, uint64_t limit, const Place& at) {
        if (value.is_number_float()) {
            const double real = value.get<double>();
            if (real >= 0 && real <= 0x1p53 && real == std::floor(real)) {
                value = static_cast<uint64_t>(real);
            }
        }
        need(value.is_number_unsigned(), at, "is not a non-negative integer");
        if (const auto number = value.get<uint64_t>(); number > limit) {
            fail(at, fmt::format("{} is above {}", number, limit));
        }
    }

    void check_stride(json& value, const Place& at) {
        check_natural(value, 252, at);
        need(value.get<uint64_t>() % 4 == 0, at, "is no multiple of 4");
    }

    void check_choice(json& value, std::string_view words, const Place& at) {
        const bool numeric = words[0] >= '0' && words[0] <= '9';
        if (numeric) {
            check_natural(value, (uint64_t{1} << 31) - 1, at);
        } else {
            need(value.is_string(), at, "is not a string");
        }
        const std::string text = numeric ? value.dump() : value.get<std::string>();
        for (size_t begin = 0; begin < words.size();) {
            const size_t end = std::min(words.find(' ', begin), words.size());
            if (words.substr(begin, end - begin) == text) return;
            begin = end + 1;
        }
        fail(at, fmt::format("{} is not one of: {}", value.dump(), words));
    }

    void check_index(json& value, std::string_view array, const Place& at) {
        check_natural(value, uint64_t{1} << 53, at);
        const size_t size = array_size(array);
        if (const auto number = value.get<uint64_t>(); number >= size) {
            fail(at, fmt::format("{} is out of range: there are {} {}", number, size,
                                 array.substr(array.rfind('/') + 1)));
        }
    }

    size_t array_size(std::string_view pointer) {
        const auto [found, is_new] = sizes_.try_emplace(pointer, 0);
        if (is_new) {
            const json::json_pointer at{std::string(pointer)};
            if (document_.json.contains(at) && document_.json[at].is_array()) {
                found->second = document_.json[at].size();
            }
        }
        return found->second;
    }

    Document& document_;
    std::unordered_map<std::string_view, std::span<const Rule>> rules_of_;
    std::unordered_map<std::string_view, size_t> sizes_;
};

}  // namespace

void check_structure(Document& document) { StructureCheck(document).check(document.json, "", {}); }

}  // namespace sightline
