#include "tools/exchange/export_format.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/base/error.h"

namespace umax {

const std::vector<FormatTraits>& export_formats() {
  static const std::vector<FormatTraits> all{
      {.format = ExportFormat::pc2, .name = "pc2", .ending = "pc2", .is_cache = true},
      {.format = ExportFormat::mdd, .name = "mdd", .ending = "mdd", .is_cache = true},
      {.format = ExportFormat::abc,
       .name = "abc",
       .ending = "abc",
       .has_camera = true,
       .has_velocities = true,
       .has_normals = true},
      {.format = ExportFormat::usd,
       .name = "usd",
       .ending = "usda",
       .has_camera = true,
       .has_velocities = true,
       .has_normals = true},
      {.format = ExportFormat::gltf, .name = "gltf", .ending = "gltf", .has_camera = true, .has_normals = true},
      {.format = ExportFormat::obj, .name = "obj", .ending = "obj", .is_sequence = true},
      {.format = ExportFormat::ply,
       .name = "ply",
       .ending = "ply",
       .is_sequence = true,
       .has_velocities = true,
       .has_normals = true},
      {.format = ExportFormat::vtu, .name = "vtu", .ending = "vtu", .is_sequence = true, .holds_hexes = true}};
  return all;
}

const FormatTraits& traits_of(ExportFormat format) {
  return *std::find_if(export_formats().begin(), export_formats().end(),
                       [&](const FormatTraits& traits) { return traits.format == format; });
}

std::vector<std::string> export_format_names() {
  std::vector<std::string> names;
  for (const FormatTraits& traits : export_formats()) names.emplace_back(traits.name);
  return names;
}

ExportFormat parse_export_format(const std::string& name) {
  for (const FormatTraits& traits : export_formats())
    if (name == traits.name) return traits.format;
  throw Error(Fault::usage, {.where = "--format",
                             .what = "there is no such format",
                             .value = '"' + name + '"',
                             .remedy = fmt::format("give one of {}", fmt::join(export_format_names(), ", "))});
}

}  // namespace umax
