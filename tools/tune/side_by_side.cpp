#include "tools/tune/side_by_side.h"

#include <algorithm>
#include <cmath>

#include "render/annotation/annotate.h"
#include "render/image/image_io.h"
#include "tools/run/run_folder.h"
#include "tools/system/signals.h"

namespace umax {
namespace {

constexpr SheetStyle style{.letter_share = 1.0f / 12};

/// The variants at one frame; what is missing is dark.
Image8 tiles(const std::vector<ShownVariant>& variants, int frame, int columns) {
  std::vector<LabelledImage> images;
  for (const ShownVariant& variant : variants)
    images.push_back({read_png8(picture_path(variant.run, frame)), variant.label});
  return contact_sheet(images, columns, style);
}

/// A copy with room of the sheet's own dark colour above and, where asked, to the right and below.
Image8 with_margin(const Image8& image, int above, int right, int below) {
  Image8 out(image.width + right, image.height + above + below, 3);
  for (std::size_t i = 0; i < out.values.size(); ++i) out.values[i] = image.values[i % 3];
  for (int y = 0; y < image.height; ++y) std::copy_n(image.pixel(0, y), 3 * image.width, out.pixel(0, y + above));
  return out;
}

}  // namespace

int sheet_columns(int num_variants, const std::vector<int>& num_values) {
  constexpr int most_columns = 10;
  if (num_values.size() > 1 && num_values.back() > 1 && num_values.back() <= most_columns) return num_values.back();
  if (num_variants <= 4) return std::max(1, num_variants);
  return int(std::ceil(std::sqrt(1.5 * num_variants)));
}

void write_sheet(const std::filesystem::path& png, const std::vector<ShownVariant>& variants, int frame, int columns,
                 const std::string& title) {
  const Image8 sheet = tiles(variants, frame, columns);
  const int letter = std::max(14, sheet.height / 30), above = 2 * letter;
  Image8 titled = with_margin(sheet, above, 0, 0);
  draw_label(titled, title, 0.6f * float(letter) / float(titled.width), 0.6f * float(letter) / float(titled.height),
             {.size = float(letter) / float(titled.height), .backed = false});
  write_png(png, titled);
}

bool write_mosaic(const std::filesystem::path& clip, const std::vector<ShownVariant>& variants, int num_frames,
                  int columns, double fps, Progress& progress) {
  const Image8 first = tiles(variants, 1, columns);
  const int right = first.width % 2, below = first.height % 2;
  progress.begin("mosaic", num_frames);
  const auto picture = [&](std::size_t index) {
    if (stop_signal() != 0) return std::string();
    const int frame = int(index) + 1;
    const std::string png = encode_png(with_margin(tiles(variants, frame, columns), 0, right, below));
    progress.frame_done(frame);
    return png;
  };
  try {
    encode_clip(clip, std::size_t(num_frames), picture,
                {.fps = fps, .width = first.width + right, .height = first.height + below});
  } catch (const std::exception&) {
    if (stop_signal() == 0) throw;
  }
  progress.end();
  return stop_signal() == 0;
}

}  // namespace umax
