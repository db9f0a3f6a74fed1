#include "embedding/caches/usda_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "embedding/caches/corner_values.h"
#include "embedding/caches/number_text.h"
#include "embedding/caches/usda_material.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

template <class Row>
void append_tuple(std::string& out, const Row& row) {
  out += '(';
  append_row(out, row, ", ");
  out += ')';
}

/// "[(0, 1, 2), …]"
template <class Rows>
std::string array_of(const Rows& rows) {
  std::string out = "[";
  bool is_first = true;
  for (const auto& row : rows) {
    if (!is_first) out += ", ";
    is_first = false;
    append_tuple(out, row);
  }
  return out + "]";
}

template <class Numbers>
std::string list_of(const Numbers& numbers) {
  std::string out = "[";
  bool is_first = true;
  for (const auto& number : numbers) {
    if (!is_first) out += ", ";
    is_first = false;
    append_number(out, number);
  }
  return out + "]";
}

std::string extent_of(const FloatPoints& points) {
  std::string out = "[";
  append_tuple(out, points.colwise().minCoeff().eval());
  out += ", ";
  append_tuple(out, points.colwise().maxCoeff().eval());
  return out + "]";
}

std::string layer_header(const ClipSpace& clip, const std::string& root) {
  return fmt::format(
      "#usda 1.0\n(\n    defaultPrim = \"{}\"\n    endTimeCode = {}\n    framesPerSecond = {}\n    metersPerUnit = {}\n"
      "    startTimeCode = {}\n    timeCodesPerSecond = {}\n    upAxis = \"{}\"\n)\n\n",
      root, clip.frames.back(), clip.fps, clip.unit, clip.frames.front(), clip.fps, clip.z_up ? "Z" : "Y");
}

/// What does not change with time.
std::string topology_text(const MovingSurface& surface) {
  constexpr const char* in = "        ";
  std::string out = fmt::format("{}uniform bool doubleSided = 1\n", in);
  out += fmt::format("{}int[] faceVertexCounts = {}\n", in,
                     list_of(std::vector<int>(std::size_t(surface.triangles.rows()), 3)));
  out += fmt::format("{}int[] faceVertexIndices = {}\n", in, list_of(surface.triangles.reshaped<Eigen::RowMajor>()));
  out += fmt::format("{}uniform token orientation = \"rightHanded\"\n", in);
  out += fmt::format("{}uniform token subdivisionScheme = \"none\"\n", in);
  if (surface.colors.rows() > 0)
    out += fmt::format("{}color3f[] primvars:displayColor = {} (\n{}    interpolation = \"vertex\"\n{})\n", in,
                       array_of(surface.colors.rowwise()), in, in);
  if (surface.texture_coordinates.rows() > 0) {
    const CornerValues texture = distinct_values(surface.texture_coordinates);
    out += fmt::format("{}texCoord2f[] primvars:st = {} (\n{}    interpolation = \"faceVarying\"\n{})\n", in,
                       array_of(texture.values), in, in);
    out += fmt::format("{}int[] primvars:st:indices = {}\n", in, list_of(texture.index));
  }
  return out;
}

/// The opening of the prims that hold a surface. words: behind the root's name.
std::string opening_text(const char* specifier, const std::string& root, const std::string& words) {
  return fmt::format("{} {}\"{}\"{}\n{{\n    {} {}\"surface\"{}\n    {{\n", specifier,
                     specifier[0] == 'd' ? "Xform " : "", root, words, specifier, specifier[0] == 'd' ? "Mesh " : "",
                     specifier[0] == 'd' ? " (\n        prepend apiSchemas = [\"MaterialBindingAPI\"]\n    )" : "");
}

constexpr const char* vertex_interpolation = " (\n            interpolation = \"vertex\"\n        )\n";

/// "[(time, index), …]"
std::string pairs_of(const std::vector<std::pair<int, int>>& pairs) {
  std::string out = "[";
  for (const auto& [a, b] : pairs) out += fmt::format("{}({}, {})", out.size() > 1 ? ", " : "", a, b);
  return out + "]";
}

