// "Did you mean …?": the known word nearest to a mistyped one, by the number of edits between them.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace umax {

/// Insertions, deletions, substitutions and swaps of neighbours between two words.
int edit_distance(std::string_view a, std::string_view b);

/// The candidate with the smallest edit distance, the first of equals; empty if there are none.
std::string nearest_word(std::string_view word, const std::vector<std::string>& candidates);

/// The known key that a mistyped dotted key most likely means: looks at the whole key and at its last part alone,
/// so that "young" finds "material.young".
std::string nearest_key(std::string_view key, const std::vector<std::string>& known);

}  // namespace umax
