#include "tools/tune/tune_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "tools/pages/html.h"
#include "tools/run/run_folder.h"
#include "tools/system/subprocess.h"

namespace umax {

// Written by CMake into the build folder from page.html, page.css, page.js.
extern const std::pair<const char*, const char*> embedded_tune_page[];

namespace fs = std::filesystem;
namespace {

constexpr double most_pixels =
    110e6;  // of all pictures: at most some 0.16 bytes each in WebP, a third more in the page

const char* embedded(const std::string& name) {
  for (std::size_t i = 0;; ++i)
    if (name == embedded_tune_page[i].first) return embedded_tune_page[i].second;
}

/// Five significant digits: more would only be bytes.
nlohmann::json rounded(double value) {
  if (!std::isfinite(value)) return nullptr;
  return std::strtod(fmt::format("{:.5g}", value).c_str(), nullptr);
}

/// One value a frame of a column that has one a step: the largest of its steps, or the last.
nlohmann::json per_frame(const TunePage& page, const StepsFound& steps, const std::string& column, bool largest) {
  nlohmann::json values = nlohmann::json::array();
  const std::vector<double>& all = steps.columns.at(column);
  // of the initial state there is no row: what the first step starts from is close to what it ends with
  values.push_back(all.empty() ? nlohmann::json(nullptr) : rounded(largest ? 0 : all.front()));
  for (std::size_t begin = 0; begin < all.size(); begin += std::size_t(page.substeps)) {
    const auto first = all.begin() + std::ptrdiff_t(begin);
    const auto last = all.begin() + std::ptrdiff_t(std::min(all.size(), begin + std::size_t(page.substeps)));
    values.push_back(rounded(largest ? *std::max_element(first, last) : *(last - 1)));
  }
  return values;
}

nlohmann::ordered_json numbers_of(const PageVariant& variant) {
  nlohmann::ordered_json json;
  json["name"] = variant.name;
  json["label"] = variant.label;
  json["values"] = variant.values;
  json["exit_code"] = variant.exit_code;
  json["failure"] = variant.failure;
  json["snippet"] = variant.snippet;
  json["aim"] = variant.aim;
  if (variant.frames.empty()) return json;
  const VariantMeasures& measures = variant.measures;
  json["hexes"] = measures.hexes;
  json["largest_ratio"] = rounded(measures.largest_ratio);
  json["largest_stretch"] = rounded(measures.largest_stretch);
  json["least_height"] = rounded(measures.least_height);
  json["least_share"] = rounded(measures.least_share);
  json["most_limits"] = measures.most_limits;
  json["steps_not_converged"] = measures.steps_not_converged;
  json["wall_seconds"] = rounded(measures.wall_seconds);
  return json;
}

nlohmann::ordered_json header_of(const TunePage& page) {
  nlohmann::ordered_json json;
  json["program"] = "umax tune";
  json["title"] = page.title;
  json["summary"] = page.summary;
  json["made_by"] = page.made_by;
  json["keys"] = page.keys;
  json["frames"] = page.num_frames;
  json["worst"] = page.worst_frame;
  json["fps"] = page.fps;
  return json;
}

std::string data_of(const TunePage& page) {
  nlohmann::ordered_json json = header_of(page);
  json["columns"] = page.columns;
  json["width"] = page.width;
  json["height"] = page.height;
  json["variants"] = nlohmann::json::array();
  for (const PageVariant& variant : page.variants) {
    nlohmann::ordered_json entry = numbers_of(variant);
    entry["frames"] = nlohmann::json::array();
    for (const std::string& frame : variant.frames) entry["frames"].push_back(base64(frame));
    if (!variant.frames.empty()) {
      const StepsFound& steps = variant.measures.steps;
      entry["lowest_body"] = variant.measures.lowest_body;
      std::vector<nlohmann::json> shares;
      for (const double share : variant.measures.shares) shares.push_back(rounded(share));
      entry["series"]["shares"] = shares;
      entry["series"]["ratio"] = per_frame(page, steps, "max_energy_ratio", true);
      entry["series"]["limits"] = per_frame(page, steps, "limits_active", true);
      for (const char* kind : {"elastic", "kinetic", "potential"})
        entry["series"][kind] = per_frame(page, steps, std::string(kind) + "_energy_J", false);
    }
    json["variants"].push_back(std::move(entry));
  }
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/// One WebP file after the other: each says how long it is.
std::vector<std::string> split_webp(const std::string& bytes) {
  std::vector<std::string> files;
  for (std::size_t begin = 0; begin + 12 <= bytes.size() && bytes.compare(begin, 4, "RIFF") == 0;) {
    std::uint32_t length = 0;
    for (int i = 3; i >= 0; --i) length = length << 8 | static_cast<unsigned char>(bytes[begin + 4 + std::size_t(i)]);
    files.push_back(bytes.substr(begin, length + 8));
    begin += length + 8;
  }
  return files;
}

}  // namespace

std::string plotting_library() {
  const char* folder = std::getenv("UMAX_JAVASCRIPT");
  const fs::path start = folder && *folder ? folder : "/usr/share/javascript/chart.js";
  std::error_code error;
  for (const char* name : {"chart.min.js", "chart.umd.min.js", "chart.umd.js", "chart.js"}) {
    if (!fs::is_regular_file(start / name, error)) continue;
    std::string library = read_file(start / name);
    if (library.find("export{") != std::string::npos || library.find("export {") != std::string::npos) continue;
    replace_all(library, "</script", "<\\/script");
    replace_all(library, "//# sourceMappingURL=", "// ");
    return library;
  }
  throw Error(Fault::unavailable, {.where = start.string(),
                                   .what = "holds no Chart.js, which draws the plots of the page",
                                   .remedy = "install it (apt-get install libjs-chart.js), or name its folder in "
                                             "the environment variable UMAX_JAVASCRIPT"});
}

void require_page_encoder() {
  const ProcessResult encoders = run_process({"ffmpeg", "-hide_banner", "-loglevel", "error", "-encoders"});
  if (encoders.output.find(" libwebp ") == std::string::npos)
    throw Error(Fault::unavailable, {.where = "ffmpeg",
                                     .what = "has no WebP encoder (libwebp)",
                                     .remedy = "install Debian's (apt-get install ffmpeg)"});
}

void fit_page_pictures(int& width, int& height, long long num_pictures) {
  const double pixels = double(width) * height * double(std::max(1LL, num_pictures));
  if (pixels <= most_pixels) return;
  const double scale = std::max(std::sqrt(most_pixels / pixels), std::min(1.0, 120.0 / width));
  width = std::max(16, 2 * int(scale * width / 2));
  height = std::max(16, 2 * int(scale * height / 2));
}

std::vector<std::string> page_frames(const fs::path& run, int num_frames, int width, int height) {
  const auto next_picture = [&, frame = 1]() mutable {
    return frame > num_frames ? std::string() : read_file(picture_path(run, frame++));
  };
  const ProcessResult result = run_process({"ffmpeg",
                                            "-nostdin",
                                            "-loglevel",
                                            "error",
                                            "-f",
                                            "image2pipe",
                                            "-c:v",
                                            "png",
                                            "-i",
                                            "pipe:0",
                                            "-vf",
                                            fmt::format("scale={}:{}:flags=lanczos", width, height),
                                            "-c:v",
                                            "libwebp",
                                            "-quality",
                                            "82",
                                            "-compression_level",
                                            "3",
                                            "-fflags",
                                            "+bitexact",
                                            "-fps_mode",
                                            "passthrough",
                                            "-f",
                                            "image2pipe",
                                            "pipe:1"},
                                           next_picture);
  std::vector<std::string> frames = split_webp(result.output);
  if (result.exit_code != 0 || int(frames.size()) != num_frames)
    throw Error(Fault::io_error,
                {.where = run.string(),
                 .what = fmt::format("ffmpeg made {} pictures of {} for the page", frames.size(), num_frames),
                 .value = result.messages.substr(0, result.messages.find('\n')),
                 .remedy = "render them again (--overwrite)"});
  return frames;
}

std::string tune_page_html(const TunePage& page, const std::string& library) {
  std::string html = embedded("page.html");
  fill_in(html, "title", html_text(page.title));
  fill_in(html, "style", page_style() + embedded("page.css"));
  fill_in(html, "data", json_in_script(data_of(page)));
  fill_in(html, "library", library);
  fill_in(html, "script", embedded("page.js"));
  return html;
}

std::string tune_record(const TunePage& page) {
  nlohmann::ordered_json json = header_of(page);
  json["variants"] = nlohmann::json::array();
  for (const PageVariant& variant : page.variants) json["variants"].push_back(numbers_of(variant));
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace umax
