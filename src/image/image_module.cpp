#include "core/error.h"
#include "image/image.h"
#include "image/module.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <filesystem>
#include <future>

namespace sightline {
namespace {

constexpr const char* module_name = "sightline_oiio.so";

void* find_module() {
    namespace fs = std::filesystem;
    std::error_code ignored;
    const fs::path folder = fs::read_symlink("/proc/self/exe", ignored).parent_path();
    for (const fs::path& path : {folder / module_name, folder / "../lib/sightline" / module_name}) {
        if (!fs::exists(path, ignored)) continue;
        return dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
    }
    return dlopen(module_name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
}

const ImageModule& load() {
    void* library = find_module();
    void* symbol = library ? dlsym(library, "sightline_image_module") : nullptr;
    if (!symbol) {
        throw Error(fmt::format("{}: cannot load the image module: {}", module_name, dlerror()));
    }
    return *reinterpret_cast<decltype(&sightline_image_module)>(symbol)();
}

const ImageModule& image_module() {
    static const ImageModule& module = load();
    return module;
}

}  // namespace

const char* module_format(ImageFormat format) {
    constexpr const char* names[] = {"png", "jpeg", "webp", "heif", "hdr", "openexr", "tiff"};
    return names[static_cast<size_t>(format)];
}

const ImageModule& image_module_for(ImageFormat format, const std::string& name) {
    const ImageModule& module = image_module();
    if (!module.knows(module_format(format))) {
        throw Error(fmt::format("{}: this machine's OpenImageIO has no {} support", name,
                                to_string(format)));
    }
    return module;
}

void preload_image_module() {
    // The future's destructor waits, so the process cannot end in the middle of the loading.
    static const auto loading = std::async(std::launch::async, [] {
        try {
            image_module();
        } catch (const Error&) {
            // Said by whoever needs the module.
        }
    });
}

}  // namespace sightline
