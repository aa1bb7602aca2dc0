#include "scene/gltf/images.h"

#include "core/error.h"
#include "core/hash.h"
#include "core/parallel.h"
#include "image/sniff.h"
#include "scene/gltf/uri.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <limits>
#include <map>
#include <optional>
#include <string_view>

namespace sightline {
namespace {

using nlohmann::json;

// An image's encoded bytes, in a buffer or read from its URI into `storage`.
struct EncodedImage {
    uint32_t image = none;
    std::vector<std::byte> storage;
    std::span<const std::byte> bytes;
};

std::string place_of(uint32_t image) { return fmt::format("images[{}]", image); }

// Basis Universal textures are KTX2 files, with or without the extension KHR_texture_basisu.
bool is_ktx2(std::span<const std::byte> bytes) {
    constexpr std::string_view magic = "\xABKTX 20\xBB\r\n\x1A\n";
    return bytes.size() >= magic.size() &&
           std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

// The images that are to be decoded, and those of the file that turned out to be the same or lost.
struct ImageWork {
    std::vector<EncodedImage> unique;
    std::vector<uint32_t> same_as;  // by image: itself, or an earlier one of equal content
    std::vector<bool> lost;         // by image
};

// Half of the machine's memory, in MiB.
uint64_t default_texture_memory() {
    const auto pages = static_cast<uint64_t>(std::max(sysconf(_SC_PHYS_PAGES), 1L));
    return pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE)) / 2 >> 20;
}

// The sum of the decoded images, which is checked before they are decoded where headers tell it.
class TextureBudget {
  public:
    TextureBudget(const Document& document, const LoadOptions& options)
        : document_(document),
          limit_(options.max_texture_memory ? options.max_texture_memory
                                            : default_texture_memory()) {}

    void charge(uint32_t image, uint64_t bytes) {
        sum_ += std::min(bytes, std::numeric_limits<uint64_t>::max() - sum_);
        const uint64_t mebibytes = (sum_ + (1u << 20) - 1) >> 20;
        if (mebibytes <= limit_) return;
        throw LimitError(fmt::format(
            "{}: {}: with it the decoded textures take {} MiB, more than the limit of {} MiB "
            "(--max-texture-memory)",
            document_.path, place_of(image), mebibytes, limit_));
    }

