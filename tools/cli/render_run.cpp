#include "render_run.h"

#include "core/error.h"
#include "core/files.h"
#include "core/message.h"
#include "core/text.h"
#include "output/output_set.h"
#include "output/statistics.h"

#include <fmt/format.h>

#include <chrono>
#include <future>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace sightline {
namespace {

std::string explain(const Needs& needs) {
    std::string text;
    for (const Decision& decision : needs.report)
        text += fmt::format("{:<20} {:<8} {}{}\n", decision.name, decision.choice, decision.because,
                            decision.saves.empty() ? "" : "; saves " + decision.saves);
    return text;
}

// Which camera and which light the picture has, and why.
void print_choices(const Needs& needs) {
    std::string line;
    for (const Decision& decision : needs.report)
        if (decision.name == "camera" || decision.name == "light")
            line += fmt::format("{}{}: {} ({})", line.empty() ? "" : "; ", decision.name,
                                decision.choice, decision.because);
    print_message("{}\n", printable(line));
}

void print_times(const StageTimes& s) {
    print_message("{:.2f} s: load {:.2f}, build {:.2f}, render {:.2f}, write {:.2f}\n", s.total,
                  s.load(), s.build + s.prepare, s.render, s.write);
}

std::string describe_interruption(bool is_alone, const RenderCommand& command,
                                  const AssetResult& result) {
    const RunOptions& r = command.run;
    std::string where = "kept; repeat the command to continue";
    if (!r.resume && !r.merge_parts && !r.part) {
        where = "in " + partial_path(command.output.pictures[0]);
        if (is_alone) where += "; with --resume, a render continues where it was interrupted";
    }
    return fmt::format("{}: interrupted; {} of {} tiles are {}", asset_label(command.asset),
                       result.picture.tiles_done, result.picture.tiles, where);
}

/// The picture with what its render has told.
PosedPicture posed(PosedPicture picture, const OutputOptions& output, const AssetResult& result) {
    picture.files = output.pictures;
    picture.pose = result.pose;
    picture.data_scales = result.data_scales;
    auto layer = output.data.begin();
    if (!output.data.empty())
        for (std::string& file : data_paths(output.pictures.at(0), output.data))
            picture.data_files.emplace(*layer++, std::move(file));
    return picture;
}

/// Renders the pictures of a plan one after the other, from one asset in memory. Each is written
/// while the next is rendered; what there is to say of it is said when it is written.
class PlanRun {
  public:
    PlanRun(RenderPlan& plan, const ReportOptions& options, std::stop_token stop)
        : options_(options), plan_(plan), movies_(plan.movies), stop_(std::move(stop)) {}

    /// Throws Error.
    void run() {
        const size_t count = plan_.commands.size();
        // For programs only: the bar of each picture says how many there are.
        if (count > 1) pictures_.emplace("pictures", ProgressName{}, count, false);
        try {
            load(0);
            for (const RenderCommand& command : plan_.commands) asset_->check_camera(command);
            for (size_t i = 0; i < count; ++i) {
                if (stop_.stop_requested()) {
                    finish();
                    throw interruption();
                }
                render(i);
                if (movies_.ends_film(i)) write_film(i);
            }
            finish();
            if (!plan_.poses.path.empty()) write_poses();
        } catch (const Error& e) {
            if (!plan_.only_movies || !options_.names) movies_.discard();
            const std::string state = describe_state(count);
            if (state.empty()) throw;
            throw Error(e.what() + state);
        }
    }

  private:
    void load(size_t i) {
        const RenderCommand& command = plan_.commands[i];
        if (asset_ && asset_->has_loaded(command)) return;
        asset_.reset();  // before the next is read: there is memory for one
        const bool several = plan_.commands.size() > 1;
        asset_.emplace(command, several ? Asset::Pictures::several : Asset::Pictures::one);
    }

    void render(size_t i) {
        std::string note;
        if (movies_.has_kept(i, asset_->inputs(), note)) return count_finished();
        if (!note.empty()) {
            finish();
            print_message("note: {}\n", printable(note));
        }
        RenderedPicture picture = render_unwritten(i);
        finish();
        RenderCommand command = reported_command(i);
        const auto write_statistics = [command](const AssetResult& result) {
            if (!command.output.stats.empty())
                write_text(command.output.stats, statistics_json(command, result));
        };
        in_work_ = i;
        writing_ = write_beside(std::move(picture), write_statistics);
    }

