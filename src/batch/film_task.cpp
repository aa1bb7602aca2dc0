#include "batch/film_task.h"

#include "batch/frame_key.h"
#include "core/error.h"
#include "intersect/embree/embree.h"
#include "output/movie.h"
#include "output/movie_frames.h"
#include "output/output_folder.h"

#include <algorithm>
#include <filesystem>
#include <future>
#include <span>
#include <string>
#include <utility>

namespace sightline {
namespace {

namespace fs = std::filesystem;

double fps_of(const Task& task) { return std::stod(task.film.at("fps")); }

// Adds what a further frame has told to the result of the first.
void add_frame(const AssetResult& frame, AssetResult& all) {
    all.seconds.add(frame.seconds);
    all.picture.counters.add(frame.picture.counters);
    const bool is_blank = frame.content != PictureContent::something;
    if (!is_blank && all.content != PictureContent::something) {
        all.content = PictureContent::something;
        all.warnings.pop_back();  // why the frames before are blank
    }
    for (size_t i = 0; i + is_blank < frame.warnings.size(); ++i)
        if (std::ranges::find(all.warnings, frame.warnings[i]) == all.warnings.end())
            all.warnings.insert(all.warnings.begin(), frame.warnings[i]);
}

/// The frames of a film: each is written while the next is rendered.
class Frames {
  public:
    Frames(MovieFrames& kept, const std::vector<PictureRequest>& requests, std::string isa)
        : kept_(kept), requests_(requests), isa_(std::move(isa)) {}

    /// Whether an earlier attempt has kept the frame. The first is made in any case: it tells what
    /// was read.
    bool has(size_t frame) {
        if (frame == 1) finish();
        return frame > 0 && kept_.has(frame, key(frame, result_.inputs), note_);
    }

    /// Begins to write a frame that is rendered, once the one before is written. Throws Error.
    void add(size_t frame, RenderedPicture picture) {
        std::string note = std::exchange(note_, {});
        finish();
        frame_ = frame;
        frame_note_ = std::move(note);
        writing_ = write_beside(std::move(picture));
    }

    /// Keeps the frame that is being written. Throws Error.
    void finish() {
        if (!writing_.valid()) return;
        AssetResult frame = writing_.get();
        kept_.keep(frame_, key(frame_, frame.inputs));
        if (!frame_note_.empty()) frame.warnings.insert(frame.warnings.begin(), frame_note_);
        frame_ == 0 ? void(result_ = std::move(frame)) : add_frame(frame, result_);
    }

    /// Of the first frame, with what the others have told.
    AssetResult result() && { return std::move(result_); }

  private:
    uint64_t key(size_t frame, std::span<const SourceFile> inputs) const {
        return frame_key(requests_[frame].settings, inputs, isa_);
    }

    MovieFrames& kept_;
    const std::vector<PictureRequest>& requests_;
    std::string isa_, note_;  // of the last frame asked for
    AssetResult result_;
    size_t frame_ = 0;  // that is being written
    std::string frame_note_;
    std::future<AssetResult> writing_;
};

}  // namespace

std::vector<PictureRequest> film_frames(const Task& task) {
    RenderSpec spec;
    spec.settings = task.settings;
    spec.use_file_cameras = true;  // the settings have a camera if it is another
    const auto turntable = task.film.find("turntable");
    if (turntable != task.film.end())
        spec.turntable = parse_ring(turntable->second);
    else
        spec.frames = parse_frames(task.film.at("frames"), fps_of(task));
    return pictures_of(spec);
}

AssetResult make_film(const WorkerRequest& request, const ParseSettings& parse,
                      const RenderCommand& common, const std::vector<std::string>& files,
                      const RenderPicture& render) {
    const Task& task = request.task;
    const fs::path place = fs::path(request.folder) / private_folder / "frames" / task.name;
    fs::create_directories(place.parent_path());
    MovieFrames kept(place.string(), true);
    kept.make_folder();
    const std::vector<PictureRequest> requests = film_frames(task);
    Frames frames(kept, requests, embree_isa(common.engine.isa));
    try {
        for (size_t i = 0; i < requests.size(); ++i) {
            if (frames.has(i)) continue;
            RenderCommand command = parse(task.asset, requests[i].settings);
            command.run.threads = common.run.threads;
            command.output.destinations = common.output.destinations;
            command.output.pictures = {kept.path(i)};
            command.output.preview = i == 0;
            frames.add(i, render(command));
        }
    } catch (const Error&) {
        frames.finish();  // so that a later attempt finds it
        throw;
    }
    frames.finish();
    for (const std::string& file : files)
        write_movie(file, kept.files(), movie_options(common, fps_of(task)), kept.folder());
    kept.remove();
    return std::move(frames).result();
}

}  // namespace sightline
