// jpeglib.h wants them first
#include <cstddef>
#include <cstdio>
//
#include <jerror.h>
#include <jpeglib.h>

#include <csetjmp>

#include "render/image/image_codecs.h"

// libjpeg reports errors by a function that must not return: everything with a destructor lives outside the function
// that calls setjmp.
namespace umax::codec {
namespace {

struct JpegReader {
  jpeg_error_mgr errors;  // first: libjpeg hands back its address
  jmp_buf give_up;
  Codes codes;
  std::vector<JSAMPLE> row;
  char message[JMSG_LENGTH_MAX] = "";
};

JpegReader& reader_of(j_common_ptr jpeg) {
  return *reinterpret_cast<JpegReader*>(jpeg->err);
}

[[noreturn]] void on_error(j_common_ptr jpeg) {
  JpegReader& reader = reader_of(jpeg);
  jpeg->err->format_message(jpeg, reader.message);
  std::longjmp(reader.give_up, 1);
}

/// libjpeg only warns of a file that ends early, and makes up the rest.
void on_message(j_common_ptr jpeg, int level) {
  const int code = jpeg->err->msg_code;
  if (level < 0 && (code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER)) on_error(jpeg);
}

/// Of four inks as Adobe's programs write them, inverted or not, the colour on white paper.
void mix_inks(const JSAMPLE* inks, bool inverted, std::uint16_t* color) {
  const int black = inverted ? inks[3] : 255 - inks[3];
  for (int c = 0; c < 3; ++c) color[c] = std::uint16_t((inverted ? inks[c] : 255 - inks[c]) * black / 255);
}

/// Of the component that is not subsampled no block of 8 x 8 numbers takes less than a bit; there are up to four.
constexpr std::size_t most_per_byte = 8 * 64 * 4;

void read_rows(std::size_t file_bytes, jpeg_decompress_struct& jpeg, JpegReader& reader) {
  jpeg_read_header(&jpeg, TRUE);
  const std::size_t numbers = std::size_t(jpeg.image_width) * jpeg.image_height * std::size_t(jpeg.num_components);
  if (!can_hold(file_bytes, numbers, most_per_byte)) ERREXIT(&jpeg, JERR_INPUT_EOF);
  if (std::size_t(jpeg.image_width) * jpeg.image_height > max_pixels)
    ERREXIT1(&jpeg, JERR_IMAGE_TOO_BIG, unsigned(max_extent));
  const bool inks = jpeg.num_components == 4;
  jpeg.out_color_space = inks ? JCS_CMYK : jpeg.num_components == 1 ? JCS_GRAYSCALE : JCS_RGB;
  jpeg_start_decompress(&jpeg);
  Codes& codes = reader.codes;
  codes.width = int(jpeg.output_width);
  codes.height = int(jpeg.output_height);
  codes.channels = jpeg.num_components == 1 ? 1 : 3;
  codes.values.resize(std::size_t(codes.width) * codes.height * codes.channels);
  reader.row.resize(std::size_t(codes.width) * jpeg.output_components);
  for (std::size_t at = 0; jpeg.output_scanline < jpeg.output_height;) {
    JSAMPROW row = reader.row.data();
    jpeg_read_scanlines(&jpeg, &row, 1);
    for (int x = 0; x < codes.width; ++x, at += codes.channels)
      if (inks)
        mix_inks(row + 4 * x, jpeg.saw_Adobe_marker, &codes.values[at]);
      else
        for (int c = 0; c < codes.channels; ++c) codes.values[at + c] = row[codes.channels * x + c];
  }
  jpeg_finish_decompress(&jpeg);
}

bool run_reader(std::string_view bytes, jpeg_decompress_struct& jpeg, JpegReader& reader) {
  if (setjmp(reader.give_up)) return false;
  jpeg_create_decompress(&jpeg);
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), (unsigned long)(bytes.size()));
  read_rows(bytes.size(), jpeg, reader);
  return true;
}

}  // namespace

bool is_jpeg(std::string_view bytes) {
  return bytes.starts_with("\xff\xd8\xff");
}

Codes decode_jpeg(std::string_view bytes, const std::string& name) {
  JpegReader reader{};
  jpeg_decompress_struct jpeg{};
  jpeg.err = jpeg_std_error(&reader.errors);
  reader.errors.error_exit = on_error;
  reader.errors.emit_message = on_message;
  const bool whole = run_reader(bytes, jpeg, reader);
  jpeg_destroy_decompress(&jpeg);
  if (!whole) fail_data(name, std::string("is a damaged JPEG (") + reader.message + ")");
  return std::move(reader.codes);
}

}  // namespace umax::codec