    RenderedPicture render_unwritten(size_t i) {
        try {
            load(i);
            return asset_->render_unwritten(plan_.commands[i], stop_);
        } catch (...) {
            finish();
            if (plan_.only_movies && stop_.stop_requested()) throw interruption();
            throw;
        }
    }

    /// Waits until the picture in work is written, and reports it.
    void finish() {
        if (!writing_.valid()) return;
        const size_t i = in_work_;
        try {
            const AssetResult result = writing_.get();
            report(i, result);
            if (result.interrupted)
                throw Error(describe_interruption(!plan_.several, plan_.commands[i], result));
            movies_.keep(i, result.inputs);
        } catch (const Error&) {
            movies_.drop(i);
            if (plan_.only_movies && stop_.stop_requested()) throw interruption();
            throw;
        }
        count_finished();
    }

    void count_finished() {
        ++finished_;
        if (pictures_) pictures_->advance();
    }

    /// The command of a picture without the frame of a film.
    RenderCommand reported_command(size_t i) const {
        RenderCommand command = plan_.commands[i];
        if (!movies_.empty()) command.output.pictures.pop_back();
        return command;
    }

    /// Prints results, unless standard output takes a picture.
    void print(const std::string& text) const {
        if (!options_.names) return;
        fmt::print("{}", text);
    }

    /// Prints what there is to say of a picture, except a warning that an earlier one had.
    void report(size_t i, const AssetResult& result) {
        const RenderCommand command = reported_command(i);
        const bool is_blank = result.content != PictureContent::something;
        for (const std::string& warning : result.warnings) {
            std::string place = asset_label(command.asset);
            if (plan_.several && is_blank && &warning == &result.warnings.back())
                place +=
                    ": " + (plan_.only_movies ? movies_.describe(i) : command.output.pictures[0]);
            const std::string line = printable(place + ": " + warning);
            if (warned_.insert(line).second) print_message("warning: {}\n", line);
        }
        plan_.posed[i] = posed(std::move(plan_.posed[i]), command.output, result);
        const bool is_told = plan_.only_movies && std::exchange(is_first_told_, true);
        if (options_.explain && !is_told) print(explain(result.needs));
        if (options_.quiet) return;
        if (!is_told) print_choices(result.needs);
        if (plan_.only_movies) return frame_seconds_.add(result.seconds);
        for (const std::string& picture : command.output.pictures)
            if (!command.run.part && !result.interrupted) print(picture + "\n");
        print_times(result.seconds);
    }

    void write_poses() const {
        const auto& [path, form] = plan_.poses;
        write_text(path, poses_json(path, form, asset_->scene(), plan_.posed));
        if (!options_.quiet) print(path + "\n");
    }

    void write_film(size_t i) {
        finish();
        const auto begin = std::chrono::steady_clock::now();
        const std::vector<std::string> paths = movies_.write(i, stop_);
        if (paths.empty()) throw interruption();
        const std::chrono::duration<double> film = std::chrono::steady_clock::now() - begin;
        if (options_.quiet) return;
        for (const std::string& path : paths) print(path + "\n");
        const StageTimes s = std::exchange(frame_seconds_, {});
        print_message(
            "{}; {:.2f} s: load {:.2f}, build {:.2f}, render {:.2f}, write {:.2f}, "
            "film {:.2f}\n",
            movies_.describe_length(i), s.total + film.count(), s.load(), s.build + s.prepare,
            s.render, s.write, film.count());
    }

    Error interruption() const {
        return Error(asset_label(plan_.commands[0].asset) + ": interrupted");
    }

    /// What is there of several pictures after an early end.
    std::string describe_state(size_t count) const {
        std::string text;
        if (!plan_.only_movies && count > 1 && stop_.stop_requested())
            text = fmt::format("; {} of {} pictures are finished", finished_, count);
        if (const std::string kept = movies_.describe_kept(); !kept.empty())
            text += "; " + kept + "; --resume continues from them";
        return text;
    }

    const ReportOptions& options_;
    RenderPlan& plan_;
    RenderMovies& movies_;
    std::stop_token stop_;
    std::optional<Asset> asset_;
    std::optional<Progress> pictures_;
    size_t finished_ = 0;
    size_t in_work_ = 0;  // the picture that is being written, if one is
    std::future<AssetResult> writing_;
    std::set<std::string> warned_;
    bool is_first_told_ = false;
    StageTimes frame_seconds_;  // of the frames since the last film
};

}  // namespace

void run_plan(RenderPlan& plan, const ReportOptions& options, std::stop_token stop) {
    PlanRun(plan, options, std::move(stop)).run();
}

}  // namespace sightline
