#include <png.h>

#include <csetjmp>
#include <cstring>

#include "render/image/image_codecs.h"

// libpng reports errors by longjmp: everything with a destructor lives outside the functions that call setjmp.
namespace umax {
namespace {

constexpr std::size_t most_deflated = 1032;  // bytes that one byte of a deflated stream can stand for

struct PngReader {
  std::string_view rest;
  std::size_t file_bytes = 0;
  codec::Codes codes;
  std::vector<png_byte> samples;
  std::vector<png_bytep> rows;
  char message[128] = "";
};

void keep_message(char* message, png_const_charp text) {
  std::strncpy(message, text, 127);
}

void on_read_error(png_structp png, png_const_charp text) {
  keep_message(static_cast<PngReader*>(png_get_error_ptr(png))->message, text);
  png_longjmp(png, 1);
}
void on_write_error(png_structp png, png_const_charp text) {
  keep_message(static_cast<char*>(png_get_error_ptr(png)), text);
  png_longjmp(png, 1);
}
void ignore_warning(png_structp, png_const_charp) {}

void read_bytes(png_structp png, png_bytep out, std::size_t count) {
  auto& reader = *static_cast<PngReader*>(png_get_io_ptr(png));
  if (count > reader.rest.size()) png_error(png, "the file ends early");
  std::memcpy(out, reader.rest.data(), count);
  reader.rest.remove_prefix(count);
}
void append_bytes(png_structp png, png_bytep data, std::size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(data), count);
}
void flush_nothing(png_structp) {}

/// Asks libpng for 8 or 16 bit grey, RGB or RGBA and makes room for it.
void prepare_rows(png_structp png, png_infop info, PngReader& reader) {
  png_read_info(png, info);
  if (!codec::can_hold(reader.file_bytes, png_get_rowbytes(png, info) * png_get_image_height(png, info), most_deflated))
    png_error(png, "it promises more pixels than it can hold");
  png_set_expand(png);
  if (png_get_color_type(png, info) == PNG_COLOR_TYPE_GRAY_ALPHA) png_set_gray_to_rgb(png);
  if (png_get_bit_depth(png, info) == 16) png_set_swap(png);
  const int num_passes = png_set_interlace_handling(png);
  (void)num_passes;  // png_read_image() makes the passes
  png_read_update_info(png, info);
  codec::Codes& codes = reader.codes;
  codes.width = int(png_get_image_width(png, info));
  codes.height = int(png_get_image_height(png, info));
  codes.channels = png_get_channels(png, info);
  codes.bits = png_get_bit_depth(png, info);
  if (codes.channels == 2) png_error(png, "grey with alpha cannot be used");
  if (std::size_t(codes.width) * codes.height > codec::max_pixels) png_error(png, "absurdly large");
  const std::size_t row_bytes = png_get_rowbytes(png, info);
  reader.samples.resize(row_bytes * codes.height);
  reader.rows.resize(codes.height);
  for (int y = 0; y < codes.height; ++y) reader.rows[y] = reader.samples.data() + row_bytes * y;
}

bool run_reader(png_structp png, png_infop info, PngReader& reader) {
  if (setjmp(png_jmpbuf(png))) return false;
  png_set_user_limits(png, codec::max_extent, codec::max_extent);
  png_set_read_fn(png, &reader, read_bytes);
  prepare_rows(png, info, reader);
  png_read_image(png, reader.rows.data());
  png_read_end(png, nullptr);
  return true;
}

/// The quick way leaves out the library's search for each row's best filter, which takes most of the time.
void set_effort(png_structp png, PngEffort effort) {
  png_set_compression_level(png, effort == PngEffort::small_file ? 6 : 1);
  if (effort == PngEffort::little_time) png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB);
}

bool run_writer(png_structp png, png_infop info, const Image8& image, PngEffort effort, std::string& bytes) {
  if (setjmp(png_jmpbuf(png))) return false;
  const int color_type = image.channels == 1   ? PNG_COLOR_TYPE_GRAY
                         : image.channels == 4 ? PNG_COLOR_TYPE_RGB_ALPHA
                                               : PNG_COLOR_TYPE_RGB;
  png_set_write_fn(png, &bytes, append_bytes, flush_nothing);
  set_effort(png, effort);
  png_set_IHDR(png, info, png_uint_32(image.width), png_uint_32(image.height), 8, color_type, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_sRGB(png, info, PNG_sRGB_INTENT_PERCEPTUAL);
  png_write_info(png, info);
  for (int y = 0; y < image.height; ++y) png_write_row(png, image.pixel(0, y));
  png_write_end(png, nullptr);
  return true;
}

}  // namespace

namespace codec {

bool is_png(std::string_view bytes) {
  return bytes.substr(0, 8) == std::string_view("\x89PNG\r\n\x1a\n", 8);
}

Codes decode_png(std::string_view bytes, const std::string& name) {
  PngReader reader;
  reader.rest = bytes;
  reader.file_bytes = bytes.size();
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, &reader, on_read_error, ignore_warning);
  png_infop info = png_create_info_struct(png);
  const bool whole = run_reader(png, info, reader);
  png_destroy_read_struct(&png, &info, nullptr);
  if (!whole) fail_data(name, std::string("is a damaged PNG (") + reader.message + ")");

  const std::size_t count = std::size_t(reader.codes.width) * reader.codes.height * reader.codes.channels;
  reader.codes.values.resize(count);
  if (reader.codes.bits == 16) {
    std::memcpy(reader.codes.values.data(), reader.samples.data(), 2 * count);
  } else {
    std::copy(reader.samples.begin(), reader.samples.end(), reader.codes.values.begin());
  }
  return std::move(reader.codes);
}

}  // namespace codec

std::string encode_png(const Image8& image, PngEffort effort) {
  std::string bytes;
  char message[128] = "";
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, message, on_write_error, ignore_warning);
  png_infop info = png_create_info_struct(png);
  const bool whole = run_writer(png, info, image, effort, bytes);
  png_destroy_write_struct(&png, &info);
  if (!whole) throw Error(Fault::internal, {"PNG", message, "", ""});
  return bytes;
}

}  // namespace umax
