#pragma once
#include "image/image.h"
#include "output/picture_writer.h"

#include <functional>

namespace sightline {

/// Collects a whole picture, converted to an Image, and writes it at the end: .png .jpg .tif .webp
/// and .hdr. It holds 3 or 4 bytes per pixel, of a float image 12.
class ImageWriter : public PictureWriter {
  public:
    using Convert = std::function<Image(const Film& band)>;

    /// `window`: of the whole picture.
    ImageWriter(const PixelRect& window, Convert convert);
    void add(const Film& band) override;
    void finish(const PictureMetadata& metadata, const std::string& path) override;
    const Image& image() const { return image_; }

  private:
    PixelRect window_;
    Convert convert_;
    Image image_;
};

}  // namespace sightline