  private:
    const Document& document_;
    uint64_t limit_, sum_ = 0;
};

// The image's file; empty and reported if there is none.
std::optional<EncodedImage> read_encoded(Document& document, uint32_t image,
                                         const LoadOptions& options) {
    const json& source = document.list("images")[image];
    EncodedImage encoded;
    encoded.image = image;
    if (source.contains("bufferView")) {
        encoded.bytes = document.bytes(document.buffer_views[source["bufferView"].get<size_t>()]);
        return encoded;
    }
    std::string problem = "has neither uri nor bufferView", place = place_of(image);
    if (source.contains("uri")) {
        place += ".uri";
        if (auto bytes = read_uri(document, source["uri"], place, options, problem)) {
            encoded.storage = std::move(*bytes);
            encoded.bytes = encoded.storage;
            return encoded;
        }
    }
    document.report(Fault::missing_texture, place, problem);
    return {};
}

// Reads the used images and finds those of equal content, so that no file is kept or read twice.
ImageWork read_images(Document& document, const std::vector<bool>& used,
                      const LoadOptions& options) {
    ImageWork work;
    work.lost.resize(used.size());
    std::map<std::string_view, uint32_t> by_uri;
    std::multimap<uint64_t, size_t> by_hash;  // to `unique`
    for (uint32_t i = 0; i < used.size(); ++i) {
        work.same_as.push_back(i);
        if (!used[i]) continue;
        const json& source = document.list("images")[i];
        if (source.contains("uri")) {
            const auto [known, is_new] =
                by_uri.try_emplace(source["uri"].get_ref<const std::string&>(), i);
            work.same_as[i] = work.same_as[known->second];
            if (!is_new) continue;
        }
        std::optional<EncodedImage> encoded = read_encoded(document, i, options);
        if (encoded && is_ktx2(encoded->bytes)) {
            document.report(Fault::ktx2_texture, place_of(i));
            encoded.reset();
        }
        if (!encoded) {
            work.lost[i] = true;
            continue;
        }
        const uint64_t hash = hash_bytes(encoded->bytes);
        const auto [begin, end] = by_hash.equal_range(hash);
        const auto equal = std::find_if(begin, end, [&](const auto& entry) {
            return std::ranges::equal(work.unique[entry.second].bytes, encoded->bytes);
        });
        if (equal != end) {
            work.same_as[i] = work.unique[equal->second].image;
            continue;
        }
        by_hash.emplace(hash, work.unique.size());
        work.unique.push_back(std::move(*encoded));
    }
    return work;
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

// Decodes one image; what is wrong with it goes to `problem`.
void decode(EncodedImage& encoded, const Document& document, const LoadOptions& options,
            Image& image, std::string& problem) {
    const std::string place = place_of(encoded.image);
    try {
        image = decode_image(encoded.bytes, place, options.images);
    } catch (const LimitError& error) {
        throw LimitError(document.path + ": " + error.what());
    } catch (const Error& error) {
        problem = error.what();
        if (problem.starts_with(place + ": ")) problem.erase(0, place.size() + 2);
    }
    encoded.storage = {};
}

// Images whose headers tell their size are decoded in parallel, others one after the other.
std::vector<std::string> decode_all(ImageWork& work, const Document& document,
                                    const LoadOptions& options, std::vector<Image>& images) {
    std::vector<std::string> problems(work.unique.size());
    std::vector<std::exception_ptr> errors(work.unique.size());
    TextureBudget budget(document, options);
    std::vector<size_t> known, unknown;
    for (size_t i = 0; i < work.unique.size(); ++i) {
        const uint64_t bytes = decoded_bytes(work.unique[i].bytes);
        (bytes ? known : unknown).push_back(i);
        budget.charge(work.unique[i].image, bytes);
    }
    const auto decode_one = [&](size_t i) {
        EncodedImage& encoded = work.unique[i];
        decode(encoded, document, options, images[encoded.image], problems[i]);
    };
    parallel_for(known.size(), [&](size_t k) {
        try {
            decode_one(known[k]);
        } catch (...) {
            errors[known[k]] = std::current_exception();
        }
    });
    for (const std::exception_ptr& error : errors)
        if (error) std::rethrow_exception(error);
    for (const size_t i : unknown) {
        decode_one(i);
        budget.charge(work.unique[i].image, images[work.unique[i].image].memory());
    }
    return problems;
}

void report_damage(Document& document, uint32_t image, const Image& decoded) {
    if (!decoded.damage) return;
    const Fault fault = *decoded.damage == ImageDamage::png_checksum ? Fault::png_checksum
                        : *decoded.damage == ImageDamage::png_end    ? Fault::png_end
                                                                     : Fault::jpeg_end;
    document.report(fault, place_of(image), decoded.damage_place);
}

void decode_and_report(Document& document, const LoadOptions& options, ImageWork& work,
                       std::vector<Image>& images) {
    const auto problems = decode_all(work, document, options, images);
    for (size_t i = 0; i < problems.size(); ++i) {
        const uint32_t image = work.unique[i].image;
        work.lost[image] = !problems[i].empty();
        if (work.lost[image])
            document.report(Fault::unreadable_texture, place_of(image), problems[i]);
        else
            report_damage(document, image, images[image]);
    }
}

// 8 × 8 squares in magenta and black.
Image checker() {
    constexpr int size = 64, square = 8;
    Image image;
    image.width = image.height = size;
    image.channels = 3;
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            const bool is_magenta = (x / square + y / square) % 2 == 0;
            for (const bool is_lit : {true, false, true})
                image.bytes.push_back(is_magenta && is_lit ? 255 : 0);
        }
    }
    return image;
}

// Removes the references to lost images, or puts checkers in their place.
void replace_lost(const std::vector<bool>& lost, MissingTexture replacement, Scene& scene) {
    for (Material& material : scene.materials) {
        for_each_texture(material, [&](TextureRef& ref) {
            const uint32_t image = scene.textures[ref.texture].image;
            if (!lost[image]) return;
            const bool keeps =
                replacement == MissingTexture::checker && &ref == &material.base_color_texture;
            if (!keeps)
                ref = {};
            else if (scene.images[image].empty())
                scene.images[image] = checker();
        });
    }
}

}  // namespace

void decode_images(Document& document, const std::vector<bool>& material_used,
                   const LoadOptions& options, Scene& scene) {
    scene.images.resize(document.list("images").size());
    const std::vector<bool> used = images_of(scene, material_used);
    ImageWork work = read_images(document, used, options);
    if (options.decode_images) decode_and_report(document, options, work, scene.images);
    for (Texture& texture : scene.textures)
        if (texture.image != none) texture.image = work.same_as[texture.image];
    replace_lost(work.lost, options.missing_texture, scene);
}

void check_images(Document& document, const LoadOptions& options) {
    std::vector<Image> images(document.list("images").size());
    ImageWork work = read_images(document, std::vector<bool>(images.size(), true), options);
    decode_and_report(document, options, work, images);
}

}  // namespace sightline
