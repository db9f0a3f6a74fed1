#include "render/image/image_io.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/srgb.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "render/image/image_codecs.h"
#include "render/image/srgb_code.h"

namespace umax {
namespace {

Image image_from_codes(const codec::Codes& codes, PngValues png_values) {
  Image image(codes.width, codes.height, codes.channels);
  const int highest = (1 << codes.bits) - 1;
  const int num_colors = codes.channels >= 3 ? 3 : 1;
  // every code has one value: a table is exact and fast
  std::vector<float> table(std::size_t(highest) + 1);
  for (int code = 0; code <= highest; ++code) {
    const float stored = float(code) / float(highest);
    table[code] = png_values == PngValues::linear ? linear_from_srgb(stored) : stored;
  }
  for (std::size_t i = 0; i < codes.values.size(); ++i) {
    const bool is_color = int(i % codes.channels) < num_colors;
    image.values[i] = is_color ? table[codes.values[i]] : float(codes.values[i]) / float(highest);
  }
  return image;
}

Image colors_of(std::vector<Layer> layers, const std::string& name) {
  Image& image = layers.front().image;
  if (image.channels == 2) codec::fail_data(name, "has two channels where a picture has one, three or four");
  return std::move(image);
}

}  // namespace

Image read_image(const std::filesystem::path& path, PngValues png_values) {
  return decode_image(read_file(path), path.string(), png_values);
}

Image decode_image(std::string_view bytes, const std::string& name, PngValues png_values) {
  if (codec::is_jpeg(bytes)) return image_from_codes(codec::decode_jpeg(bytes, name), png_values);
  if (codec::is_png(bytes)) return image_from_codes(codec::decode_png(bytes, name), png_values);
  if (codec::is_exr(bytes)) return colors_of(codec::decode_exr(bytes, name), name);
  if (codec::is_hdr(bytes)) return codec::decode_hdr(bytes, name);
  codec::fail_data(name, bytes.empty() ? "is empty" : "is no picture of a known format");
}

std::vector<Layer> read_exr(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  if (!codec::is_exr(bytes)) codec::fail_data(path.string(), "is no OpenEXR file");
  return codec::decode_exr(bytes, path.string());
}

Image8 read_png8(const std::filesystem::path& path) {
  const std::string bytes = read_file(path);
  if (!codec::is_png(bytes)) codec::fail_data(path.string(), "is no PNG file");
  const codec::Codes codes = codec::decode_png(bytes, path.string());
  Image8 image(codes.width, codes.height, codes.channels);
  std::transform(codes.values.begin(), codes.values.end(), image.values.begin(), [&](std::uint16_t code) {
    return std::uint8_t(codes.bits == 8 ? code : (unsigned(code) * 255u + 32767u) / 65535u);
  });
  return image;
}

void write_png(const std::filesystem::path& path, const Image8& image, PngEffort effort) {
  write_file(path, encode_png(image, effort));
}

void write_png(const std::filesystem::path& path, const Image& linear) {
  Image8 image(linear.width, linear.height, linear.channels);
  const SrgbCodes codes;
  for (std::size_t i = 0; i < linear.values.size(); ++i) {
    const bool is_alpha = linear.channels == 4 && i % 4 == 3;
    image.values[i] = is_alpha ? byte_from_unit(linear.values[i]) : codes(linear.values[i]);
  }
  write_png(path, image);
}

void write_exr(const std::filesystem::path& path, const std::vector<Layer>& layers, const ExrHeader& header) {
  write_file(path, codec::encode_exr(layers, header, path.string()));
}

void write_image(const std::filesystem::path& path, const Image& linear) {
  if (path.extension() == ".exr") return write_exr(path, {{"", linear}});
  if (path.extension() == ".png") return write_png(path, linear);
  throw Error(Fault::usage, {path.string(), "unknown kind of picture", path.extension().string(), "use .png or .exr"});
}

}  // namespace umax
