#include "tests/support/jpeg_file.h"

// jpeglib.h wants them first
#include <cstddef>
#include <cstdio>
//
#include <jpeglib.h>

#include <cstdlib>

namespace umax::test {

std::string jpeg_bytes(const JpegSample& sample) {
  jpeg_error_mgr errors{};
  jpeg_compress_struct jpeg{};
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &bytes, &size);
  jpeg.image_width = unsigned(sample.width);
  jpeg.image_height = unsigned(sample.height);
  jpeg.input_components = sample.channels;
  jpeg.in_color_space = sample.channels == 1 ? JCS_GRAYSCALE : sample.channels == 3 ? JCS_RGB : JCS_CMYK;
  jpeg_set_defaults(&jpeg);
  if (sample.channels == 4) jpeg_set_colorspace(&jpeg, JCS_YCCK);
  jpeg_set_quality(&jpeg, 100, TRUE);
  for (int c = 0; c < sample.channels; ++c) jpeg.comp_info[c].h_samp_factor = jpeg.comp_info[c].v_samp_factor = 1;
  if (sample.progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  const int stride = sample.width * sample.channels;
  while (jpeg.next_scanline < jpeg.image_height) {
    JSAMPROW row = const_cast<JSAMPROW>(&sample.values[std::size_t(jpeg.next_scanline) * std::size_t(stride)]);
    jpeg_write_scanlines(&jpeg, &row, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  std::string result(reinterpret_cast<const char*>(bytes), size);
  std::free(bytes);
  return result;
}

JpegSample two_colors(int width, int height, const std::vector<unsigned char>& left,
                      const std::vector<unsigned char>& right) {
  JpegSample sample{.width = width, .height = height, .channels = int(left.size()), .values = {}};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto& color = 2 * x < width ? left : right;
      sample.values.insert(sample.values.end(), color.begin(), color.end());
    }
  return sample;
}

}  // namespace umax::test
