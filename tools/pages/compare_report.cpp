#include "tools/pages/compare_report.h"

#include <cstdio>

#include "core/files/write_file.h"
#include "render/image/colormap.h"
#include "render/image/image_io.h"
#include "render/image/tone_map.h"
#include "tools/pages/html.h"

namespace umax {
namespace {

std::string picture(const Image8& image, const std::string& id) {
  return "<img id=\"" + id + "\" alt=\"" + id + "\" src=\"" + png_data_url(encode_png(image)) + "\">";
}

std::string figure(const Image8& image, const std::string& id, const std::string& caption) {
  return "<figure>" + picture(image, id) + "<figcaption>" + html_text(caption) + "</figcaption></figure>\n";
}

std::string numbers(const FlipResult& difference) {
  char text[160];
  std::snprintf(text, sizeof text, "mean FLIP %.5f, maximum %.4f, %.2f %% of the pixels above the threshold",
                difference.mean, difference.maximum, difference.percent_above);
  return text;
}

constexpr const char* style = R"(
body { background: #16181c; color: #e6e6e6; font: 15px/1.5 sans-serif; margin: 2em; }
main { display: flex; flex-wrap: wrap; gap: 1em; }
figure { margin: 0; flex: 1 1 26em; }
img { width: 100%; image-rendering: pixelated; background: #000; }
.curve { flex: 1 0 100%; } .curve svg { background: #fff; border-radius: 4px; max-width: 100%; height: auto; }
figcaption { color: #a8adb5; }
pre { background: #0c0d10; padding: .8em; overflow-x: auto; user-select: all; }
#flip img + img { display: none; } #flip:hover img { display: none; } #flip:hover img + img { display: inline; }
)";

}  // namespace

Image8 read_for_eyes(const std::filesystem::path& path) {
  if (path.extension() == ".png" || path.extension() == ".PNG") return read_png8(path);
  return tone_map(read_image(path), {.curve = ToneCurve::standard});
}

void write_compare_report(const std::filesystem::path& path, const Comparison& comparison) {
  std::string page = "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>" +
                     html_text(comparison.name) + "</title><style>" + style + "</style></head><body>\n<h1>" +
                     html_text(comparison.name) + "</h1>\n<p>" + html_text(comparison.verdict) + "</p>\n<p>" +
                     html_text(numbers(comparison.difference)) + "</p>\n<main>\n";
  if (!comparison.curve.empty()) page += "<figure class=\"curve\">" + comparison.curve + "</figure>\n";
  page += figure(comparison.reference, "reference", "reference");
  page += figure(comparison.result, "result", "result");
  page += figure(difference_picture(comparison.difference.map), "difference",
                 "difference: black where none is seen, pale yellow where all is");
  page += "<figure id=\"flip\">" + picture(comparison.reference, "front") + picture(comparison.result, "back") +
          "<figcaption>reference; under the pointer: result</figcaption></figure>\n</main>\n";
  if (!comparison.update_command.empty())
    page += "<p>If the result is right, make it the reference:</p>\n<pre>" + html_text(comparison.update_command) +
            "</pre>\n";
  page += "</body></html>\n";
  write_file(path, page);
}

}  // namespace umax
