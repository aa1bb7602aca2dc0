#pragma once
#include "batch/plan.h"

#include <string>
#include <vector>

namespace sightline {

/// A request for the pictures of /assets/NAME.glb.
inline AssetRequest request(const std::string& name, const RenderSpec& spec = {}) {
    return {"/assets/" + name + ".glb", name, spec, 0};
}

/// The outputs of all tasks in their order.
inline std::vector<std::string> outputs_of(const std::vector<Task>& tasks) {
    std::vector<std::string> outputs;
    for (const Task& task : tasks)
        outputs.insert(outputs.end(), task.outputs.begin(), task.outputs.end());
    return outputs;
}

}  // namespace sightline
