#include "output/movie.h"

#include "core/error.h"
#include "core/files.h"
#include "core/progress.h"
#include "core/run_program.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <iterator>
#include <vector>

namespace sightline {
namespace {

namespace fs = std::filesystem;

using Words = std::vector<std::string>;

struct MovieFormat {
    const char* ending;
    const char* encoder;  // ffmpeg's name
    const char* codec;    // for messages
    bool alpha;           // keeps transparency
    bool even;            // needs an even width and height
    int max_side;         // pixels
    double max_fps;
};

constexpr MovieFormat formats[] = {
    {".mp4", "libx264", "H.264", false, true, 16384, 1000},
    {".webm", "libvpx-vp9", "VP9", true, false, 16384, 1000},
    // Times are in hundredths of a second, and many programs take 1 for 10.
    {".gif", "gif", "GIF", true, false, 65535, 50},
    {".webp", "libwebp_anim", "animated WebP", true, false, 16383, 1000},
};

const MovieFormat* find_format(const std::string& path) {
    const std::string ending = extension_of(path);
    const auto* found = std::ranges::find(formats, ending, &MovieFormat::ending);
    return found == std::end(formats) ? nullptr : found;
}

const MovieFormat& format_of(const std::string& path) {
    if (const MovieFormat* format = find_format(path)) return *format;
    throw Error(path + ": is not a film: .mp4 .webm .gif .webp");
}

// The conversion of sRGB's code values to the video standard's luma and chroma.
Words video_color(bool alpha) {
    return {"-vf",
            fmt::format("scale=out_color_matrix=bt709:out_range=tv:"
                        "flags=bicubic+accurate_rnd+full_chroma_int+bitexact,format={}",
                        alpha ? "yuva420p" : "yuv420p"),
            "-color_range",
            "tv",
            "-colorspace",
            "bt709",
            "-color_primaries",
            "bt709",
            "-color_trc",
            "iec61966-2-1"};
}

Words encoding_of(const std::string& ending, const MovieOptions& options) {
    Words words;
    const auto add = [&](const Words& more) {
        words.insert(words.end(), more.begin(), more.end());
    };
    if (ending == ".mp4") {
        add(video_color(false));
        add({"-crf", "16", "-preset", "medium", "-movflags", "+faststart"});
    } else if (ending == ".webm") {
        add(video_color(options.alpha));
        add({"-crf", "20", "-b:v", "0", "-deadline", "good", "-cpu-used", "2"});
        if (options.alpha) add({"-auto-alt-ref", "0"});
    } else if (ending == ".webp") {
        add({"-pix_fmt", options.alpha ? "bgra" : "bgr0", "-quality", "90", "-loop", "0"});
    } else {
        add({"-lavfi",
             "[0:v][1:v]paletteuse=dither=sierra2_4a:diff_mode=rectangle:alpha_threshold=128",
             "-loop", "0"});
    }
    return words;
}

std::string ffmpeg_path() {
    std::string path = find_program("ffmpeg");
    if (path.empty())
        throw Error(
            "films need the ffmpeg program, which is not installed; in Debian: apt install ffmpeg");
    return path;
}

// One thread, no times and no names of versions, so that the same frames give the same bytes.
Words repeatable(const Words& words) {
    Words all = words;
    for (const char* word : {"-an", "-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v",
                             "+bitexact", "-threads", "1"})
        all.emplace_back(word);
    return all;
}

class Encoder {
  public:
    Encoder(const std::string& path, std::span<const std::string> frames,
            const MovieOptions& options, std::stop_token stop)
        : path_(path), frames_(frames), options_(options), stop_(std::move(stop)) {}

    // False after a stop request.
    bool run(const Words& inputs, const Words& outputs) const {
        Words command = {ffmpeg_path(), "-nostdin", "-hide_banner", "-loglevel", "error",
                         "-xerror",     "-y"};
        // All is read from a pipe: names of files would be patterns.
        for (const char* word : {"-threads", "1", "-f", "image2pipe", "-c:v", "png", "-framerate"})
            command.emplace_back(word);
        command.push_back(fmt::format("{}", options_.fps));
        command.insert(command.end(), {"-i", "pipe:0"});
        command.insert(command.end(), inputs.begin(), inputs.end());
        command.insert(command.end(), outputs.begin(), outputs.end());
        size_t next = 0;
        Progress progress("film", {path_}, frames_.size(), options_.show_progress);
        const auto input = [&]() -> FileBytes {
            if (next > 0) progress.advance();
            if (next == frames_.size()) return {};
            return read_file(frames_[next++], max_frame_bytes);
        };
        const ProgramEnd end = run_program(command, input, stop_);
        if (stop_.stop_requested()) return false;
        if (end.succeeded() && next == frames_.size()) return true;
        const std::string reason = last_line(end.errors);
        throw Error(fmt::format("{}: ffmpeg ended with {}{}{}", path_, end.how,
                                reason.empty() ? "" : ": ", reason));
    }

