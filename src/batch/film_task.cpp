#include "batch/film_task.h"

#include "batch/frame_key.h"
#include "intersect/embree/embree.h"
#include "output/movie.h"
#include "output/movie_frames.h"
#include "output/output_folder.h"

#include <algorithm>
#include <filesystem>
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
    const std::vector<PictureRequest> frames = film_frames(task);
    const std::string isa = embree_isa(common.engine.isa);
    AssetResult result;
    for (size_t i = 0; i < frames.size(); ++i) {
        const Settings& settings = frames[i].settings;
        std::string note;
        // The first is rendered in any case: it tells what was read.
        if (i > 0 && kept.has(i, frame_key(settings, result.inputs, isa), note)) continue;
        RenderCommand command = parse(task.asset, settings);
        command.run.threads = common.run.threads;
        command.output.destinations = common.output.destinations;
        command.output.pictures = {kept.path(i)};
        command.output.preview = i == 0;
        AssetResult frame = render(command);
        kept.keep(i, frame_key(settings, frame.inputs, isa));
        if (!note.empty()) frame.warnings.insert(frame.warnings.begin(), std::move(note));
        i == 0 ? void(result = std::move(frame)) : add_frame(frame, result);
    }
    for (const std::string& file : files)
        write_movie(file, kept.files(), movie_options(common, fps_of(task)), kept.folder());
    kept.remove();
    return result;
}

}  // namespace sightline
