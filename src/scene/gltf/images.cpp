#include "scene/gltf/images.h"

#include "core/parallel.h"
#include "scene/gltf/uri.h"

#include <fmt/format.h>

#include <cstring>
#include <exception>
#include <string_view>

namespace sightline {
namespace {

using nlohmann::json;

// An image's encoded bytes, in a buffer or read from its URI into `storage`.
struct EncodedImage {
    uint32_t image = none;
    std::string name;
    std::vector<std::byte> storage;
    std::span<const std::byte> bytes;
};

// Basis Universal textures are KTX2 files, with or without the extension KHR_texture_basisu.
bool is_ktx2(std::span<const std::byte> bytes) {
    constexpr std::string_view magic = "\xABKTX 20\xBB\r\n\x1A\n";
    return bytes.size() >= magic.size() &&
           std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

EncodedImage read_encoded(Document& document, uint32_t image, const LoadOptions& options) {
    const json& source = document.list("images")[image];
    const std::string place = fmt::format("images[{}]", image);
    EncodedImage encoded;
    encoded.image = image;
    encoded.name = document.path + ": " + place;
    if (source.contains("bufferView")) {
        encoded.bytes = document.bytes(document.buffer_views[source["bufferView"].get<size_t>()]);
    } else if (source.contains("uri")) {
        encoded.storage = read_uri(document, source["uri"], place + ".uri", options);
        encoded.bytes = encoded.storage;
    } else {
        document.fail(place, "has neither uri nor bufferView");
    }
    return encoded;
}

std::vector<bool> images_of(const Scene& scene, const std::vector<bool>& material_used) {
    std::vector<bool> used(scene.images.size(), false);
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        if (!material_used[i]) continue;
        for_each_texture(scene.materials[i], [&](const TextureRef& ref) {
            used[scene.textures[ref.texture].image] = true;
        });
    }
    return used;
}

void decode_all(std::vector<EncodedImage>& work, const ImageLimits& limits,
                std::vector<Image>& images) {
    std::vector<std::exception_ptr> errors(work.size());
    parallel_for(work.size(), [&](size_t i) {
        try {
            images[work[i].image] = decode_image(work[i].bytes, work[i].name, limits);
            work[i].storage = {};
        } catch (...) {
            errors[i] = std::current_exception();
        }
    });
    for (const std::exception_ptr& error : errors)
        if (error) std::rethrow_exception(error);
}

}  // namespace

void decode_images(Document& document, const std::vector<bool>& material_used,
                   const LoadOptions& options, Scene& scene) {
    scene.images.resize(document.list("images").size());
    const std::vector<bool> used = images_of(scene, material_used);
    std::vector<EncodedImage> work;
    std::vector<bool> undecodable(used.size(), false);
    for (uint32_t i = 0; i < used.size(); ++i) {
        if (!used[i]) continue;
        work.push_back(read_encoded(document, i, options));
        if (is_ktx2(work.back().bytes)) {
            document.warn(fmt::format("images[{}]", i),
                          "KTX2 images cannot be decoded: drawn without");
            undecodable[i] = true;
            work.pop_back();
        }
    }
    for (Material& material : scene.materials) {
        for_each_texture(material, [&](TextureRef& ref) {
            if (undecodable[scene.textures[ref.texture].image]) ref = {};
        });
    }
    if (options.decode_images) decode_all(work, options.images, scene.images);
}

}  // namespace sightline
