// A libFuzzer target for load_gltf, strict and not. The input is the main file, alone in a folder
// that its URIs cannot leave. It finds crashes, sanitizer errors, timeouts and messages of more
// than one line. Images are not decoded; tests/image/hostile_image_test.cpp covers their decoders.
// Run it with `tools/fuzz import SECONDS`, which builds the `fuzz` preset (clang) and starts from
// scenes/; an input that fails is written to build/fuzz/findings and reproduced by passing it to
// build/fuzz/bin/import_fuzz.
#include "core/error.h"
#include "scene/gltf/load.h"

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace {

// A folder for this process, removed when it exits.
struct Folder {
    std::filesystem::path path = std::filesystem::temp_directory_path() /
                                 ("sightline-import-fuzz-" + std::to_string(getpid()));
    Folder() { std::filesystem::create_directories(path); }
    ~Folder() {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    static const Folder folder;
    static const std::string file = folder.path / "input";
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    sightline::LoadOptions options;
    options.decode_images = false;
    options.max_elements = 1 << 16;
    options.max_accessor_values = 1 << 22;
    options.time = 0.5f;
    for (const bool strict : {true, false}) {
        options.strict = strict;
        try {
            sightline::load_gltf(file, options);
        } catch (const sightline::Error& error) {
            if (std::string_view(error.what()).find('\n') != std::string_view::npos) std::abort();
        }
    }
    return 0;
}
