// Which frame one of many who share a clip draws next.
#pragma once

#include <set>
#include <vector>

namespace umax {

/// The next of the frames that are `missing` (increasing) and not `taken` by others, for who drew `last` before (0: none);
/// 0: all are taken. Everybody goes on frame by frame, as what the noise filter has seen of neighbours is used again;
/// who cannot starts at the first gap that is nobody's, or in the middle of the longest stretch that another one is
/// working towards.
int next_frame(const std::vector<int>& missing, const std::set<int>& taken, int last);

}  // namespace umax
