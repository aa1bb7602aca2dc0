#pragma once

namespace sightline {

/// Throws Error if this build contracts a·b − c·d into fused operations or if this thread flushes
/// denormal numbers to zero: either breaks the exact and the watertight methods.
void check_arithmetic();

}  // namespace sightline