/// The attributes that have samples, without any.
std::string varying_text() {
  return std::string("        float3[] extent\n        normal3f[] normals") + vertex_interpolation +
         "        point3f[] points\n        vector3f[] velocities\n";
}

std::string clip_file(std::size_t index) {
  return fmt::format("{:04}.usda", index + 1);
}

}  // namespace

std::string usd_name(const std::string& name) {
  std::string out = name;
  for (char& c : out)
    if (!((c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9'))) c = '_';
  return out.empty() || (out[0] >= '0' && out[0] <= '9') ? "_" + out : out;
}

std::string still_usda(const MovingSurface& surface, const SurfaceFrame& shape, const ClipSpace& clip) {
  const std::string root = usd_name(surface.name);
  std::string out = layer_header(clip, root) + opening_text("def", root, " (\n    kind = \"component\"\n)");
  out += topology_text(surface);
  out += "        float3[] extent = " + extent_of(shape.positions) + "\n";
  out += "        normal3f[] normals = " + array_of(shape.normals.rowwise()) + vertex_interpolation;
  out += "        point3f[] points = " + array_of(shape.positions.rowwise()) + "\n";
  out += usda_binding(surface, root) + "    }\n\n";
  return out + usda_materials(surface, root) + "}\n";
}

UsdaSamples::UsdaSamples(const fs::path& layer)
    : points_(layer.string() + ".points"),
      velocities_(layer.string() + ".velocities"),
      normals_(layer.string() + ".normals"),
      extent_(layer.string() + ".extent") {}

void UsdaSamples::append(const SurfaceFrame& frame) {
  const auto add = [&](FileWriter& file, const std::string& value) {
    file.write(fmt::format("            {}: ", frame.frame) + value + ",\n");
  };
  add(points_, array_of(frame.positions.rowwise()));
  add(velocities_, array_of(frame.velocities.rowwise()));
  add(normals_, array_of(frame.normals.rowwise()));
  add(extent_, extent_of(frame.positions));
}

void UsdaSamples::append_to(FileWriter& file) {
  const auto add = [&](const char* attribute, FileWriter& samples) {
    file.write(fmt::format("        {}.timeSamples = {{\n", attribute));
    samples.append_to(file);
    file.write("        }\n");
  };
  add("float3[] extent", extent_);
  file.write(std::string("        normal3f[] normals") + vertex_interpolation);
  add("normal3f[] normals", normals_);
  add("point3f[] points", points_);
  add("vector3f[] velocities", velocities_);
}

long long UsdaSamples::size() const {
  return points_.size() + velocities_.size() + normals_.size() + extent_.size();
}

UsdaWriter::UsdaWriter(const fs::path& path, const MovingSurface& surface, const ClipSpace& clip, long long largest)
    : path_(path), surface_(&surface), clip_(&clip), largest_(largest), file_(path) {
  const std::string root = usd_name(surface.name);
  still_size_ = (long long)(layer_header(clip, root).size() + topology_text(surface).size() +
                            usda_binding(surface, root).size() + usda_materials(surface, root).size());
  samples_.emplace(path);
}

void UsdaWriter::append(const SurfaceFrame& frame) {
  if (clip_starts_.empty()) clip_starts_.push_back(frame.frame);
  if (is_full_) {  // the last frame of a clip is the first one of the next
    samples_->append(frame);
    finish_clip();
    samples_.emplace(path_);
    clip_starts_.push_back(frame.frame);
  }
  const long long before = samples_->size();
  samples_->append(frame);
  const long long added = samples_->size() - before;
  // another one and the first of the next clip, which may have a few digits more, have no room
  is_full_ = still_size_ + samples_->size() + 2 * (added + added / 4) > largest_;
}

/// NAME.clips beside NAME.usda
fs::path UsdaWriter::folder_of_clips() const {
  return fs::path(path_).replace_extension(".clips");
}

void UsdaWriter::finish_clip() {
  const std::string root = usd_name(surface_->name);
  const fs::path folder = folder_of_clips();
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw Error(Fault::cannot_create, {.where = folder.string(),
                                       .what = "cannot be made (" + error.message() + ")",
                                       .remedy = "choose a folder that can be written"});
  files_.push_back(folder / clip_file(clip_starts_.size() - 1));
  FileWriter file(files_.back());
  ClipSpace space = *clip_;
  space.frames = {clip_starts_.back(), clip_->frames.back()};
  file.write(layer_header(space, root) + opening_text("over", root, ""));
  samples_->append_to(file);
  file.write("    }\n}\n");
  file.finish();
}

/// The metadata that leads from the root prim to the clips.
std::string UsdaWriter::clips_text(const std::string& root) const {
  const std::string folder = "./" + folder_of_clips().filename().string() + "/";
  std::vector<std::pair<int, int>> active;
  std::string assets;
  for (std::size_t i = 0; i < clip_starts_.size(); ++i) {
    active.emplace_back(clip_starts_[i], int(i));
    assets += fmt::format("{}@{}{}@", i > 0 ? ", " : "", folder, clip_file(i));
  }
  const int first = clip_->frames.front(), last = clip_->frames.back();
  return fmt::format(
      "    clips = {{\n        dictionary default = {{\n            double2[] active = {}\n"
      "            asset[] assetPaths = [{}]\n            asset manifestAssetPath = @{}manifest.usda@\n"
      "            string primPath = \"/{}\"\n            double2[] times = {}\n        }}\n    }}\n",
      pairs_of(active), assets, folder, root, pairs_of({{first, first}, {last, last}}));
}

void UsdaWriter::write_manifest(const std::string& root) {
  files_.push_back(folder_of_clips() / "manifest.usda");
  FileWriter manifest(files_.back());
  manifest.write("#usda 1.0\n\n" + opening_text("over", root, "") + varying_text() + "    }\n}\n");
  manifest.finish();
}

void UsdaWriter::finish() {
  const std::string root = usd_name(surface_->name);
  const bool has_clips = clip_starts_.size() > 1;
  if (has_clips) {
    finish_clip();
    write_manifest(root);
  }
  file_.write(layer_header(*clip_, root));
  file_.write(opening_text("def", root,
                           " (\n    kind = \"component\"\n" + (has_clips ? clips_text(root) : std::string()) + ")"));
  file_.write(topology_text(*surface_));
  if (has_clips)
    file_.write(varying_text());
  else
    samples_->append_to(file_);
  file_.write(usda_binding(*surface_, root) + "    }\n\n" + usda_materials(*surface_, root) + "}\n");
  file_.finish();
  files_.push_back(path_);
}

std::string stage_usda(const std::vector<StagePart>& parts, const ClipCamera& camera, const ClipSpace& clip) {
  constexpr double film = 24;  // of its height, in tenths of a unit as USD has it: ratios are what counts
  const double focal = film / 2 / std::tan(camera.vertical_fov_degrees * std::numbers::pi / 360);
  const CameraAxes axes = axes_of(camera);
  std::string out = layer_header(clip, "scene") + "def Xform \"scene\" (\n    kind = \"assembly\"\n)\n{\n";
  for (const StagePart& part : parts)
    out += fmt::format("    def \"{}\" (\n        prepend references = @./{}@\n    )\n    {{\n    }}\n\n", part.name,
                       part.file);
  out += fmt::format(
      "    def Camera \"camera\"\n    {{\n        float2 clippingRange = ({}, {})\n        float focalLength = {}\n"
      "        float horizontalAperture = {}\n        float verticalAperture = {}\n",
      0.01 / clip.unit, 10000 / clip.unit, focal, film * camera.aspect, film);
  if (camera.aperture_radius > 0)
    out += fmt::format("        float fStop = {}\n        float focusDistance = {}\n",
                       focal / 10 / (2 * camera.aperture_radius), camera.focus_distance);
  out += "        matrix4d xformOp:transform = ( ";
  for (const Vector3d& axis : {axes.right, axes.up, axes.back})
    out += fmt::format("({}, {}, {}, 0), ", axis.x(), axis.y(), axis.z());
  out += fmt::format("({}, {}, {}, 1) )\n", camera.position.x(), camera.position.y(), camera.position.z());
  return out + "        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n    }\n}\n";
}

}  // namespace umax
