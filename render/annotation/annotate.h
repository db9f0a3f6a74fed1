// Words and bars on finished pictures: legends, labels, contact sheets.
#pragma once

#include <string>
#include <vector>

#include "render/image/tone_map.h"
#include "render/scene/render_scene.h"

namespace umax {

/// The distance of ticks on an axis: 1, 2 or 5 times a power of ten, about `num_ticks` of them over `span`.
double tick_step(double span, int num_ticks = 5);

/// Where a value stands on the bar: 0 at its low, 1 at its high end.
double place_on(const Legend& legend, double value);

/// The bar's linear Rec. 709 colour of a value: color_of_value() of its place; red where a limit is reached; beyond the
/// end of a bar that does not end at a limit the end's colour.
Vector3f color_on(const Legend& legend, double value);

/// Draws the colour bar with title, ticks and numbers into the right edge of an RGB picture. A bar that ends at a limit
/// shows the red of the reached limit as a cap of its own.
void draw_legend(Image8& image, const Legend& legend);

struct LabelOptions {
  float size = 0.04f;                   // [-] height of the letters, of the picture's height (at least 9 px)
  Vector3f color{0.95f, 0.95f, 0.95f};  // sRGB [0, 1]
  bool backed = true;                   // on a dark plate, readable on every picture
  bool centred = false;                 // x is the middle
};

/// Writes one line of UTF-8 text; (x, y) in [0, 1] of width and height from the top left is where its upper left corner
/// goes.
void draw_label(Image8& image, const std::string& text, float x, float y, const LabelOptions& options = {});

struct LabelledImage {
  Image8 image;
  std::string label;
};

struct SheetStyle {
  float letter_share = 1.0f / 16;  // [-] height of the labels' letters, of a picture's (at least 10 px)
};

/// Pictures of one size in rows of `columns` with their labels below, on a dark sheet.
Image8 contact_sheet(const std::vector<LabelledImage>& pictures, int columns, const SheetStyle& style = {});

/// What the screen and the PNG get: the scene's exposure, the tone curve, its legend and captions.
Image8 present(const Image& linear, const RenderScene& scene, ToneCurve curve = ToneCurve::filmic);

}  // namespace umax
