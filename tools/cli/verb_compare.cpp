#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "render/image/flip.h"
#include "render/image/image_io.h"
#include "render/image/tone_map.h"
#include "tools/cli/options.h"
#include "tools/cli/verb.h"
#include "tools/pages/compare_report.h"
#include "tools/system/threads.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr double default_max_flip = 0.02;
constexpr int past_threshold = 1;

Image8 read_for_eyes(const fs::path& path) {
  if (path.extension() == ".png" || path.extension() == ".PNG") return read_png8(path);
  return tone_map(read_image(path), {.curve = ToneCurve::standard});
}

/// Two pictures and how they differ.
Comparison compare_pictures(const fs::path& a, const fs::path& b) {
  Image8 reference = read_for_eyes(a), test = read_for_eyes(b);
  if (reference.width != test.width || reference.height != test.height)
    throw Error(Fault::bad_data,
                {.where = b.string(),
                 .what = fmt::format("has another size than {}", a.string()),
                 .value = fmt::format("{}x{} and {}x{}", test.width, test.height, reference.width, reference.height),
                 .remedy = "render both at one size (--size)"});
  Comparison comparison;
  comparison.name = a.filename().string();
  comparison.difference = flip(reference, test);
  comparison.reference = std::move(reference);
  comparison.result = std::move(test);
  return comparison;
}

bool is_picture(const fs::path& path) {
  return path.extension() == ".png" || path.extension() == ".exr";
}

/// Names of the pictures in a folder; a run's folder stands for its frames.
std::vector<std::string> picture_names(fs::path& folder) {
  std::error_code error;
  if (fs::is_directory(folder / "frames", error)) folder /= "frames";
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (is_picture(entry.path())) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  if (names.empty())
    throw Error(Fault::not_found, {.where = folder.string(),
                                   .what = "holds no pictures",
                                   .remedy = "give two pictures, or two folders with pictures of the same names"});
  return names;
}

void require_same_names(const fs::path& a, const std::vector<std::string>& names_a, const fs::path& b,
                        const std::vector<std::string>& names_b) {
  const auto find_missing = [](const fs::path& folder, const std::vector<std::string>& here,
                               const std::vector<std::string>& there) {
    for (const std::string& name : there)
      if (!std::binary_search(here.begin(), here.end(), name))
        throw Error(Fault::not_found, {.where = (folder / name).string(),
                                       .what = "does not exist, but the other folder has it",
                                       .remedy = "render the same frames and kinds of pictures in both"});
  };
  find_missing(b, names_b, names_a);
  find_missing(a, names_a, names_b);
}

/// What is printed and decided, and where a page goes.
class Judge {
 public:
  explicit Judge(const Options& options)
      : max_flip_(options.max_flip.value_or(default_max_flip)), quiet_(options.quiet) {
    if (options.report) page_ = *options.report;
  }

  void print(const std::string& label, double mean, double maximum, double percentage) const {
    if (!quiet_)
      fmt::print("{}mean FLIP {:.6f}  maximum {:.6f}  pixels above 0.1: {:.3f} %\n", label, mean, maximum, percentage);
  }

  /// Says whether the comparison is within the threshold, writes the page, and returns the exit code.
  int decide(Comparison comparison) const {
    const double mean = comparison.difference.mean;
    const bool within = mean <= max_flip_;
    comparison.verdict =
        fmt::format("mean FLIP {:.6f} is {} {}", mean, within ? "within" : "past the threshold of", max_flip_);
    if (!quiet_) fmt::print("{}: {}\n", comparison.name, comparison.verdict);
    if (!page_.empty()) write_compare_report(page_, comparison);
    return within ? 0 : past_threshold;
  }

 private:
  double max_flip_;
  bool quiet_;
  fs::path page_;
};

/// Every picture counts for itself: the worst one decides.
int compare_folders(fs::path a, fs::path b, const Judge& judge) {
  const auto names_a = picture_names(a), names_b = picture_names(b);
  require_same_names(a, names_a, b, names_b);
  Comparison worst;
  worst.difference.mean = -1;
  double maximum = 0, mean = 0, percentage = 0;
  for (const std::string& name : names_a) {
    Comparison comparison = compare_pictures(a / name, b / name);
    const FlipResult& result = comparison.difference;
    judge.print(name + "  ", result.mean, result.maximum, result.percent_above);
    maximum = std::max(maximum, result.maximum);
    mean += result.mean / double(names_a.size());
    percentage += result.percent_above / double(names_a.size());
    if (result.mean > worst.difference.mean) worst = std::move(comparison);
  }
  judge.print("all  ", mean, maximum, percentage);
  return judge.decide(std::move(worst));
}

int compare(const Options& options) {
  if (options.inputs.size() != 2)
    throw Error(Fault::usage,
                {.what = "umax compare takes two pictures or two folders", .remedy = "see umax help compare"});
  const ThreadLimit threads(options.threads);
  const fs::path a = options.inputs[0], b = options.inputs[1];
  const Judge judge(options);
  std::error_code error;
  for (const fs::path& path : {a, b})
    if (!fs::exists(path, error))
      throw Error(Fault::not_found, {.where = path.string(), .what = "does not exist", .remedy = "check the path"});
  if (fs::is_directory(a, error) != fs::is_directory(b, error))
    throw Error(Fault::usage,
                {.what = "a picture cannot be compared with a folder", .remedy = "give two pictures, or two folders"});
  if (fs::is_directory(a, error)) return compare_folders(a, b, judge);

  Comparison comparison = compare_pictures(a, b);
  const FlipResult& result = comparison.difference;
  judge.print("", result.mean, result.maximum, result.percent_above);
  return judge.decide(std::move(comparison));
}

}  // namespace

Verb compare_verb() {
  return {.name = "compare",
          .usage = "A B",
          .summary = "image difference: mean FLIP, maximum, percentage",
          .details =
              "Compares two pictures, or the pictures of the same names in two folders. Exit code 0: the mean FLIP is "
              "within --max-flip; 1: it is not; 2 or more: the comparison failed.",
          .examples = {"umax compare reference.png frames/0060.png --max-flip 0.05"},
          .arguments = {.endings = {"*"}},
          .options = {"--max-flip", "--report", "--threads", "--quiet", "--verbose"},
          .run = compare};
}

}  // namespace umax
