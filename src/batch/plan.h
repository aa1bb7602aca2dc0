#pragma once
// From what was asked for to a list of tasks.
#include "batch/task.h"

#include <optional>
#include <set>
#include <string>
#include <vector>

namespace sightline {

/// One way to look at an asset.
struct View {
    std::string name;
    Settings settings;
};

/// Frames first to last of an animation, at so many a second.
struct FrameRange {
    int first = 0, last = 0;
    double fps = 24;
};

/// Which pictures to make of an asset.
struct PictureSet {
    Settings settings;
    std::vector<View> views;   ///< empty: one, as the settings say
    bool all_cameras = false;  ///< besides, one view for each camera of the file
    int turntable = 0;         ///< so many pictures, once around
    std::optional<FrameRange> frames;
    std::string name;  ///< template of the outputs' names; empty: see default_template
    std::vector<std::string> formats{"png"};
};

/// An asset and what to make of it.
struct Order {
    std::string asset;  ///< absolute path
    std::string name;   ///< for {asset}: below the folder that was searched, without ending
    PictureSet pictures;
    size_t cameras = 0;  ///< of the file; filled in where `all_cameras` asks for it
};

/// The assets that an input names: a file, a folder with all below it, or a pattern with * ? [ ].
/// Sorted by name. Throws Error where there is none.
std::vector<Order> find_assets(const std::string& input, const PictureSet& pictures);

/// The orders of a manifest (docs/batch-manifest.schema.json), whose entries start from `defaults`.
/// `options` are the names of render's options. Throws Error with the JSON path.
std::vector<Order> read_manifest(const std::string& path, const PictureSet& defaults,
                                 const std::set<std::string>& options);

/// A view by its name: a camera of the file (name or index), "fit" or a side.
View view_of_camera(const std::string& camera);

/// Sets an option, and removes the one that it stands in place of (`error` and `samples`).
void override_setting(Settings& settings, const std::string& name, const std::string& value);

/// The value of the option `env` with a file's path below `folder` made absolute.
std::string absolute_environment(const std::string& env, const std::string& folder);

/// "A..B". Throws Error.
FrameRange parse_frames(const std::string& text, double fps);

/// What the names are made by where nobody says: {asset}, with _{view} and _{frame:04} where
/// there are several.
std::string default_template(const PictureSet& pictures);

/// All tasks, in the order of the orders. Throws Error where two would write one file, a name
/// leaves the batch's folder or cannot be one.
std::vector<Task> make_tasks(const std::vector<Order>& orders);

}  // namespace sightline
