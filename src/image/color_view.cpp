#include "image/color_view.h"

#include "core/error.h"
#include "image/module.h"

#include <fmt/format.h>

#include <cstdlib>
#include <mutex>

namespace sightline {
namespace {

std::string config_of(const ColorViewOptions& options) {
    if (!options.config.empty()) return options.config;
    const char* named = std::getenv("OCIO");
    if (named && *named) return named;
    throw Error("--ocio-view needs a configuration: --ocio FILE, or the environment variable OCIO");
}

}  // namespace

ColorView::ColorView(const ColorViewOptions& options) {
    const std::string config = config_of(options);
    ModuleMessage message{};
    processor_ = image_module().open_view(config.c_str(), options.display.c_str(),
                                          options.view.c_str(), &message);
    if (!processor_) throw Error(fmt::format("{}: {}", config, message.text));
}

ColorView::~ColorView() { image_module().close_view(processor_); }

Vec3 ColorView::code_values(const Vec3& color) const {
    Vec3 result = color;
    image_module().apply_view(processor_, &result.x);
    return result;
}

std::shared_ptr<const ColorView> find_color_view(const ColorViewOptions& options) {
    static std::mutex mutex;
    static ColorViewOptions kept;
    static std::shared_ptr<const ColorView> view;
    if (!options.is_set()) return nullptr;
    const std::lock_guard lock(mutex);
    if (!view || !(kept == options)) {
        view = std::make_shared<ColorView>(options);
        kept = options;
    }
    return view;
}

}  // namespace sightline
