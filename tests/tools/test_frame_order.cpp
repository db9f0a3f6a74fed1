// Which frame is drawn next, by one who draws alone and by several who share a clip.
#include "tools/run/frame_order.h"

#include <set>

#include "tests/support/catch.h"
#include "tools/run/frame_list.h"

using namespace umax;

TEST_CASE("one who draws alone goes from the first frame to the last") {
  std::vector<int> missing = all_frames(9), order;
  for (int last = 0; !missing.empty();) {
    last = next_frame(missing, {}, last);
    order.push_back(last);
    std::erase(missing, last);
  }
  CHECK(order == all_frames(9));
  CHECK(next_frame({}, {}, 0) == 0);
}

TEST_CASE("who comes later starts in the middle of the longest stretch that others have before them") {
  CHECK(next_frame({1, 2, 3, 4, 5, 6, 7, 8, 9}, {1}, 0) == 6);
  CHECK(next_frame({3, 4, 5, 6, 7, 8, 9}, {3, 6}, 0) == 8);
  CHECK(next_frame({3, 4, 5, 6, 7, 8, 9}, {3, 6}, 5) == 8);  // its own stretch is at its end
  CHECK(next_frame({3, 4, 5, 6, 7}, {3}, 4) == 5);           // it goes on where it is
  CHECK(next_frame({3, 4}, {3}, 0) == 4);
  CHECK(next_frame({3, 4}, {3, 4}, 0) == 0);
  CHECK(next_frame({3, 4, 7}, {4, 7}, 0) == 3);  // a gap that nobody works towards goes first
}

TEST_CASE("three who share a clip move through stretches of their own") {
  std::vector<int> missing = all_frames(30);
  std::vector<int> last(3, 0);
  std::vector<std::vector<int>> drawn(3);
  while (!missing.empty()) {
    std::set<int> taken;
    std::vector<int> claims(3);
    for (int k = 0; k < 3; ++k)
      if ((claims[std::size_t(k)] = next_frame(missing, taken, last[std::size_t(k)])) > 0)
        taken.insert(claims[std::size_t(k)]);
    for (std::size_t k = 0; k < 3; ++k)
      if (claims[k] > 0) {
        drawn[k].push_back(last[k] = claims[k]);
        std::erase(missing, claims[k]);
      }
  }
  int jumps = 0;
  for (const auto& frames : drawn) {
    CHECK(frames.size() == 10);
    for (std::size_t i = 1; i < frames.size(); ++i) jumps += frames[i] != frames[i - 1] + 1;
  }
  CHECK(jumps <= 6);  // each costs the neighbours that its filter looks at
}
