#include "tools/run/frame_order.h"

#include <algorithm>
#include <cstddef>

namespace umax {
namespace {

/// Frames missing[first] .. missing[last - 1], of which nobody has one.
struct Stretch {
  std::size_t first = 0, last = 0;
  bool is_followed = false;  // somebody works towards it: he has the frame before
  std::size_t size() const { return last - first; }
};

std::vector<Stretch> free_stretches(const std::vector<int>& missing, const std::set<int>& taken) {
  std::vector<Stretch> stretches;
  bool is_followed = false;
  for (std::size_t i = 0; i < missing.size(); ++i) {
    if (taken.count(missing[i])) {
      is_followed = true;
      continue;
    }
    if (stretches.empty() || stretches.back().last != i) stretches.push_back({i, i, is_followed});
    stretches.back().last = i + 1;
    is_followed = false;
  }
  return stretches;
}

}  // namespace

int next_frame(const std::vector<int>& missing, const std::set<int>& taken, int last) {
  const auto after = std::upper_bound(missing.begin(), missing.end(), last);
  if (last > 0 && after != missing.end() && !taken.count(*after)) return *after;
  const std::vector<Stretch> stretches = free_stretches(missing, taken);
  for (const Stretch& stretch : stretches)
    if (!stretch.is_followed) return missing[stretch.first];
  const auto longest = std::max_element(stretches.begin(), stretches.end(),
                                        [](const Stretch& a, const Stretch& b) { return a.size() < b.size(); });
  return longest == stretches.end() ? 0 : missing[longest->first + longest->size() / 2];
}

}  // namespace umax
