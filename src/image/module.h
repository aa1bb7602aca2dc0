#pragma once
#include "image/sniff.h"

#include <cstddef>
#include <string>

// The interface between the program and the module that contains OpenImageIO: plain data, no
// exceptions, no memory that one side allocates and the other frees.

namespace sightline {

/// Size and layout of an image: rows from the top, channels interleaved, 8-bit or float.
struct ImageLayout {
    int width, height, channels;
    bool floats;
};

/// The reason for a failure, on one line.
struct ModuleMessage {
    char text[512];
    bool out_of_memory;
};

/// The module's functions. All are thread-safe; none throws.
struct ImageModule {
    /// Whether this machine's OpenImageIO supports the format ("png", "heif" …).
    bool (*supports)(const char* format);

    /// Reads the header of an image file in memory, which must outlive the decoder.
    /// Returns nullptr and a message on failure.
    void* (*open)(const char* format, const void* file, size_t size, ImageLayout* shape,
                  ModuleMessage* message);
    /// Decodes into `pixels`, in the layout that `open` returned.
    bool (*read)(void* decoder, void* pixels, ModuleMessage* message);
    void (*close)(void* decoder);

    /// Encodes an image and passes the file's bytes to `take(context, bytes, size)`, once.
    bool (*encode)(const char* format, const ImageLayout* shape, const void* pixels,
                   void (*take)(void* context, const void* bytes, size_t size), void* context,
                   ModuleMessage* message);

    /// A view of a display of an OpenColorIO configuration, empty names for its defaults, from
    /// linear Rec. 709. Returns nullptr and a message on failure.
    void* (*open_view)(const char* config, const char* display, const char* view,
                       ModuleMessage* message);
    /// Converts one colour in place.
    void (*apply_view)(const void* processor, float* rgb);
    void (*close_view)(void* processor);
};

/// OpenImageIO's name of a format.
const char* module_format(ImageFormat format);

/// Loads the module on first use. Throws Error if it is missing.
const ImageModule& image_module();

/// The same. Throws Error if it is missing, or if this machine's OpenImageIO
/// does not support the format. `name` is the image's, for messages.
const ImageModule& image_module_for(ImageFormat format, const std::string& name);

/// Starts loading the module in the background, so that it is ready when first used.
void preload_image_module();

}  // namespace sightline

/// The one symbol of the module.
extern "C" const sightline::ImageModule* sightline_image_module();
