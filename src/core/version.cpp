#include "core/version.h"

namespace sightline {

// Only this file depends on the number, so that a new version rebuilds nothing else.
const char* const program_version = SIGHTLINE_VERSION;

}  // namespace sightline
