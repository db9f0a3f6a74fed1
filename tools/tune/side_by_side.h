// The variants' pictures side by side: a labelled sheet of one moment, and a clip with all in step.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/run/clip.h"
#include "tools/system/progress.h"

namespace umax {

/// A variant whose pictures are there.
struct ShownVariant {
  std::string label;
  std::filesystem::path run;
};

/// How many stand in a row: with several variations the last one's values, so that rows and columns are values of keys;
/// with one, so that the sheet is not much wider than high.
int sheet_columns(int num_variants, const std::vector<int>& num_values);

/// One frame of each variant, labelled below, with a title above all.
void write_sheet(const std::filesystem::path& png, const std::vector<ShownVariant>& variants, int frame, int columns,
                 const std::string& title);

/// All frames of all variants in step, labelled, of an even size. False when a signal stopped it.
bool write_mosaic(const std::filesystem::path& clip, const std::vector<ShownVariant>& variants, int num_frames,
                  int columns, double fps, Progress& progress);

}  // namespace umax
