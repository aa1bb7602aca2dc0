#include "scene/gltf/images.h"

#include "core/error.h"
#include "core/hash.h"
#include "core/parallel.h"
#include "image/sniff.h"
#include "scene/gltf/build.h"
#include "scene/gltf/document.h"
#include "scene/gltf/uri.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <limits>
#include <map>
#include <numeric>
#include <optional>
#include <string_view>
#include <utility>

namespace sightline {
namespace {

using nlohmann::json;

// An image's encoded bytes, in a buffer or read from its URI into `storage`.
struct EncodedImage {
    uint32_t image = none;
    FileBytes storage;
    std::span<const std::byte> bytes;
};

std::string place_of(uint32_t image) { return fmt::format("images[{}]", image); }

// Basis Universal textures are KTX2 files, with or without the extension KHR_texture_basisu.
bool is_ktx2(std::span<const std::byte> bytes) {
    constexpr std::string_view magic = "\xABKTX 20\xBB\r\n\x1A\n";
    return bytes.size() >= magic.size() &&
           std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

// Half of the machine's memory, in MiB.
uint64_t default_texture_memory() {
    const auto pages = static_cast<uint64_t>(std::max(sysconf(_SC_PHYS_PAGES), 1L));
    return pages * static_cast<uint64_t>(sysconf(_SC_PAGESIZE)) / 2 >> 20;
}

// An image that is to be decoded.
struct Job {
    const EncodedImage* encoded;
    WantedLevel wanted;
    std::string problem;
};

// The sum of the decoded images, which is checked before they are decoded where headers tell it.
class TextureBudget {
  public:
    TextureBudget(const Document& document, const LoadOptions& options)
        : document_(document),
          limit_(options.max_texture_memory ? options.max_texture_memory
                                            : default_texture_memory()) {}

    bool allows(uint64_t bytes) const { return (bytes >> 20) < limit_; }

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

}  // namespace

// The images of a file that are or were in use, and what became of them.
struct ImageWork {
    static constexpr int none_decoded = -1;

    struct Report {
        Fault fault;
        std::string place, detail;
        bool operator==(const Report&) const = default;
    };

    ImageWork(Document& document, const LoadOptions& options);
    bool choose(const std::vector<bool>& in_use, std::vector<Image>& images);
    void decode(std::span<const WantedLevel> wanted, std::vector<Image>& images);

    Document& document;
    const LoadOptions& options;
    std::vector<EncodedImage> unique;
    std::vector<int> decoded;  // of `unique`: the level, or none_decoded
    // Of `unique`: other levels that a picture before has wanted, which one after it may want
    // again. Level 0 is not among them, so that they take a third of the whole image at most.
    std::vector<std::map<int, Image>> kept;
    std::vector<bool> is_used;  // of `unique`
    // By image of the file.
    std::vector<bool> used, is_read, lost;
    std::vector<uint32_t> same_as;  // itself, or another one of equal content
    std::vector<std::vector<Report>> reports;

  private:
    bool take_level(size_t i, int level, Image& image);
    void drop_kept_beyond_limit(std::span<const Job> jobs, uint64_t bytes);
    void report(uint32_t image, Fault fault, const std::string& place, const std::string& detail);
    void report_damage(uint32_t image, const Image& decoded);
    std::optional<EncodedImage> read_encoded(uint32_t image);
    void read(uint32_t image);

    std::map<std::string_view, uint32_t> by_uri_;
    std::multimap<uint64_t, size_t> by_hash_;  // to `unique`
};

ImageWork::ImageWork(Document& the_document, const LoadOptions& the_options)
    : document(the_document),
      options(the_options),
      used(document.list("images").size(), false),
      is_read(used),
      lost(used),
      same_as(used.size()),
      reports(used.size()) {
    std::iota(same_as.begin(), same_as.end(), 0u);
}

// Also for poses that use the image again.
void ImageWork::report(uint32_t image, Fault fault, const std::string& place,
                       const std::string& detail) {
    const Report said{fault, place, detail};
    std::vector<Report>& all = reports[image];
    if (std::ranges::find(all, said) == all.end()) all.push_back(said);
    document.report(fault, place, detail);
}

// The image's file; empty and reported if there is none.
std::optional<EncodedImage> ImageWork::read_encoded(uint32_t image) {
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
    report(image, Fault::missing_texture, place, problem);
    return {};
}

// Reads an image unless it is equal to one that has been read.
void ImageWork::read(uint32_t image) {
    const json& source = document.list("images")[image];
    if (source.contains("uri")) {
        const auto [known, is_new] =
            by_uri_.try_emplace(source["uri"].get_ref<const std::string&>(), image);
        same_as[image] = same_as[known->second];
        if (!is_new) return;
    }
    std::optional<EncodedImage> encoded = read_encoded(image);
    if (encoded && is_ktx2(encoded->bytes)) {
        report(image, Fault::ktx2_texture, place_of(image), "");
        encoded.reset();
    }
    if (!encoded) {
        lost[image] = true;
        return;
    }
    const uint64_t hash = hash_bytes(encoded->bytes);
    const auto [begin, end] = by_hash_.equal_range(hash);
    const auto equal = std::find_if(begin, end, [&](const auto& entry) {
        return std::ranges::equal(unique[entry.second].bytes, encoded->bytes);
    });
    if (equal != end) {
        same_as[image] = unique[equal->second].image;
        return;
    }
    by_hash_.emplace(hash, unique.size());
    unique.push_back(std::move(*encoded));
    decoded.push_back(none_decoded);
    kept.emplace_back();
}

// Reads the images in use that have not been read, and empties the others. Returns whether that
// changes anything. Repeats what has been reported of those in use.
bool ImageWork::choose(const std::vector<bool>& in_use, std::vector<Image>& images) {
    for (uint32_t i = 0; i < in_use.size(); ++i)
        if (in_use[i] && is_read[i])
            for (const auto& [fault, place, detail] : reports[same_as[i]])
                document.report(fault, place, detail);
    if (in_use == used) return false;
    used = in_use;
    for (uint32_t i = 0; i < used.size(); ++i) {
        if (!used[i] || is_read[i]) continue;
        read(i);
        is_read[i] = true;
    }
    std::vector<bool> stands_for_used(used.size(), false);
    for (uint32_t i = 0; i < used.size(); ++i)
        if (used[i]) stands_for_used[same_as[i]] = true;
    is_used.clear();
    for (size_t i = 0; i < unique.size(); ++i) {
        is_used.push_back(stands_for_used[unique[i].image]);
        if (is_used[i]) continue;
        images[unique[i].image] = {};
        decoded[i] = none_decoded;
        kept[i].clear();
    }
    return true;
}

namespace {

// The images of the materials in use, as the file has these.
std::vector<bool> images_of(const ScenePoser& poser, const Scene& scene) {
    std::vector<bool> used(scene.images.size(), false);
    const std::vector<bool> material_used = used_materials(scene);
    for (size_t i = 0; i < material_used.size(); ++i) {
        if (!material_used[i]) continue;
        for_each_texture(poser.materials()[i], [&](const TextureRef& ref) {
            used[poser.textures()[ref.texture].image] = true;
        });
    }
    return used;
}

// Decodes one image; what is wrong with it goes to `problem`.
void decode_one(const EncodedImage& encoded, const Document& document, const LoadOptions& options,
                const WantedLevel& wanted, Image& image, std::string& problem) {
    const std::string place = place_of(encoded.image);
    try {
        image = decode_image(encoded.bytes, place, options.images, wanted);
    } catch (const LimitError& error) {
        throw LimitError(document.path + ": " + error.what());
    } catch (const Error& error) {
        problem = error.what();
        if (problem.starts_with(place + ": ")) problem.erase(0, place.size() + 2);
    }
}

// Images whose headers tell their size are decoded in parallel, others one after the other.
// `bytes_before`: of the images that stay.
void decode_all(std::vector<Job>& jobs, uint64_t bytes_before, const Document& document,
                const LoadOptions& options, std::vector<Image>& images) {
    std::vector<std::exception_ptr> errors(jobs.size());
    TextureBudget budget(document, options);
    std::vector<size_t> known, unknown;
    for (size_t i = 0; i < jobs.size(); ++i) {
        const uint64_t bytes = decoded_bytes(jobs[i].encoded->bytes, jobs[i].wanted.level);
        (bytes ? known : unknown).push_back(i);
        budget.charge(jobs[i].encoded->image, bytes + std::exchange(bytes_before, 0));
    }
    const auto run = [&](size_t i) {
        auto& [encoded, wanted, problem] = jobs[i];
        decode_one(*encoded, document, options, wanted, images[encoded->image], problem);
    };
    parallel_for(known.size(), [&](size_t k) {
        try {
            run(known[k]);
        } catch (...) {
            errors[known[k]] = std::current_exception();
        }
    });
    for (const std::exception_ptr& error : errors)
        if (error) std::rethrow_exception(error);
    for (const size_t i : unknown) {
        run(i);
        budget.charge(jobs[i].encoded->image, images[jobs[i].encoded->image].memory());
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

// What the document has recorded since the scene was read.
void copy_reports(const Document& document, Scene& scene) {
    scene.warnings = document.warnings.lines();
    scene.faults = document.faults;
    scene.fault_count = document.fault_count;
    scene.files = document.files;
    scene.content_hash = document.content_hash;
}

}  // namespace

void ImageWork::report_damage(uint32_t image, const Image& read) {
    if (!read.damage) return;
    const Fault fault = *read.damage == ImageDamage::png_checksum ? Fault::png_checksum
                        : *read.damage == ImageDamage::png_end    ? Fault::png_end
                                                                  : Fault::jpeg_end;
    report(image, fault, place_of(image), read.damage_place);
}

// Whether the image has this level or a kept one took its place; if not, it is empty.
bool ImageWork::take_level(size_t i, int level, Image& image) {
    if (decoded[i] == level) return true;
    if (decoded[i] > 0) kept[i].emplace(decoded[i], std::move(image));
    image = {};
    auto found = kept[i].extract(level);
    if (!found) return false;
    image = std::move(found.mapped());
    decoded[i] = level;
    return true;
}

void ImageWork::drop_kept_beyond_limit(std::span<const Job> jobs, uint64_t bytes) {
    for (const Job& job : jobs) bytes += decoded_bytes(job.encoded->bytes, job.wanted.level);
    for (const auto& levels : kept)
        for (const auto& [level, image] : levels) bytes += image.memory();
    if (TextureBudget(document, options).allows(bytes)) return;
    for (auto& levels : kept) levels.clear();
}

// Reports what is lost or damaged.
void ImageWork::decode(std::span<const WantedLevel> wanted, std::vector<Image>& images) {
    std::vector<Job> jobs;
    std::vector<size_t> which;  // into `unique`
    uint64_t bytes_before = 0;
    for (size_t i = 0; i < unique.size(); ++i) {
        const EncodedImage& encoded = unique[i];
        const WantedLevel level = wanted.empty() ? WantedLevel{} : wanted[encoded.image];
        if (lost[encoded.image] || !is_used[i]) continue;
        if (take_level(i, level.level, images[encoded.image])) {
            bytes_before += images[encoded.image].memory();
            continue;
        }
        jobs.push_back({&encoded, level, {}});
        which.push_back(i);
    }
    drop_kept_beyond_limit(jobs, bytes_before);
    decode_all(jobs, bytes_before, document, options, images);
    for (size_t k = 0; k < jobs.size(); ++k) {
        const uint32_t image = jobs[k].encoded->image;
        const bool is_first = decoded[which[k]] == none_decoded;
        decoded[which[k]] = jobs[k].wanted.level;
        lost[image] = !jobs[k].problem.empty();
        if (lost[image])
            report(image, Fault::unreadable_texture, place_of(image), jobs[k].problem);
        else if (is_first)
            report_damage(image, images[image]);
    }
}

GltfImages::GltfImages(Document& document, const LoadOptions& options)
    : document_(document),
      options_(options),
      work_(std::make_unique<ImageWork>(document, options)) {}

GltfImages::~GltfImages() = default;

bool GltfImages::choose(const ScenePoser& poser, Scene& scene) {
    scene.images.resize(work_->used.size());
    const bool has_changed = work_->choose(images_of(poser, scene), scene.images);
    if (has_changed) {
        scene.textures = poser.textures();
        scene.materials = poser.materials();
        for (Texture& texture : scene.textures)
            if (texture.image != none) texture.image = work_->same_as[texture.image];
        replace_lost(scene);
    }
    copy_reports(document_, scene);
    return has_changed;
}

void GltfImages::free_buffers() {
    std::vector<const std::byte*> starts;
    for (const EncodedImage& image : work_->unique) starts.push_back(image.bytes.data());
    std::ranges::sort(starts);
    document_.buffers.clear();
    std::erase_if(document_.storage, [&](const FileBytes& bytes) {
        const auto first = std::ranges::lower_bound(starts, bytes.data());
        return first == starts.end() || *first >= bytes.data() + bytes.size();
    });
}

std::vector<std::array<int, 2>> GltfImages::sizes() const {
    std::vector<std::array<int, 2>> sizes(work_->lost.size(), {0, 0});
    for (size_t i = 0; i < work_->unique.size(); ++i)
        if (work_->is_used[i])
            sizes[work_->unique[i].image] = byte_image_size(work_->unique[i].bytes);
    return sizes;
}

void GltfImages::decode(std::span<const WantedLevel> wanted, Scene& scene) {
    work_->decode(wanted, scene.images);
    replace_lost(scene);
    copy_reports(document_, scene);
}

// Removes the references to lost images, or puts checkers in their place.
void GltfImages::replace_lost(Scene& scene) {
    for (Material& material : scene.materials) {
        for_each_texture(material, [&](TextureRef& ref) {
            const uint32_t image = scene.textures[ref.texture].image;
            if (!work_->lost[image]) return;
            const bool keeps = options_.missing_texture == MissingTexture::checker &&
                               &ref == &material.base_color_texture;
            if (!keeps)
                ref = {};
            else if (scene.images[image].empty())
                scene.images[image] = checker();
        });
    }
}

void check_images(Document& document, const LoadOptions& options) {
    std::vector<Image> images(document.list("images").size());
    ImageWork work(document, options);
    work.choose(std::vector<bool>(images.size(), true), images);
    work.decode({}, images);
}

}  // namespace sightline