  private:
    const std::string& path_;
    std::span<const std::string> frames_;
    const MovieOptions& options_;
    std::stop_token stop_;
};

// A file that is removed unless it has been moved elsewhere.
struct ScratchFile {
    std::string path;
    explicit ScratchFile(const fs::path& file) : path(file.string()) {}
    ~ScratchFile() {
        std::error_code ignored;
        fs::remove(path, ignored);
    }
    ScratchFile(const ScratchFile&) = delete;
    // As ffmpeg takes it: a colon would be the end of a protocol's name.
    std::string url() const { return "file:" + path; }
};

}  // namespace

bool is_movie(const std::string& path) {
    return find_format(path) && extension_of(path) != ".webp";
}

bool can_be_movie(const std::string& path) { return find_format(path) != nullptr; }

MovieOptions movie_options(const RenderCommand& command, double fps) {
    const PixelRect window = window_of(command.settings);
    return {window.width(), window.height(), fps,
            command.light.background == Background::transparent, command.run.show_progress};
}

std::string movie_problem(const std::string& path, const MovieOptions& options) {
    const MovieFormat& format = format_of(path);
    const auto [width, height, fps, alpha, shows] = options;
    if (alpha && !format.alpha)
        return fmt::format(
            "--background transparent: {} cannot hold transparency; use .webm, .webp or .gif, or "
            "another background",
            path);
    if (format.even && (width % 2 != 0 || height % 2 != 0))
        return fmt::format(
            "{}: {} needs an even width and height, and the pictures have {}x{}; use {}x{}, or "
            ".webm, .webp or .gif",
            path, format.codec, width, height, width + width % 2, height + height % 2);
    const auto pixels = static_cast<uint64_t>(width) * static_cast<uint64_t>(height);
    if (std::max(width, height) > format.max_side || pixels > max_movie_pixels)
        return fmt::format("{}: {}x{} is more than {} holds, {} pixels a side and {} in all", path,
                           width, height, format.codec, format.max_side, max_movie_pixels);
    if (fps > format.max_fps)
        return fmt::format("{}: {} has at most {} frames per second, not {}", path, format.codec,
                           format.max_fps, fps);
    return "";
}

void check_ffmpeg(std::span<const std::string> movies) {
    const ProgramEnd end = run_program({ffmpeg_path(), "-hide_banner", "-encoders"});
    for (const std::string& movie : movies) {
        const MovieFormat& format = format_of(movie);
        if (end.output.find(fmt::format(" {} ", format.encoder)) == std::string::npos)
            throw Error(
                fmt::format("{}: this ffmpeg cannot write {}: it has no encoder {}; use another "
                            "ending: .mp4 .webm .gif .webp",
                            movie, format.codec, format.encoder));
    }
}

bool write_movie(const std::string& path, std::span<const std::string> frames,
                 const MovieOptions& options, const std::string& folder, std::stop_token stop) {
    const MovieFormat& format = format_of(path);
    const Encoder encoder(path, frames, options, std::move(stop));
    const ScratchFile movie(fs::path(folder) / (std::string("film") + format.ending));
    const ScratchFile palette(fs::path(folder) / "palette.png");
    Words inputs;
    if (extension_of(path) == ".gif") {
        const std::string filter =
            fmt::format("palettegen=stats_mode=full:reserve_transparent={}", int{options.alpha});
        if (!encoder.run(
                {}, repeatable({"-vf", filter, "-update", "1", "-frames:v", "1", palette.url()})))
            return false;
        inputs = {"-i", palette.url()};
    }
    Words outputs = repeatable(encoding_of(format.ending, options));
    outputs.insert(outputs.end(), {"-c:v", format.encoder, movie.url()});
    if (!encoder.run(inputs, outputs)) return false;
    sync_to_disk({movie.path});
    if (std::rename(movie.path.c_str(), write_target(path).c_str()) != 0)
        throw Error(fmt::format("{}: cannot write: {}", path, std::strerror(errno)));
    return true;
}

}  // namespace sightline
