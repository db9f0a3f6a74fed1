// The formats that runs are exported to, and what each of them holds.
#pragma once

#include <string>
#include <vector>

namespace umax {

enum class ExportFormat { pc2, mdd, abc, usd, gltf, obj, ply, vtu };

struct FormatTraits {
  ExportFormat format = ExportFormat::pc2;
  const char* name = "";     // that --format takes
  const char* ending = "";   // of its files
  bool is_sequence = false;  // one file for each frame, in a folder of the body's name
  bool is_cache = false;     // positions alone: the mesh stands beside it as OBJ
  bool holds_hexes = false;  // the bodies' hexes, not their surfaces
  bool has_camera = false;
  bool has_velocities = false, has_normals = false;
};

/// All, in the order in which they are told.
const std::vector<FormatTraits>& export_formats();
const FormatTraits& traits_of(ExportFormat format);

/// Their names.
std::vector<std::string> export_format_names();

/// Throws Error (usage) that names those there are.
ExportFormat parse_export_format(const std::string& name);

}  // namespace umax
