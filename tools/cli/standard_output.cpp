#include "standard_output.h"

#include "core/error.h"
#include "core/files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>

namespace sightline {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path) {
    throw Error(fmt::format("{}: {}", path, std::strerror(errno)));
}

}  // namespace

StandardOutput::~StandardOutput() {
    std::error_code ignored;
    if (!folder_.empty()) fs::remove_all(folder_, ignored);
}

void StandardOutput::take(std::vector<std::string>& outputs, const std::string& format) {
    const auto count = std::ranges::count(outputs, "-");
    if (count == 0) return;
    if (count > 1) throw CLI::ValidationError("- is given as output twice");
    if (isatty(STDOUT_FILENO))
        throw CLI::ValidationError(
            "standard output is a terminal; send the picture to a file or a program, as in "
            "`-o - > picture.png`");
    folder_ = (fs::temp_directory_path() / "sightline-XXXXXX").string();
    if (!mkdtemp(folder_.data())) {
        const std::string place = std::exchange(folder_, "");
        fail(place);
    }
    file_ = (fs::path(folder_) / ("picture." + format)).string();
    std::ranges::replace(outputs, std::string("-"), file_);
}

void StandardOutput::send() const {
    const int fd = open(file_.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) fail(file_);
    std::array<std::byte, size_t{1} << 16> buffer;
    ssize_t got = 0;
    bool is_written = true;
    while (is_written && (got = read(fd, buffer.data(), buffer.size())) > 0)
        is_written = write_all(STDOUT_FILENO, std::span(buffer).first(static_cast<size_t>(got)));
    const int error = errno;
    close(fd);
    if (got < 0) throw Error(fmt::format("{}: cannot read: {}", file_, std::strerror(error)));
    if (!is_written)
        throw Error(
            fmt::format("standard output: the picture was not taken: {}", std::strerror(error)));
}

}  // namespace sightline
