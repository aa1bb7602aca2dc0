#pragma once
// From a request (an asset and what to render of it) to a list of tasks.
#include "batch/names.h"
#include "batch/task.h"
#include "output/options.h"
#include "scene/view_names.h"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace sightline {

/// A named set of options that override those of the asset.
struct View {
    std::string name;
    Settings settings;
    bool operator==(const View&) const = default;
};

/// The pictures to render of an asset: views times frames or turntable steps.
struct RenderSpec {
    Settings settings;
    std::vector<View> views;        ///< empty: one view with the settings as they are
    bool all_cameras = false;       ///< adds one view per camera of the file
    bool use_file_cameras = false;  ///< without a view: the file's first camera, if it has one
    Ring turntable;                 ///< views at equal angles around the asset; count 0: none
    std::optional<FrameRange> frames;
    double fps = 24;   ///< of films of turntables
    std::string name;  ///< template of the pictures' names; empty: default_template
    std::vector<std::string> formats{"png"};
    bool operator==(const RenderSpec&) const = default;
};

/// One of an asset's pictures, before it has a name.
struct PictureRequest {
    std::string view;  ///< name of the view; empty if none was asked for
    int frame = 0;     ///< of the animation, or step of the turntable
    Settings settings;
};

/// An asset and what to render of it.
struct AssetRequest {
    std::string asset;  ///< absolute path
    std::string name;   ///< for {asset}: path below the folder that was searched, no extension
    RenderSpec spec;
    size_t cameras = 0;  ///< number of cameras in the file; set only if spec.all_cameras
};

/// A view from a camera: one of the file by name or index, or a view such as "front".
View camera_view(const std::string& camera);

/// The views that a list stands for, see expand_view. Throws Error if an element is malformed.
std::vector<View> make_views(std::span<const std::string> list);

/// Sets an option and removes its alternative (`error` and `samples` exclude each other).
void override_setting(Settings& settings, const std::string& name, const std::string& value);

/// The value of the option `env`; a file's path becomes absolute, relative to `folder`.
std::string absolute_environment(const std::string& env, const std::string& folder);

/// Parses "FIRST..LAST". Throws Error.
FrameRange parse_frames(const std::string& text, double fps);

/// Whether the formats are those of films, or WebP with a name without {frame} for a sequence: each
/// view then is one file with all its frames.
bool makes_films(const RenderSpec& spec);

/// The template of names if none is given: {asset}, with _{view} and _{frame:04} if there are
/// several views or frames.
std::string default_template(const RenderSpec& spec);

/// All pictures of an asset: its views, those of its `cameras` with all_cameras, times its frames
/// or turntable steps.
std::vector<PictureRequest> pictures_of(const RenderSpec& spec, size_t cameras = 0);

/// What fills in the name template for a picture of the asset. `name`: for {asset}.
NameFields name_fields(const std::string& asset, const std::string& name,
                       const PictureRequest& picture);

/// Throws NameError if the template of the pictures' names is malformed or gives one name to
/// several views or frames of an asset, or if a turntable with a view of its own has others too.
void check_template(const RenderSpec& spec);

/// check_template; also throws NameError if the names are not those of files below a folder.
void check_names(const RenderSpec& spec);

/// All tasks, in the order of the requests. No two have an output in common: assets whose names
/// collide are told apart by their folders, else by their extensions, else by numbers. An asset
/// keeps the name that it has in `known`, and no other asset gets that.
/// Throws NameError if the names do not differ because the template does not contain the asset's,
/// or if a name is not that of a file below the batch's folder.
std::vector<Task> make_tasks(const std::vector<AssetRequest>& requests,
                             const KnownNames& known = {});

/// Removes the requests that repeat an earlier one and returns their assets.
std::vector<std::string> remove_repeated(std::vector<AssetRequest>& requests);

}  // namespace sightline
