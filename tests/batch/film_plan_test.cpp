#include "batch/film_task.h"

#include "core/error.h"
#include "support/plans.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace sightline {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(FilmPlan, AFilmIsOneTaskWithTheFramesOfItsView) {
    RenderSpec spec;
    spec.formats = {"mp4", "webm"};
    spec.views = {camera_view("front"), camera_view("top")};
    spec.turntable = {3, std::nullopt};
    spec.fps = 12;
    const auto films = make_tasks({request("a", spec)});
    EXPECT_THAT(outputs_of(films),
                ElementsAre("a_front.mp4", "a_front.webm", "a_top.mp4", "a_top.webm"));
    EXPECT_EQ(films[1].settings, (Settings{{"camera", "top"}}));
    EXPECT_EQ(films[1].film, (Settings{{"fps", "12"}, {"turntable", "3"}}));
    // The frames are the pictures that the same request without films makes.
    spec.formats = {"png"};
    const auto pictures = make_tasks({request("a", spec)});
    const auto frames = film_frames(films[1]);
    ASSERT_EQ(frames.size(), 3u);
    for (size_t i = 0; i < 3; ++i) EXPECT_EQ(frames[i].settings, pictures[3 + i].settings);
    EXPECT_EQ(task_from_json(to_json(films[1])).key(), films[1].key());
    EXPECT_THAT(render_command(films[1]), HasSubstr("--fps=12 --turntable=3 --output=a_top.mp4"));
}

TEST(FilmPlan, AFilmOfAnAnimationHasItsTimes) {
    RenderSpec spec;
    spec.formats = {"gif"};
    spec.frames = FrameRange{2, 4, 10};
    const auto films = make_tasks({request("a", spec)});
    ASSERT_EQ(films.size(), 1u);
    spec.formats = {"png"};
    const auto pictures = make_tasks({request("a", spec)});
    const auto frames = film_frames(films[0]);
    ASSERT_EQ(frames.size(), 3u);
    for (size_t i = 0; i < 3; ++i) EXPECT_EQ(frames[i].settings, pictures[i].settings);
    Task other = films[0];
    other.film["frames"] = "2..5";
    EXPECT_NE(other.key(), films[0].key());
}

TEST(FilmPlan, AFilmNeedsASequenceAndANameWithoutFrames) {
    RenderSpec spec;
    spec.formats = {"mp4"};
    EXPECT_THROW(check_names(spec), NameError);
    spec.turntable = {3, std::nullopt};
    check_names(spec);
    spec.name = "{asset}_{frame}";
    EXPECT_THROW(check_names(spec), NameError);
    spec.name = "";
    spec.formats = {"mp4", "png"};
    EXPECT_THROW(check_names(spec), NameError);
    spec.formats = {"mp4"};
    spec.settings["data"] = "depth";
    EXPECT_THROW(check_names(spec), NameError);
}

TEST(FilmPlan, AWebPIsAFilmWhereAllFramesHaveOneName) {
    RenderSpec spec;
    spec.formats = {"webp"};
    const auto tasks = [&] {
        check_names(spec);
        return make_tasks({request("a", spec)});
    };
    spec.name = "{asset}";
    EXPECT_TRUE(tasks()[0].film.empty());  // of one picture
    spec.turntable = {3, std::nullopt};
    EXPECT_THAT(outputs_of(tasks()), ElementsAre("a.webp"));
    EXPECT_FALSE(tasks()[0].film.empty());
    spec.name = "{asset}-{frame}";
    EXPECT_THAT(outputs_of(tasks()), ElementsAre("a-0.webp", "a-1.webp", "a-2.webp"));
    spec.name = "";
    EXPECT_THAT(outputs_of(tasks()), ElementsAre("a_0000.webp", "a_0001.webp", "a_0002.webp"));
    spec.formats = {"webp", "mp4"};
    EXPECT_THAT(outputs_of(tasks()), ElementsAre("a.webp", "a.mp4"));
    spec.name = "{asset}";
    spec.formats = {"webp", "png"};
    EXPECT_THROW(check_names(spec), NameError);
}

TEST(FilmPlan, DataFilesAreOutputsBesideThePictures) {
    RenderSpec spec;
    spec.formats = {"png", "exr"};
    spec.settings["data"] = "normal,depth";
    const auto tasks = make_tasks({request("a.b", spec)});
    EXPECT_THAT(outputs_of(tasks),
                ElementsAre("a.b.png", "a.b.exr", "a.b.depth.png", "a.b.normal.png"));
    EXPECT_THAT(render_command(tasks[0]),
                HasSubstr("--data=normal,depth --output=a.b.png --output=a.b.exr"));
}

}  // namespace
}  // namespace sightline
