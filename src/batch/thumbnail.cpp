#include "batch/thumbnail.h"

#include "core/error.h"
#include "core/hash.h"
#include "image/compare.h"
#include "image/write_image.h"
#include "output/display.h"
#include "output/exr.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr int thumbnail_side = 192;

std::string private_path(const char* subfolder, const std::string& name, const char* extension) {
    return fmt::format("{}/{}/{:016x}{}", private_folder, subfolder, hash_text(name), extension);
}

// Averages square blocks of an 8-bit picture so that it fits. Averages encoded values, as a
// browser does.
Image shrink(const Image& image) {
    const int block = (std::max(image.width, image.height) + thumbnail_side - 1) / thumbnail_side;
    Image small;
    small.width = (image.width + block - 1) / block;
    small.height = (image.height + block - 1) / block;
    small.channels = 3;
    for (int y = 0; y < small.height; ++y)
        for (int x = 0; x < small.width; ++x)
            for (int c = 0; c < 3; ++c) {
                unsigned sum = 0, count = 0;
                for (int v = y * block; v < std::min((y + 1) * block, image.height); ++v)
                    for (int u = x * block; u < std::min((x + 1) * block, image.width); ++u) {
                        const auto pixel =
                            static_cast<size_t>(v) * static_cast<size_t>(image.width) +
                            static_cast<size_t>(u);
                        const int channel = image.channels < 3 ? 0 : c;
                        sum += image.bytes[pixel * static_cast<size_t>(image.channels) +
                                           static_cast<size_t>(channel)];
                        ++count;
                    }
                small.bytes.push_back(static_cast<uint8_t>((sum + count / 2) / count));
            }
    return small;
}

// A picture file of any format as 8-bit display values.
Image read_display(const std::string& path) {
    if (path.ends_with(".exr"))
        return display_picture(read_exr(path), ToneMap::pbr_neutral, 0, false);
    Image image = read_image(path);
    if (image.bytes.empty())
        throw Error(path + ": cannot compare; only 8-bit pictures and EXR are supported");
    return image;
}

}  // namespace

std::string thumbnail_path(const std::string& name) {
    return private_path("thumbnails", name, ".jpg");
}

std::string tiles_path(const std::string& name) { return private_path("tiles", name, ""); }

void write_thumbnail(const std::string& path, const Image& picture) {
    fs::create_directories(fs::path(path).parent_path());
    write_image(path, shrink(picture));
}

Change compare_with_earlier(const Task& task, const std::string& folder, const std::string& current,
                            const std::string& compare_to) {
    Change change;
    if (compare_to.empty()) return change;
    const std::string now = (fs::path(folder) / current).string();
    const std::string before = (fs::path(compare_to) / task.outputs[0]).string();
    if (!fs::exists(before)) {
        change.kind = Change::Kind::added;
        return change;
    }
    try {
        if (hash_file(now) == hash_file(before)) {
            change.kind = Change::Kind::same;
            return change;
        }
        change.kind = Change::Kind::changed;
        const Image earlier = read_display(before);
        change.earlier = private_path("thumbnails", task.name, ".earlier.jpg");
        write_thumbnail((fs::path(folder) / change.earlier).string(), earlier);
        change.flip = compare_images(earlier, read_display(now)).flip_mean;
    } catch (const Error& e) {
        change.kind = Change::Kind::changed;
        change.message = e.what();
    }
    return change;
}

}  // namespace sightline
