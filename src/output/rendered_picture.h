#pragma once
#include "output/asset_result.h"

#include <functional>
#include <future>
#include <memory>

namespace sightline {

class OutputSet;

/// A picture that is rendered and whose files are not written yet. It refers to nothing of its
/// asset, which can render the next one meanwhile.
class RenderedPicture {
  public:
    /// `unwritten`: its files; null: they are written.
    RenderedPicture(AssetResult result, std::unique_ptr<OutputSet> unwritten);
    RenderedPicture(RenderedPicture&&) noexcept;
    ~RenderedPicture();

    /// Encodes and writes the files and adds what that takes to the times. To be called once.
    /// Throws Error.
    AssetResult write();

  private:
    AssetResult result_;
    std::unique_ptr<OutputSet> unwritten_;
};

/// Calls write() on another thread, and then `finish`. The next picture's writing begins after the
/// caller has taken this result, so that there are never more than two pictures in memory.
std::future<AssetResult> write_beside(RenderedPicture picture,
                                      std::function<void(const AssetResult&)> finish = {});

}  // namespace sightline
