// An OBJ of two cubes of 20 cm side by side, whose cage is two islands.
#pragma once

#include <filesystem>
#include <string>

#include "core/base/types.h"
#include "tests/support/temporary_folder.h"

namespace umax {

/// gap [m]: between them along x.
inline void write_two_cubes(const std::filesystem::path& path, double gap) {
  std::string text;
  for (const double x : {0.0, 0.2 + gap})
    for (int v = 0; v < 8; ++v)
      text += "v " + std::to_string(x + 0.2 * (v & 1)) + " " + std::to_string(0.2 * (v >> 1 & 1)) + " " +
              std::to_string(0.2 * (v >> 2)) + "\n";
  for (const int first : {1, 9})
    for (const auto& t : {Vector3i(0, 2, 1), Vector3i(1, 2, 3), Vector3i(4, 5, 6), Vector3i(5, 7, 6), Vector3i(0, 1, 4),
                          Vector3i(1, 5, 4), Vector3i(2, 6, 3), Vector3i(3, 6, 7), Vector3i(0, 4, 2), Vector3i(2, 4, 6),
                          Vector3i(1, 3, 5), Vector3i(3, 7, 5)})
      text += "f " + std::to_string(first + t[0]) + " " + std::to_string(first + t[1]) + " " +
              std::to_string(first + t[2]) + "\n";
  make_file(path, text);
}

}  // namespace umax
