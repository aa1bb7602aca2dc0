#pragma once
// Loading files that may well be broken.
#include "core/error.h"
#include "scene/gltf/load.h"
#include "support/gltf_builder.h"

namespace sightline {

/// Whether loading fails with one line that names the file and contains `part`.
inline testing::AssertionResult fails(const std::string& path, const std::string& part,
                                      const LoadOptions& options = {}) {
    try {
        load_gltf(path, options);
    } catch (const Error& error) {
        const std::string line = error.what();
        if (line.starts_with(path + ": ") && line.find(part) != std::string::npos &&
            line.find('\n') == std::string::npos) {
            return testing::AssertionSuccess();
        }
        return testing::AssertionFailure() << "another error: " << line;
    }
    return testing::AssertionFailure() << "it loads";
}

/// Whether it loads; if not, it must be by an Error of one line.
inline bool loads(const std::string& path) {
    try {
        load_gltf(path);
        return true;
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        return false;
    }
}

}  // namespace sightline
