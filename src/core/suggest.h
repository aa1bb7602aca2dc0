#pragma once
#include <span>
#include <string>
#include <string_view>

namespace sightline {

/// The word that was probably meant by `text`, which is none of `words`; empty if none is similar.
/// Similar are a word that a few typing errors make out of `text`, and one that begins with it.
std::string_view similar_word(std::string_view text, std::span<const std::string> words);

/// The end of a message about `text`: `; did you mean 'render'?`, or nothing.
std::string did_you_mean(std::string_view text, std::span<const std::string> words);

}  // namespace sightline
