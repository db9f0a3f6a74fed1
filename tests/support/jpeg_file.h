// JPEG files for tests, as libjpeg writes them.
#pragma once

#include <string>
#include <vector>

namespace umax::test {

struct JpegSample {
  int width = 0, height = 0;
  int channels = 3;                   // 1, 3, or 4 for inks, inverted as Adobe's programs write them
  std::vector<unsigned char> values;  // (y * width + x) * channels + c
  bool progressive = false;
};

/// The file's bytes, of the best quality.
std::string jpeg_bytes(const JpegSample& sample);

/// The left half of one colour, the right half of another, both (r, g, b).
JpegSample two_colors(int width, int height, const std::vector<unsigned char>& left,
                      const std::vector<unsigned char>& right);

}  // namespace umax::test
