#include "output/image_writer.h"

#include "image/write_image.h"

namespace sightline {

ImageWriter::ImageWriter(const PixelRect& window, Convert convert)
    : window_(window), convert_(std::move(convert)) {}

void ImageWriter::add(const Film& band) {
    const Image rows = convert_(band);
    if (image_.empty()) {
        image_.width = rows.width;
        image_.channels = rows.channels;
        // All of it now, so that it does not move when rows are added.
        const size_t values = static_cast<size_t>(window_.width()) *
                              static_cast<size_t>(window_.height() * rows.channels);
        rows.bytes.empty() ? image_.floats.reserve(values) : image_.bytes.reserve(values);
    }
    image_.height += rows.height;
    image_.bytes.insert(image_.bytes.end(), rows.bytes.begin(), rows.bytes.end());
    image_.floats.insert(image_.floats.end(), rows.floats.begin(), rows.floats.end());
}

void ImageWriter::finish(const PictureMetadata&, const std::string& path) {
    write_image(path, image_);
}

}  // namespace sightline
