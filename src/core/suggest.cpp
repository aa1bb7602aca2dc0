#include "core/suggest.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <vector>

namespace sightline {
namespace {

char lower(char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); }

// The number of characters to insert, remove, replace or swap with their neighbour (optimal string
// alignment) between the two texts, without regard to case.
size_t count_edits(std::string_view a, std::string_view b) {
    const size_t width = b.size() + 1;
    std::vector<size_t> before(width), above(width), row(width);
    for (size_t j = 0; j < width; ++j) above[j] = j;
    for (size_t i = 1; i <= a.size(); ++i) {
        row[0] = i;
        for (size_t j = 1; j < width; ++j) {
            const bool same = lower(a[i - 1]) == lower(b[j - 1]);
            row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + !same});
            if (i > 1 && j > 1 && lower(a[i - 1]) == lower(b[j - 2]) &&
                lower(a[i - 2]) == lower(b[j - 1]))
                row[j] = std::min(row[j], before[j - 2] + 1);
        }
        std::swap(before, above);
        std::swap(above, row);
    }
    return above[b.size()];
}

bool begins_with(std::string_view word, std::string_view text) {
    return word.size() > text.size() && count_edits(word.substr(0, text.size()), text) == 0;
}

}  // namespace

std::string_view similar_word(std::string_view text, std::span<const std::string> words) {
    constexpr size_t longest = 64;  // beyond it, nothing was mistyped
    std::string_view best;
    if (text.size() > longest) return best;
    size_t fewest = std::max<size_t>(1, text.size() / 3);
    for (const std::string& word : words) {
        if (word.size() > longest) continue;
        const size_t edits = count_edits(text, word);
        // A word of which nothing is left is not meant.
        if (edits > fewest || edits >= word.size() || (edits == fewest && !best.empty())) continue;
        best = word;
        fewest = edits;
    }
    if (!best.empty() || text.size() < 2) return best;
    const auto longer = std::ranges::find_if(
        words, [&](const std::string& word) { return begins_with(word, text); });
    return longer == words.end() ? best : std::string_view(*longer);
}

std::string did_you_mean(std::string_view text, std::span<const std::string> words) {
    const std::string_view word = similar_word(text, words);
    return word.empty() ? "" : fmt::format("; did you mean '{}'?", word);
}

}  // namespace sightline
