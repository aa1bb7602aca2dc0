#include "scene/gltf/load.h"

#include "core/error.h"
#include "scene/gltf/animation.h"
#include "scene/gltf/build.h"
#include "scene/gltf/load_document.h"

#include <new>

namespace sightline {

Scene load_gltf(const std::string& path, const LoadOptions& options) try {
    Document document = load_document(path, options);
    if (options.time || !options.animation.empty()) {
        animate(document, options.animation.empty() ? "all" : options.animation,
                double(options.time.value_or(0)));
    }
    return build_scene(document, options);
} catch (const std::bad_alloc&) {
    throw Error(path + ": not enough memory to load it");
}

}  // namespace sightline
