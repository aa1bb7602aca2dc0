#include "lab/machine.h"

#include "intersect/bvh/traversal_kernel.h"

#include <unistd.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <string>
#include <thread>

namespace sightline {

nlohmann::ordered_json machine_json() {
    std::ifstream file("/proc/cpuinfo");
    std::string processor = "unknown processor";
    for (std::string line; std::getline(file, line);)
        if (line.starts_with("model name")) {
            processor = line.substr(std::min(line.size(), line.find(':') + 2));
            break;
        }
    const auto memory = static_cast<uint64_t>(::sysconf(_SC_PHYS_PAGES)) *
                        static_cast<uint64_t>(::sysconf(_SC_PAGESIZE));
    return {{"processor", processor},
            {"threads", std::thread::hardware_concurrency()},
            {"memory_bytes", memory},
            {"vectors", vector_target()}};
}

}  // namespace sightline
