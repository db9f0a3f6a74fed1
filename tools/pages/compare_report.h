// A page that shows how a picture differs from its reference: both, the difference, and how to accept the new one; of many
// pictures the worst.
#pragma once

#include <filesystem>
#include <string>

#include "render/image/flip.h"

namespace umax {

struct Comparison {
  std::string name;          // headline
  Image8 reference, result;  // of one size, RGB
  FlipResult difference;
  std::string verdict;         // one sentence: what was exceeded, or that all is well
  std::string curve = {};      // SVG of how different each of many pictures is; empty: there is one
  std::string update_command;  // copied into a shell, it makes the result the new reference; empty: none
};

/// A picture file as it is looked at. Throws Error (not_found, bad_data).
Image8 read_for_eyes(const std::filesystem::path& path);

/// Writes one HTML file that needs no other: pictures are inside as PNG. Throws Error 73, 74.
void write_compare_report(const std::filesystem::path& path, const Comparison& comparison);

}  // namespace umax
