// A twisted, tapered bar of hexes and a scene in which it falls.
#pragma once

#include <cmath>
#include <string>

#include "tests/embedding/hex_files.h"

namespace umax::testing {

/// 1 m along x, 8 x 2 x 2 hexes, a third of a turn from end to end, half as thick there.
inline Lattice twisted_bar() {
  const Lattice box = make_box_lattice({8, 2, 2}, {-0.5, -0.12, -0.12}, {0.125, 0.12, 0.12});
  Points nodes = box.rest_positions;
  for (Eigen::Index n = 0; n < nodes.rows(); ++n) {
    const double t = nodes(n, 0) + 0.5, angle = 2 * t, scale = 1 - 0.5 * t, y = scale * nodes(n, 1),
                 z = scale * nodes(n, 2);
    nodes(n, 1) = y * std::cos(angle) - z * std::sin(angle);
    nodes(n, 2) = y * std::sin(angle) + z * std::cos(angle);
  }
  return make_irregular_lattice(nodes, box.hexes);
}

inline std::string bar_scene(const std::string& mesh, const std::string& more = {}) {
  return R"([clip]
frames = 10
[body.bar]
mesh = ")" +
         mesh + R"("
rotation = [0, 10, 20]
drop_height = "1 cm"
velocity = [0, -2, 0]
material.young = "100 kPa"
limit.stretch = "5 %"
)" + more +
         R"([obstacle.ground]
shape = "plane"
friction = 0.5
[render]
size = [32, 18]
samples = 1
denoise = false
)";
}

}  // namespace umax::testing
