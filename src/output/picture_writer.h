#pragma once
#include "render/film.h"

#include <map>
#include <string>

namespace sightline {

/// Metadata of a picture. Matrices go out under the standard names worldToCamera and worldToNDC.
struct PictureInfo {
    Mat4 world_to_camera, world_to_ndc;
    std::map<std::string, std::string> strings;  ///< attribute name → text
    std::map<std::string, double> numbers;
};

/// A picture file that takes its rows as they are rendered. It appears whole, when it is finished,
/// or not at all.
class PictureWriter {
  public:
    virtual ~PictureWriter() = default;

    /// The next rows, from the top, over the whole width of the window. Throws Error.
    virtual void add(const Film& band) = 0;

    /// After the last row. `info` may have other numbers under the names that it began with.
    virtual void finish(const PictureInfo& info) = 0;
};

}  // namespace sightline
