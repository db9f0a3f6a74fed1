#include <cmath>
#include <cstdio>

#include "render/image/image_codecs.h"

// Radiance RGBE pictures: a text header, then scanlines of (r, g, b, exponent), run-length coded per component.
namespace umax::codec {
namespace {

std::string_view take_line(std::string_view& rest, const std::string& name) {
  const auto end = rest.find('\n');
  if (end == std::string_view::npos) fail_data(name, "is a damaged HDR picture (the header does not end)");
  const std::string_view line = rest.substr(0, end);
  rest.remove_prefix(end + 1);
  return line;
}

unsigned take_byte(std::string_view& rest, const std::string& name) {
  if (rest.empty()) fail_data(name, "is a damaged HDR picture (it ends early)");
  const unsigned byte = static_cast<unsigned char>(rest.front());
  rest.remove_prefix(1);
  return byte;
}

/// One component of a scanline: runs (128 + length, value) and literal stretches (length, values…).
void take_component(std::string_view& rest, std::vector<unsigned char>& line, int component, int width,
                    const std::string& name) {
  for (int x = 0; x < width;) {
    const unsigned code = take_byte(rest, name);
    const bool run = code > 128;
    const int length = int(run ? code - 128 : code);
    if (length == 0 || x + length > width) fail_data(name, "is a damaged HDR picture (a run leaves its row)");
    const unsigned value = run ? take_byte(rest, name) : 0;
    for (int i = 0; i < length; ++i, ++x)
      line[4 * x + component] = (unsigned char)(run ? value : take_byte(rest, name));
  }
}

void take_scanline(std::string_view& rest, std::vector<unsigned char>& line, int width, const std::string& name) {
  const bool coded =
      width >= 8 && width < 32768 && rest.size() >= 4 && rest[0] == 2 && rest[1] == 2 && !(rest[2] & 0x80);
  if (coded) {
    rest.remove_prefix(4);
    for (int component = 0; component < 4; ++component) take_component(rest, line, component, width, name);
    return;
  }
  for (int i = 0; i < 4 * width; ++i) line[i] = (unsigned char)take_byte(rest, name);
}

}  // namespace

bool is_hdr(std::string_view bytes) {
  return bytes.substr(0, 10) == "#?RADIANCE" || bytes.substr(0, 6) == "#?RGBE";
}

Image decode_hdr(std::string_view bytes, const std::string& name) {
  std::string_view rest = bytes;
  while (!take_line(rest, name).empty()) {
  }
  const std::string size(take_line(rest, name));
  int width = 0, height = 0;
  if (std::sscanf(size.c_str(), "-Y %d +X %d", &height, &width) != 2)
    fail_data(name, "is an HDR picture of an unusual orientation (\"" + size + "\")");
  if (width < 1 || height < 1 || width > max_extent || height > max_extent ||
      std::size_t(width) * height > std::min(max_pixels, bytes.size() * 64))
    fail_data(name, "is a damaged HDR picture (size \"" + size + "\")");

  Image image(width, height, 3);
  std::vector<unsigned char> line(4 * std::size_t(width));
  for (int y = 0; y < height; ++y) {
    take_scanline(rest, line, width, name);
    for (int x = 0; x < width; ++x) {
      const unsigned char* rgbe = &line[4 * x];
      const float scale = rgbe[3] == 0 ? 0.0f : std::ldexp(1.0f, int(rgbe[3]) - 136);
      for (int c = 0; c < 3; ++c) image.pixel(x, y)[c] = (float(rgbe[c]) + 0.5f) * scale;
    }
  }
  return image;
}

}  // namespace umax::codec
