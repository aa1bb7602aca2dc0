#include "render_movies.h"

#include "batch/frame_key.h"
#include "core/error.h"
#include "core/text.h"
#include "intersect/embree/embree.h"
#include "output/formats.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <filesystem>
#include <iterator>

namespace sightline {

RenderMovies::RenderMovies(std::vector<std::string> names, double fps, bool resume)
    : names_(std::move(names)), fps_(fps), resume_(resume) {}

void RenderMovies::add(RenderCommand& command, const Settings& settings, const NameFields& fields) {
    std::vector<std::string> paths;
    for (const std::string& name : names_) paths.push_back(fill_in(name, fields));
    const auto [found, is_new] = index_.emplace(paths[0], movies_.size());
    if (is_new) {
        auto kept = std::make_unique<MovieFrames>(paths[0], resume_);
        movies_.push_back({paths, movie_options(command, fps_), 0, 0, std::move(kept)});
        isa_ = command.engine.isa;
    }
    Movie& movie = movies_[found->second];
    frames_.push_back({found->second, movie.frames++, settings});
    command.output.pictures.push_back(movie.kept->path(frames_.back().number));
}

std::vector<std::string> RenderMovies::paths() const {
    std::vector<std::string> all;
    for (const Movie& movie : movies_) std::ranges::copy(movie.paths, std::back_inserter(all));
    return all;
}

void RenderMovies::check() {
    if (empty()) return;
    isa_ = embree_isa(isa_);
    for (const Movie& movie : movies_)
        for (const std::string& path : movie.paths)
            if (const std::string problem = movie_problem(path, movie.options); !problem.empty())
                throw CLI::ValidationError(problem);
    check_ffmpeg(names_);
    for (const std::string& path : paths()) check_place(path);
    for (const Movie& movie : movies_) movie.kept->make_folder();
}

std::string RenderMovies::describe(size_t picture) const {
    const Frame& frame = frames_[picture];
    return fmt::format("{}, frame {}", movies_[frame.movie].paths[0], frame.number);
}

std::string RenderMovies::describe_length(size_t picture) const {
    const size_t frames = movies_[frames_[picture].movie].frames;
    return fmt::format("{} frames, {:.2f} s of film", frames, static_cast<double>(frames) / fps_);
}

uint64_t RenderMovies::key_of(const Frame& frame, std::span<const SourceFile> inputs) const {
    return frame_key(frame.settings, inputs, isa_);
}

bool RenderMovies::has_kept(size_t picture, std::span<const SourceFile> inputs, std::string& note) {
    if (empty() || !resume_) return false;
    const Frame& frame = frames_[picture];
    Movie& movie = movies_[frame.movie];
    if (!movie.kept->has(frame.number, key_of(frame, inputs), note)) return false;
    ++movie.done;
    return true;
}

void RenderMovies::keep(size_t picture, std::span<const SourceFile> inputs) {
    if (empty()) return;
    const Frame& frame = frames_[picture];
    Movie& movie = movies_[frame.movie];
    movie.kept->keep(frame.number, key_of(frame, inputs));
    ++movie.done;
}

void RenderMovies::drop(size_t picture) const {
    if (empty()) return;
    const Frame& frame = frames_[picture];
    movies_[frame.movie].kept->drop(frame.number);
}

bool RenderMovies::ends_film(size_t picture) const {
    if (empty()) return false;
    const Frame& frame = frames_[picture];
    return frame.number + 1 == movies_[frame.movie].frames;
}

std::vector<std::string> RenderMovies::write(size_t picture, const std::stop_token& stop) {
    Movie& movie = movies_[frames_[picture].movie];
    const std::vector<std::string> files = movie.kept->files();
    for (const std::string& path : movie.paths)
        if (!write_movie(path, files, movie.options, movie.kept->folder(), stop)) return {};
    movie.kept->remove();
    movie.done = 0;
    return movie.paths;
}

void RenderMovies::discard() {
    for (Movie& movie : movies_) {
        movie.kept->remove();
        movie.done = 0;
    }
}

std::string RenderMovies::describe_kept() const {
    std::string text;
    for (const Movie& movie : movies_)
        if (movie.done > 0)
            text += fmt::format("{}{} of {} frames are kept in {}", text.empty() ? "" : ", ",
                                movie.done, movie.frames, movie.kept->folder());
    return text;
}

std::vector<std::string> take_movies(std::vector<std::string>& outputs, bool is_sequence) {
    std::vector<std::string> movies;
    std::erase_if(outputs, [&](const std::string& path) {
        const bool is_film =
            is_movie(path) || (is_sequence && can_be_movie(path) && !has_field(path, "frame"));
        if (is_film) movies.push_back(path);
        return is_film;
    });
    return movies;
}

}  // namespace sightline
