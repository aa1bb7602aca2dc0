#pragma once
#include "render/render.h"

#include <string>

namespace sightline {

/// What a finished picture shows.
enum class PictureContent {
    something,
    empty,  ///< no camera ray met a surface that is not fully transparent
    black   ///< surfaces were met, and no pixel has any light
};

/// "something", "empty", "black".
const char* to_string(PictureContent content);

/// What a picture without an early end shows.
PictureContent content_of(const RenderResult& result);

/// One line that says why a picture is empty or black, as far as that can be found.
std::string why_blank(PictureContent content, const RenderContext& context,
                      const RenderResult& result);

}  // namespace sightline
