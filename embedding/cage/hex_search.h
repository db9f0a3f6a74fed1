// Look-up in an irregular lattice: which hex holds a point, and where in it.
#pragma once

#include <vector>

#include "core/model/lattice.h"

namespace umax {

/// A tree of bounding boxes over the hexes, and Newton's method on the trilinear map in those that may hold the point.
class HexSearch {
 public:
  /// The lattice must outlive it and have no inverted hexes.
  explicit HexSearch(const Lattice& lattice);

  /// Lowest hex that holds the point, or -1. local: its coordinates there, in [0, 1] (face_tolerance beyond on faces).
  int find(const Vector3d& point, Vector3d& local) const;

 private:
  struct Box {
    Vector3d low{0, 0, 0}, high{0, 0, 0};
    bool contains(const Vector3d& point) const;
  };
  struct Branch {
    Box box;
    int first = 0, last = 0;   // hexes in order_, of a leaf
    int left = -1, right = 0;  // branches; left < 0: a leaf
  };
  int grow(int first, int last);
  bool holds(int hex, const Vector3d& point, Vector3d& local) const;

  const Lattice& lattice_;
  std::vector<Box> boxes_;        // of every hex, a little larger
  std::vector<int> order_;        // hexes, those of a branch side by side
  std::vector<Branch> branches_;  // the first is the root
};

}  // namespace umax
