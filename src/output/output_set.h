#pragma once
#include "output/data_layers.h"
#include "output/image_writer.h"
#include "output/options.h"

#include <memory>

namespace sightline {

/// Where an interrupted render writes: "dir/a.partial.png" for "dir/a.png".
std::string partial_path(const std::string& picture);

/// The pictures of one render, written band by band. Their metadata has no times: the same command
/// writes the same bytes.
class OutputSet {
  public:
    /// `threads`: for compressing EXRs; 0: all. `engine`: the intersector's description. Throws
    /// Error.
    OutputSet(const OutputOptions& options, unsigned threads, const RenderContext& context,
              const std::string& engine);

    /// The next rows. Throws Error.
    void add(const Film& band);

    /// Makes all files appear, one after the other: a picture of an interrupted render at its
    /// partial_path, so that an earlier complete one remains. Throws Error.
    void finish(const RenderResult& result);

    /// By layer of OutputOptions::data, what finish() has written.
    std::map<std::string, DataScale> data_scales() const;

    /// With OutputOptions::preview: the beauty layer as an 8-bit RGB picture; else empty.
    Image preview() const { return preview_ ? preview_->image() : Image{}; }

  private:
    PictureMetadata metadata_;
    std::vector<std::string> paths_;
    std::vector<std::unique_ptr<PictureWriter>> writers_;  // as in paths_
    std::vector<const DataWriter*> data_;                  // those of `writers_` that write data
    std::optional<ImageWriter> preview_;
};

}  // namespace sightline
