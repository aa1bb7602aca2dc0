#pragma once
// Displays and views of an OpenColorIO configuration, by OpenImageIO.
#include "core/math.h"

#include <memory>
#include <string>

namespace sightline {

/// What a picture is converted for; all empty: no conversion by OpenColorIO.
struct ColorViewOptions {
    std::string config;         ///< file
    std::string display, view;  ///< empty: the configuration's defaults

    bool is_set() const { return !config.empty() || !view.empty(); }
    bool operator==(const ColorViewOptions&) const = default;
};

/// A view of a display. Colours enter as linear Rec. 709: by the configuration's name for that, or
/// else by the role scene_linear. Thread-safe.
class ColorView {
  public:
    /// Throws Error, one line that says what the configuration lacks.
    explicit ColorView(const ColorViewOptions& options);
    ~ColorView();
    ColorView(const ColorView&) = delete;
    ColorView& operator=(const ColorView&) = delete;

    /// The code values, 0 to 1, that the display gets for a colour.
    Vec3 code_values(const Vec3& color) const;

  private:
    void* processor_;  // the module's
};

/// The view of the options; a process keeps the last one. nullptr if they are not set. Throws
/// Error.
std::shared_ptr<const ColorView> find_color_view(const ColorViewOptions& options);

}  // namespace sightline
