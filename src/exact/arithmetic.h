#pragma once

namespace sightline {

/// Throws Error where this build contracts a·b − c·d into fused operations, or this thread flushes
/// denormal numbers to zero: either breaks the exact and the watertight methods.
void check_arithmetic();

}  // namespace sightline
