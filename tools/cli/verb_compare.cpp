#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "render/image/flip.h"
#include "tools/cli/options.h"
#include "tools/cli/picture_set.h"
#include "tools/cli/verb.h"
#include "tools/pages/compare_report.h"
#include "tools/pictures/plot.h"
#include "tools/system/threads.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr double default_max_flip = 0.02;
constexpr int past_threshold = 1;

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

/// What is printed and decided, and where a page goes.
class Judge {
 public:
  explicit Judge(const Options& options)
      : max_flip_(options.max_flip.value_or(default_max_flip)), quiet_(options.quiet) {
    if (options.report) page_ = *options.report;
  }

  double max_flip() const { return max_flip_; }

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

/// How different pictures are in a sequence, as a curve.
std::string curve_of(const std::vector<double>& means, double max_flip) {
  PlotSeries series{.name = "mean FLIP"};
  for (std::size_t i = 0; i < means.size(); ++i) {
    series.x.push_back(double(i + 1));
    series.y.push_back(means[i]);
  }
  Plot plot;
  plot.title = "difference of each picture";
  plot.x.label = "picture";
  plot.x.whole_numbers = true;
  PlotPanel& panel = plot.panels.emplace_back();
  panel.y.label = "mean FLIP [-]";
  panel.y.low = 0;
  panel.series.push_back(std::move(series));
  panel.levels = {{"threshold", max_flip}};
  panel.height = 160;
  return draw_svg(plot);
}

/// Every picture counts for itself: the worst one decides.
int compare_sets(const fs::path& path_a, const fs::path& path_b, const Judge& judge) {
  const PictureSet a(path_a), b(path_b);
  Comparison worst;
  worst.difference.mean = -1;
  double maximum = 0, mean = 0, percentage = 0;
  std::vector<double> means;
  const std::vector<std::string> names = names_of_both(a, b);
  for (const std::string& name : names) {
    Comparison comparison = compare_pictures(a.path_of(name), b.path_of(name));
    const FlipResult& result = comparison.difference;
    judge.print(name + "  ", result.mean, result.maximum, result.percent_above);
    maximum = std::max(maximum, result.maximum);
    mean += result.mean / double(names.size());
    percentage += result.percent_above / double(names.size());
    means.push_back(result.mean);
    if (result.mean > worst.difference.mean) worst = std::move(comparison);
  }
  judge.print("all  ", mean, maximum, percentage);
  if (means.size() > 1) worst.curve = curve_of(means, judge.max_flip());
  return judge.decide(std::move(worst));
}

bool is_many(const fs::path& path) {
  std::error_code error;
  return fs::is_directory(path, error) || is_clip_file(path);
}

int compare(const Options& options) {
  if (options.inputs.size() != 2)
    throw Error(Fault::usage,
                {.what = "umax compare takes two pictures, folders or clips", .remedy = "see umax help compare"});
  const ThreadLimit threads(options.threads);
  const fs::path a = options.inputs[0], b = options.inputs[1];
  const Judge judge(options);
  std::error_code error;
  for (const fs::path& path : {a, b})
    if (!fs::exists(path, error))
      throw Error(Fault::not_found, {.where = path.string(), .what = "does not exist", .remedy = "check the path"});
  if (is_many(a) != is_many(b))
    throw Error(Fault::usage, {.what = "a picture cannot be compared with a folder or a clip",
                               .remedy = "give two pictures, or two of the others"});
  if (is_many(a)) return compare_sets(a, b, judge);

  Comparison comparison = compare_pictures(a, b);
  const FlipResult& result = comparison.difference;
  judge.print("", result.mean, result.maximum, result.percent_above);
  return judge.decide(std::move(comparison));
}

}  // namespace

Verb compare_verb() {
  return {
      .name = "compare",
      .usage = "A B",
      .summary = "image difference: mean FLIP, maximum, percentage",
      .details =
          "Compares two pictures, the pictures of the same names in two folders, or two clips frame by frame (by "
          "ffmpeg). Of many the worst one decides. --report PAGE writes a page that shows it, and how different each "
          "one is. Exit code 0: the mean FLIP is within --max-flip; 1: it is not; 2 or more: the comparison failed.",
      .examples = {"umax compare reference.png frames/0060.png --max-flip 0.05",
                   "umax compare golden/clip.mp4 figure/clip.mp4 --report difference.html"},
      .arguments = {.endings = {"*"}},
      .options = {"--max-flip", "--report", "--threads", "--quiet", "--verbose"},
      .run = compare};
}

}  // namespace umax
