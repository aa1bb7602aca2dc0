#pragma once

namespace sightline {

/// The project's version in CMakeLists.txt, "0.1.0".
extern const char* const program_version;

}  // namespace sightline
