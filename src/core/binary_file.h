#pragma once
// Files of numbers as they are in memory: little-endian on x86 and ARM.
#include <functional>
#include <ostream>
#include <string>

namespace sightline {

/// Writes the bytes of a number, or of a struct of numbers without padding.
template <class T>
void put(std::ostream& file, const T& value) {
    file.write(reinterpret_cast<const char*>(&value), sizeof value);
}

/// Writes a file atomically by calling `write`. `content` names it in the message, such as "the
/// rays". Throws Error.
void write_binary_file(const std::string& path, const char* content,
                       const std::function<void(std::ostream&)>& write);

}  // namespace sightline
