#pragma once
#include <string>

namespace sightline {

/// The knob up to which an intersection method was right on every ray of a family of the atlas, by
/// src/render/breakdown.json (docs/atlas.md tells how it is made); 0 where that was not measured.
/// The knobs grow by up to 100 from value to value, so a method that broke down counts as right
/// up to a hundredth of the knob where it did.
double right_up_to(const std::string& family, const std::string& method);

/// The least knob at which the method was wrong; infinity: it never was, as far as measured.
double wrong_from(const std::string& family, const std::string& method);

}  // namespace sightline
