#include "output/movie_frames.h"

#include "core/error.h"
#include "core/files.h"
#include "image/image.h"
#include "output/movie.h"
#include "output/output_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <system_error>

namespace sightline {
namespace {

namespace fs = std::filesystem;

// Whether the name is one that frames get: digits, perhaps a key, ".png".
bool is_frame(const std::string& name) {
    if (!name.ends_with(".png")) return false;
    const std::string stem = name.substr(0, name.size() - 4);
    const size_t dash = stem.find('-');
    const auto all = [](const std::string& text, int (*kind)(int)) {
        return !text.empty() &&
               std::ranges::all_of(text, [&](unsigned char c) { return kind(c) != 0; });
    };
    if (!all(stem.substr(0, dash), std::isdigit)) return false;
    return dash == std::string::npos ||
           (stem.size() == dash + 17 && all(stem.substr(dash + 1), std::isxdigit));
}

// What makes the file unfit as a frame, after its name; else "".
std::string damage_of(const std::string& path) {
    try {
        const Image frame = read_image(path, {max_movie_pixels, max_frame_bytes});
        return frame.damage ? fmt::format("{}: {}", path, frame.damage_place) : "";
    } catch (const Error& e) {
        return e.what();
    }
}

}  // namespace

MovieFrames::MovieFrames(const std::string& path, bool use_earlier)
    : folder_(write_target(path) + ".frames"), use_earlier_(use_earlier) {}

MovieFrames::~MovieFrames() {
    std::error_code ignored;
    fs::remove(folder_, ignored);  // fails if there is anything in it
}

void MovieFrames::make_folder() const {
    std::error_code ignored;
    fs::create_directory(folder_, ignored);
    if (!fs::is_directory(folder_, ignored))
        throw Error(folder_ + ": cannot make this folder for finished frames");
}

std::string MovieFrames::path(size_t frame) const {
    return (fs::path(folder_) / fmt::format("{:06}.png", frame)).string();
}

std::string MovieFrames::name(size_t frame, uint64_t key) const {
    return (fs::path(folder_) / fmt::format("{:06}-{:016x}.png", frame, key)).string();
}

void MovieFrames::keep(size_t frame, uint64_t key) {
    const std::string kept = name(frame, key);
    std::error_code error;
    fs::rename(path(frame), kept, error);
    if (error) throw Error(fmt::format("{}: cannot write: {}", kept, error.message()));
    files_.resize(std::max(files_.size(), frame + 1));
    files_[frame] = kept;
}

bool MovieFrames::has(size_t frame, uint64_t key, std::string& note) {
    const std::string kept = name(frame, key);
    std::error_code ignored;
    if (!use_earlier_ || !fs::is_regular_file(kept, ignored)) return false;
    if (const std::string damage = damage_of(kept); !damage.empty()) {
        fs::remove(kept, ignored);
        note = damage + ": this kept frame is damaged and is rendered again";
        return false;
    }
    files_.resize(std::max(files_.size(), frame + 1));
    files_[frame] = kept;
    return true;
}

void MovieFrames::drop(size_t frame) const {
    std::error_code ignored;
    fs::remove(path(frame), ignored);
    fs::remove(partial_path(path(frame)), ignored);
}

std::vector<std::string> MovieFrames::files() const {
    std::vector<std::string> found;
    for (const std::string& file : files_)
        if (!file.empty()) found.push_back(file);
    return found;
}

void MovieFrames::remove() {
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(folder_, ignored))
        if (is_frame(entry.path().filename().string())) fs::remove(entry.path(), ignored);
    files_.clear();
    fs::remove(folder_, ignored);
}

}  // namespace sightline
