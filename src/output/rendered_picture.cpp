#include "output/rendered_picture.h"

#include "output/render_pictures.h"

#include <utility>

namespace sightline {

RenderedPicture::RenderedPicture(AssetResult result, std::unique_ptr<OutputSet> unwritten)
    : result_(std::move(result)), unwritten_(std::move(unwritten)) {}

RenderedPicture::RenderedPicture(RenderedPicture&&) noexcept = default;

RenderedPicture::~RenderedPicture() = default;

AssetResult RenderedPicture::write() {
    if (const std::unique_ptr<OutputSet> outputs = std::move(unwritten_)) {
        finish_pictures(*outputs, result_);
        result_.seconds.total += result_.seconds.write;
    }
    return std::move(result_);
}

std::future<AssetResult> write_beside(RenderedPicture picture,
                                      std::function<void(const AssetResult&)> finish) {
    // Deferred where no thread can be started: then the one that takes the result writes.
    return std::async(std::launch::async | std::launch::deferred,
                      [picture = std::move(picture), finish = std::move(finish)]() mutable {
                          AssetResult result = picture.write();
                          if (finish) finish(result);
                          return result;
                      });
}

}  // namespace sightline
