#include "core/plain_reason.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

namespace sightline {

std::string plain_reason(const std::exception& exception) {
    if (const auto* e = dynamic_cast<const std::filesystem::filesystem_error*>(&exception)) {
        const std::string reason = e->code().message();
        return e->path1().empty() ? reason : fmt::format("{}: {}", e->path1().string(), reason);
    }
    if (const auto* e = dynamic_cast<const std::system_error*>(&exception))
        return e->code().message();
    // nlohmann's texts begin with a mark such as [json.exception.type_error.302].
    std::string text = exception.what();
    if (const size_t end = text.find("] "); text.starts_with("[json.") && end != std::string::npos)
        text.erase(0, end + 2);
    return text;
}

}  // namespace sightline
