#include "tools/tune/preview.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "embedding/cage/voxelize.h"
#include "tools/setup/body_cage.h"
#include "tools/setup/body_shape.h"

namespace umax {
namespace {

constexpr int most_width = 320, most_height = 240;  // [px]
constexpr int preview_samples = 2;                  // the rasteriser's shadow maps go with them
constexpr int most_cells = 400;                     // of a body's cage

bool is_chosen(const std::vector<std::string>& chosen, const std::string& start) {
  return std::any_of(chosen.begin(), chosen.end(), [&](const std::string& key) { return key.starts_with(start); });
}

void add(Preview& preview, const std::string& key, const std::string& value, const std::string& note) {
  preview.settings.push_back({key, value});
  preview.notes.push_back(note);
}

/// Even, as a clip needs it.
int even(double length) {
  return std::max(16, 2 * int(std::lround(length / 2)));
}

void preview_pictures(const RenderDescription& render, const std::vector<std::string>& chosen, Preview& preview) {
  const bool quality_chosen = is_chosen(chosen, "render.engine") || is_chosen(chosen, "render.samples") ||
                              is_chosen(chosen, "render.bounces") || is_chosen(chosen, "render.preview");
  const bool rasterises = render.engine == RenderEngine::osmesa || render.wireframe;
  if (!quality_chosen && !rasterises && !render.preview) add(preview, "render.preview", "true", "few paths of light");
  if (!quality_chosen && rasterises && render.engine != RenderEngine::osmesa)
    add(preview, "render.engine", "osmesa", "rasterised instead of path-traced");
  const double scale = std::min(double(most_width) / render.width, double(most_height) / render.height);
  if (!is_chosen(chosen, "render.size") && scale < 1) {
    const int width = even(scale * render.width), height = even(scale * render.height);
    add(preview, "render.size", fmt::format("[{}, {}]", width, height),
        fmt::format("{}x{} instead of {}x{}", width, height, render.width, render.height));
  }
  if (!quality_chosen && rasterises && render.samples > preview_samples)
    add(preview, "render.samples", std::to_string(preview_samples), "few shadow maps");
}

/// Hexes that the cage would have, or at most has.
double count_cells(const BodyDescription& body) {
  if (const int* count = std::get_if<int>(&body.cage.size)) return *count;
  if (const auto* grid = std::get_if<Vector3i>(&body.cage.size)) return double((*grid)[0]) * (*grid)[1] * (*grid)[2];
  ShapeLibrary library;
  return double(voxelize(place_body(body, library).mesh, cage_options(body.cage)).num_hexes());
}

/// Whether a limit of the body is an energy per hex.
bool is_counted_by_hex(const BodyDescription& body) {
  const PartLimitOptions& parts = body.part_limits;
  const EnergyLimitOptions* limits[] = {&body.limit, &parts.volumetric, &parts.deviatoric, &parts.fibre};
  return std::any_of(std::begin(limits), std::end(limits), [](const EnergyLimitOptions* limit) {
    return limit->kind != LimitKind::none && limit->unit == LimitUnit::energy;
  });
}

void preview_cage(const BodyDescription& body, const std::vector<std::string>& chosen, Preview& preview) {
  const std::string key = "body." + body.name + ".cage.";
  const bool has_file = body.brings_its_hexes() || std::holds_alternative<MeshSource>(body.cage.size);
  if (has_file || is_counted_by_hex(body) || is_chosen(chosen, key)) return;
  const double cells = count_cells(body);
  if (cells <= most_cells) return;
  const std::string note = fmt::format("{}: about {} hexes instead of {:.0f}", body.name, most_cells, cells);
  const auto* grid = std::get_if<Vector3i>(&body.cage.size);
  if (!grid) return add(preview, key + "cells", std::to_string(most_cells), note);
  const double scale = std::cbrt(most_cells / cells);
  const auto fewer = [&](int axis) { return std::max(1, int(std::lround(scale * (*grid)[axis]))); };
  add(preview, key + "cells", fmt::format("[{}, {}, {}]", fewer(0), fewer(1), fewer(2)), note);
}

}  // namespace

Preview preview_of(const Scene& scene, const std::vector<std::string>& chosen) {
  Preview preview;
  preview_pictures(scene.render, chosen, preview);
  for (const BodyDescription& body : scene.bodies) preview_cage(body, chosen, preview);
  return preview;
}

}  // namespace umax
