#include "core/file_clash.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <map>
#include <optional>
#include <utility>

namespace sightline {
namespace {

using FileIdentity = std::pair<dev_t, ino_t>;

std::optional<FileIdentity> identity_of(const std::string& path) {
    struct stat status;
    if (path.empty() || stat(path.c_str(), &status) != 0) return {};
    return FileIdentity(status.st_dev, status.st_ino);
}

}  // namespace

void check_outputs_are_not_inputs(std::span<const std::string> outputs,
                                  std::span<const std::string> inputs) {
    std::map<FileIdentity, const std::string*> read;
    for (const std::string& input : inputs)
        if (const auto identity = identity_of(input)) read.emplace(*identity, &input);
    for (const std::string& output : outputs) {
        const auto identity = identity_of(output);
        const auto found = identity ? read.find(*identity) : read.end();
        if (found == read.end()) continue;
        const std::string& input = *found->second;
        const std::string names = input == output ? "" : fmt::format(" under the name {}", input);
        throw OutputIsInput(fmt::format(
            "{}: would be written, but is also read{}; choose another output", output, names));
    }
}

}  // namespace sightline
