#pragma once
#include "render/film.h"

#include <map>
#include <optional>
#include <string>

namespace sightline {

/// Metadata of a picture. An EXR has the matrices under the standard names worldToCamera and
/// worldToNDC; they and the position layer are relative to `origin`, sightline:origin.
struct PictureMetadata {
    std::optional<Vec3d> origin;  ///< unset: the world's
    Mat4 world_to_camera, world_to_ndc;
    std::map<std::string, std::string> strings;  ///< by attribute name
    std::map<std::string, double> numbers;       ///< by attribute name
};

/// A picture file that takes its rows as they are rendered. It appears whole, when it is finished,
/// or not at all.
class PictureWriter {
  public:
    virtual ~PictureWriter() = default;

    /// The next rows, from the top, over the whole width of the window. Throws Error.
    virtual void add(const Film& band) = 0;

    /// After the last row: makes the file appear at `path`, which is in the folder of the path
    /// given at the beginning. The numbers of `metadata` may have changed since then, but not their
    /// names nor the strings. Throws Error.
    virtual void finish(const PictureMetadata& metadata, const std::string& path) = 0;
};

}  // namespace sightline
