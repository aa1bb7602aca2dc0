#pragma once
#include <nlohmann/json_fwd.hpp>

namespace sightline {

/// The processor's name, its threads, its memory in bytes and the instruction set of our engines,
/// for reports of times.
nlohmann::ordered_json machine_json();

}  // namespace sightline
