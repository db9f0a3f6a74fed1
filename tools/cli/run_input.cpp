#include "tools/cli/run_input.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "core/base/error.h"
#include "core/files/sha256.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/placement.h"
#include "scenes/builtin_scenes.h"
#include "scenes/quantity.h"
#include "scenes/resolved_scene.h"
#include "tools/setup/studio.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr double smallest_height = 0.01, largest_height = 20;  // [m]
constexpr double young_per_height = 250e3;                     // [Pa/m] 500 kPa at 2 m, as the paper's armadillo
constexpr double reference_height = 2;                         // [m] at which one time step per frame is enough

double parse_length(const std::string& option, const std::string& text) {
  std::string problem;
  const auto quantity = parse_quantity(text, units::length, problem);
  if (quantity && std::isfinite(quantity->value) && quantity->value > 0) return quantity->value;
  throw Error(Fault::usage, {.where = option,
                             .what = quantity ? "must be positive" : problem,
                             .value = '"' + text + '"',
                             .remedy = "give a length such as 1.8 or \"30 cm\""});
}

/// "cm" or a number of metres.
double parse_unit(const std::string& text) {
  if (const auto unit = parse_length_unit(text)) return *unit;
  return parse_length("--unit", text);
}

double parse_stretch(const std::string& text) {
  std::string problem;
  const auto quantity = parse_quantity(text, units::ratio, problem);
  if (quantity && quantity->value > 0 && quantity->value < 10) return quantity->value;
  throw Error(Fault::usage, {.where = "--stretch",
                             .what = quantity ? "must be more than 0 and less than 1000 %" : problem,
                             .value = '"' + text + '"',
                             .remedy = "give a share such as 20%"});
}

void require_axis(const std::string& up) {
  static const std::vector<std::string> axes{"x", "y", "z", "-x", "-y", "-z"};
  if (std::find(axes.begin(), axes.end(), up) == axes.end())
    throw Error(
        Fault::usage,
        {.where = "--up", .what = "is no axis", .value = '"' + up + '"', .remedy = "give x, y, z, -x, -y or -z"});
}

/// What a mesh file is when placed as the options, else the file, want it.
struct MeshFacts {
  double height = 0;  // [m]
  Look look;
};

MeshFacts look_at_mesh(const fs::path& path, const MeshSource& source, const std::optional<double>& wanted) {
  MeshFile file = load_mesh(path);
  Placement placement;
  placement.unit = source.unit ? source.unit : file.unit;
  placement.up = source.up ? source.up : file.up;
  placement.height = wanted;
  place(file.mesh, placement);
  std::error_code error;
  const bool has_texture = file.mesh.texture_coordinates.rows() > 0 && fs::exists(file.texture, error);
  const double height = file.mesh.positions.col(1).maxCoeff() - file.mesh.positions.col(1).minCoeff();
  if (height >= smallest_height && height <= largest_height)
    return {height, studio_look(file.mesh.colors.rows() > 0, has_texture)};

  const std::string unit = placement.unit ? fmt::format("{:g} m", *placement.unit) : "1 m, as the file does not say";
  throw Error(Fault::bad_data,
              {.where = path.string(),
               .what = "is outside 1 cm to 20 m",
               .value = fmt::format("a height of {:.4g} m (file unit: {})", height, unit),
               .remedy = "give its unit (--unit cm), its upward axis (--up z) or its height (--height \"1.8 m\")"});
}

}  // namespace

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const BuiltinScene& scene : builtin_scenes()) names.push_back(scene.name);
  return names;
}

InputKind kind_of_input(const std::string& input) {
  std::error_code error;
  if (fs::is_directory(input, error)) return InputKind::run;
  std::string ending = fs::path(input).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  if (ending.empty() || ending == ".toml") return InputKind::scene;
  return InputKind::mesh;
}

Scene scene_of_run(const fs::path& folder, const std::vector<Override>& overrides) {
  std::error_code error;
  if (!fs::is_directory(folder, error) || !fs::exists(folder / "scene.toml", error))
    throw Error(Fault::not_found, {.where = folder.string(),
                                   .what = "is not the folder of a run",
                                   .remedy = "give a folder that umax run or simulate made"});
  return load_scene((folder / "scene.toml").string(), overrides);
}

Scene scene_of_mesh(const fs::path& path, double drop_height, const Options& options) {
  if (options.up) require_axis(*options.up);
  std::error_code error;
  if (!fs::exists(path, error))
    throw Error(Fault::not_found, {.where = path.string(), .what = "does not exist", .remedy = "check the path"});
  MeshSource source;
  source.path = fs::absolute(path).lexically_normal();
  source.up = options.up;
  if (options.unit) source.unit = parse_unit(*options.unit);
  std::optional<double> wanted;
  if (options.height) wanted = parse_length("--height", *options.height);
  const auto [height, look] = look_at_mesh(path, source, wanted);
  source.sha256 = sha256_of_file(source.path);

  BodyDescription body;
  body.name = "body";
  body.source = source;
  body.look = look;
  body.height = wanted;
  body.position = Vector3d(0, (drop_height + 0.5) * height, 0);
  body.material.young = young_per_height * height;
  body.limit = {.kind = LimitKind::hard,
                .unit = LimitUnit::stretch,
                .value = options.stretch ? parse_stretch(*options.stretch) : 0.2};
  if (options.cells && body.brings_its_hexes())
    throw Error(Fault::usage, {.where = "--cells",
                               .what = "does not fit here: the hexes of " + path.filename().string() + " are the cage",
                               .remedy = "leave it out"});
  if (options.cells) body.cage.size = *options.cells;

  Scene scene;
  scene.name = path.stem().string();
  scene.description = path.filename().string() + " falls on the ground";
  scene.bodies.push_back(body);
  // small things fall through their own height in less time: the steps shrink with the square root of the size
  scene.clip.substeps = std::max(1, int(std::ceil(std::sqrt(reference_height / height) - 0.05)));
  add_studio(scene, height, 0);
  return parse_scene({.text = resolved_toml(scene),
                      .file = "(made for " + path.filename().string() + ")",
                      .folder = fs::current_path(),
                      .name = scene.name},
                     scene_overrides(options));
}

}  // namespace umax
