#include "output/render_pictures.h"

#include "core/error.h"
#include "intersect/ray_file.h"
#include "output/output_set.h"
#include "output/tile_key.h"

#include <fmt/format.h>

#include <chrono>

namespace sightline {
namespace {

/// Appended to the first picture's path, names the folder of its finished tiles.
constexpr const char* checkpoint_ending = ".tiles";

using Clock = std::chrono::steady_clock;

/// An early end leaves the files as they were. Without a checkpoint, the tiles that are done are
/// written beside them.
std::unique_ptr<OutputSet> render_whole(const RenderCommand& command, const RenderContext& context,
                                        const RenderRun& run, AssetResult& result) {
    auto outputs = std::make_unique<OutputSet>(command.output, command.run.threads, context,
                                               result.intersector);
    result.picture = render(
        context, [&](const Film& band) { outputs->add(band); }, run);
    if (result.picture.tiles_done == 0)
        throw Error(fmt::format("{}: interrupted before the first tile of {}, which is not written",
                                asset_label(command.asset),
                                fmt::join(command.output.pictures, " and ")));
    const std::string& rays = command.output.record_rays;
    if (!run.checkpoint && rays.empty()) return outputs;
    const bool is_complete = result.picture.tiles_done == result.picture.tiles;
    if (run.checkpoint && !is_complete) return nullptr;
    finish_pictures(*outputs, result);
    const auto begin = Clock::now();
    if (!rays.empty() && is_complete) write_rays(rays, result.picture.rays, context.scene);
    result.seconds.write += seconds_since(begin);
    return nullptr;
}

void render_with_checkpoint(const RenderCommand& command, const RenderContext& context,
                            RenderRun run, AssetResult& result) {
    const std::string folder = command.run.tiles.empty()
                                   ? command.output.pictures.at(0) + checkpoint_ending
                                   : command.run.tiles;
    Checkpoint checkpoint(folder, tile_key(command, result.inputs, result.intersector));
    if (checkpoint.foreign_files())
        result.warnings.push_back(
            fmt::format("{}: {} files of tiles belong to another picture (other files, options or "
                        "program version) and are not used",
                        folder, checkpoint.foreign_files()));
    run.checkpoint = &checkpoint;
    if (command.run.part) {
        result.picture = render_part(context, *command.run.part, run);
        return checkpoint.sync();
    }
    const size_t missing = missing_tiles(context.settings, checkpoint);
    if (command.run.merge_parts && missing)
        throw Error(fmt::format("{}: {} tiles are missing; render their parts", folder, missing));
    render_whole(command, context, run, result);
    const bool complete = result.picture.tiles_done == result.picture.tiles;
    complete ? checkpoint.remove() : checkpoint.sync();
}

}  // namespace

std::unique_ptr<OutputSet> render_pictures(const RenderCommand& command,
                                           const RenderContext& context, RenderRun run,
                                           AssetResult& result) {
    const RunOptions& options = command.run;
    if (!options.resume && !options.merge_parts && !options.part)
        return render_whole(command, context, run, result);
    render_with_checkpoint(command, context, std::move(run), result);
    return nullptr;
}

void finish_pictures(OutputSet& outputs, AssetResult& result) {
    const auto begin = Clock::now();
    outputs.finish(result.picture);
    result.preview = outputs.preview();
    result.data_scales = outputs.data_scales();
    result.seconds.write += seconds_since(begin);
}

}  // namespace sightline
