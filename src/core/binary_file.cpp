#include "core/binary_file.h"

#include "core/error.h"
#include "core/files.h"

#include <fmt/format.h>

#include <fstream>

namespace sightline {

void write_binary_file(const std::string& path, const char* content,
                       const std::function<void(std::ostream&)>& write) {
    write_atomically(path, [&](const std::string& temporary) {
        std::ofstream file(temporary, std::ios::binary);
        write(file);
        file.flush();
        if (!file) throw Error(fmt::format("{}: cannot write {}: disk full?", path, content));
    });
}

}  // namespace sightline
