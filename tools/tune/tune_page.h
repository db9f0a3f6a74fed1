// tune.html: one file that shows all variants in step, needs no other and no network.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/tune/measures.h"

namespace umax {

struct PageVariant {
  std::string name, label, snippet, aim;
  std::vector<std::string> values;  // one of each varied key
  int exit_code = 0;
  std::string failure;  // when it has no pictures
  VariantMeasures measures{};
  std::vector<std::string> frames{};  // WebP; empty when it failed
};

struct TunePage {
  std::string title, summary, made_by;
  std::vector<std::string> keys;  // short, varied
  int columns = 1, num_frames = 0, worst_frame = 1, substeps = 1;
  double fps = 60;
  int width = 0, height = 0;  // [px] of the embedded pictures
  std::vector<PageVariant> variants;
};

/// The plotting library that goes into the page, read from where Debian's libjs-chart.js puts it, or from the folder
/// that the environment's UMAX_JAVASCRIPT names. Throws Error (unavailable) with the remedy when it is not there.
std::string plotting_library();

/// Throws Error (unavailable) unless ffmpeg has the encoder of the page's pictures.
void require_page_encoder();

/// Size [px] at which this many pictures in all keep the page below 25 MB: their own where that fits.
void fit_page_pictures(int& width, int& height, long long num_pictures);

/// The frames of a run as WebP at this size. Throws Error when a picture cannot be read or encoded.
std::vector<std::string> page_frames(const std::filesystem::path& run, int num_frames, int width, int height);

std::string tune_page_html(const TunePage& page, const std::string& library);

/// The numbers of the page, for scripts: tune.json.
std::string tune_record(const TunePage& page);

}  // namespace umax
