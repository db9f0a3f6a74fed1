// Things that are joined to groups, pair by pair.
#pragma once

#include <algorithm>
#include <cstddef>
#include <numeric>
#include <utility>
#include <vector>

namespace umax {

/// Each of `count` things by itself at first. A group is known by its first member.
class Groups {
 public:
  explicit Groups(std::size_t count) : parents_(count) { std::iota(parents_.begin(), parents_.end(), 0); }
  int of(int i) const {
    while (parents_[i] != i) i = parents_[i];
    return i;
  }
  void join(int a, int b) {
    const int first = of(a), second = of(b);
    parents_[std::max(first, second)] = std::min(first, second);
  }
  /// Members ascending, groups by their first one.
  std::vector<std::vector<int>> all() const {
    std::vector<std::vector<int>> of_first(parents_.size()), groups;
    for (int i = 0; i < int(parents_.size()); ++i) of_first[of(i)].push_back(i);
    for (std::vector<int>& group : of_first)
      if (!group.empty()) groups.push_back(std::move(group));
    return groups;
  }

 private:
  std::vector<int> parents_;
};

}  // namespace umax
