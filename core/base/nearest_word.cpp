#include "core/base/nearest_word.h"

#include <algorithm>
#include <functional>
#include <limits>

namespace umax {
namespace {

std::string_view last_part(std::string_view key) {
  const std::size_t dot = key.rfind('.');
  return dot == std::string_view::npos ? key : key.substr(dot + 1);
}

std::string smallest(const std::vector<std::string>& candidates, const std::function<int(const std::string&)>& cost) {
  std::string best;
  int best_cost = std::numeric_limits<int>::max();
  for (const std::string& candidate : candidates) {
    const int candidate_cost = cost(candidate);
    if (candidate_cost < best_cost) {
      best_cost = candidate_cost;
      best = candidate;
    }
  }
  return best;
}

}  // namespace

int edit_distance(std::string_view a, std::string_view b) {
  // long words are cut: their distance only has to be large
  a = a.substr(0, 100);
  b = b.substr(0, 100);
  // three rows of the table of distances between prefixes
  std::vector<int> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) above[j] = int(j);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = int(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, above[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) row[j] = std::min(row[j], before[j - 2] + 1);
    }
    std::swap(before, above);
    std::swap(above, row);
  }
  return above[b.size()];
}

std::string nearest_word(std::string_view word, const std::vector<std::string>& candidates) {
  return smallest(candidates, [&](const std::string& candidate) { return edit_distance(word, candidate); });
}

std::string nearest_key(std::string_view key, const std::vector<std::string>& known) {
  return smallest(known, [&](const std::string& candidate) {
    // the last part alone counts for less than the whole
    const int whole = 2 * edit_distance(key, candidate);
    const int last = 2 * edit_distance(last_part(key), last_part(candidate)) + 3;
    return std::min(whole, last);
  });
}

}  // namespace umax
