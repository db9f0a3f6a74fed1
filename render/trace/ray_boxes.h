// Which rays cannot meet anything, told from boxes around the objects before the ray library is asked.
#pragma once

#include <array>
#include <vector>

#include "render/scene/rows.h"
#include "render/trace/traced_object.h"

namespace umax {

/// Most rays that leave the ground go to lights and sky: telling that here costs a tenth of asking the library.
class RayBoxes {
 public:
  RayBoxes() = default;
  explicit RayBoxes(const std::vector<TracedObject>& objects);

  /// may_hit[i] is 0 for rays that certainly meet nothing.
  void find(const rows::RayRows& rays, int count, rows::RowOf<int>& may_hit) const;

 private:
  struct Box {
    std::array<float, 3> low, high;  // [m]
  };
  std::vector<Box> boxes_;
};

}  // namespace umax
