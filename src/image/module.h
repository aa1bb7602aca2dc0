#pragma once
#include "image/sniff.h"

#include <cstddef>
#include <string>

// What passes between the program and the module that knows OpenImageIO: plain data, no
// exceptions, no memory that one side allocates and the other frees.

namespace sightline {

/// Size and layout of a picture: rows from the top, channels interleaved, 8-bit or float.
struct PictureShape {
    int width, height, channels;
    bool floats;
};

/// Why a call of the module failed; one line.
struct ModuleMessage {
    char text[512];
};

/// The module's functions. All are thread-safe; none throws.
struct ImageModule {
    /// Whether this machine's OpenImageIO knows the format ("png", "heif" …).
    bool (*knows)(const char* format);

    /// Reads the header of a picture in memory, which must outlive the decoder.
    /// nullptr and a message on failure.
    void* (*open)(const char* format, const void* file, size_t size, PictureShape* shape,
                  ModuleMessage* message);
    /// Decodes into `pixels`, whose layout `open` gave.
    bool (*read)(void* decoder, void* pixels, ModuleMessage* message);
    void (*close)(void* decoder);

    /// Encodes a picture and hands the file's bytes to `take(context, bytes, size)`, once.
    bool (*encode)(const char* format, const PictureShape* shape, const void* pixels,
                   void (*take)(void* context, const void* bytes, size_t size), void* context,
                   ModuleMessage* message);
};

/// The name that the module's functions take for a format.
const char* module_format(ImageFormat format);

/// Loads the module on first use. Throws Error where it is missing, or where this machine's
/// OpenImageIO does not know the format. `name` is the picture's, for messages.
const ImageModule& image_module_for(ImageFormat format, const std::string& name);

}  // namespace sightline

/// The one symbol of the module.
extern "C" const sightline::ImageModule* sightline_image_module();
