#include "tools/cli/mesh_scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "core/base/error.h"
#include "core/files/sha256.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/placement.h"
#include "scenes/quantity.h"
#include "scenes/resolved_scene.h"
#include "scenes/scene_file.h"
#include "tools/setup/studio.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr double smallest_height = 0.01, largest_height = 20;  // [m]
constexpr double young_per_height = 250e3;                     // [Pa/m] 500 kPa at 2 m, as the paper's armadillo
constexpr double reference_height = 2;                         // [m] at which one time step per frame is enough
constexpr double seconds_at_rest = 1.5;                        // [s] of a clip after the last fall
constexpr std::size_t longest_name = 40, most_names = 3;       // of files, in names

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

/// A mesh file as the options, else the file, want it placed.
struct MeshFacts {
  fs::path path;
  MeshSource source;
  double height = 0;    // [m]
  double diagonal = 0;  // [m] of its box
  double scale = 1;     // [-] by which --height changes it
  bool has_own_colors = false;
};

[[noreturn]] void refuse_height(const fs::path& path, double height, const std::optional<double>& file_unit) {
  const std::string unit = file_unit ? fmt::format("{:g} m", *file_unit) : "1 m, as the file does not say";
  throw Error(Fault::bad_data,
              {.where = path.string(),
               .what = "is outside 1 cm to 20 m",
               .value = fmt::format("a height of {:.4g} m (file unit: {})", height, unit),
               .remedy = "give its unit (--unit cm), its upward axis (--up z) or its height (--height \"1.8 m\")"});
}

std::optional<double> wanted_height(const Options& options) {
  return options.height ? std::optional(parse_length("--height", *options.height)) : std::nullopt;
}

MeshFacts look_at_mesh(const fs::path& path, const Options& options) {
  if (options.up) require_axis(*options.up);
  std::error_code error;
  if (!fs::exists(path, error))
    throw Error(Fault::not_found, {.where = path.string(), .what = "does not exist", .remedy = "check the path"});
  MeshFacts facts{.path = path, .source = {}};
  facts.source.path = fs::absolute(path).lexically_normal();
  facts.source.up = options.up;
  if (options.unit) facts.source.unit = parse_unit(*options.unit);

  MeshFile file = load_mesh(path);
  Placement placement;
  placement.unit = facts.source.unit ? facts.source.unit : file.unit;
  placement.up = facts.source.up ? facts.source.up : file.up;
  placement.height = wanted_height(options);
  const Placed placed = place(file.mesh, placement);
  facts.scale = placed.scale / placement.unit.value_or(1);
  const Vector3d size = file.mesh.positions.colwise().maxCoeff() - file.mesh.positions.colwise().minCoeff();
  facts.height = size.y();
  facts.diagonal = size.norm();
  if (!(facts.height >= smallest_height && facts.height <= largest_height))
    refuse_height(path, facts.height, placement.unit);
  facts.has_own_colors = file.mesh.colors.rows() > 0 || !file.materials.empty();
  facts.source.sha256 = sha256_of_file(facts.source.path);
  return facts;
}

/// All but its name and place. number: of the body in the scene.
BodyDescription body_of(const MeshFacts& facts, int number, const Options& options) {
  BodyDescription body;
  body.source = facts.source;
  body.look = studio_look(facts.has_own_colors, number);
  body.material.young = young_per_height * facts.height;
  body.limit = {.kind = LimitKind::hard,
                .unit = LimitUnit::stretch,
                .value = options.stretch ? parse_stretch(*options.stretch) : 0.2};
  if (options.cells && body.brings_its_hexes())
    throw Error(Fault::usage,
                {.where = "--cells",
                 .what = "does not fit here: the hexes of " + facts.path.filename().string() + " are the cage",
                 .remedy = "leave it out"});
  if (options.cells) body.cage.size = *options.cells;
  return body;
}

Staging staging_of(const Options& options) {
  const std::string stage = options.stage.value_or("studio");
  return stage == "sky" ? Staging::sky : stage == "plain" ? Staging::plain : Staging::studio;
}

/// [m] that a stage fits: something low and wide needs a larger one than its height.
double stage_size(const MeshFacts& facts) {
  const double width = std::sqrt(std::max(0.0, facts.diagonal * facts.diagonal - facts.height * facts.height));
  return std::max(facts.height, 0.7 * width);
}

/// Small things fall through their own height in less time: the steps shrink with the square root of the size.
int substeps_of(double height) {
  return std::max(1, int(std::ceil(std::sqrt(reference_height / height) - 0.05)));
}

/// The scene as if read from a file, with the settings of the command line.
Scene resolved(const Scene& scene, const std::string& made_for, const Options& options) {
  return parse_scene({.text = resolved_toml(scene),
                      .file = "(made for " + made_for + ")",
                      .folder = fs::current_path(),
                      .name = scene.name},
                     scene_overrides(options));
}

/// The name of a file without its ending, as scenes allow names.
std::string name_of(const fs::path& path) {
  std::string name = path.stem().string().substr(0, longest_name);
  for (char& c : name)
    if (!std::isalnum(static_cast<unsigned char>(c)) && c != '-' && c != '_') c = '_';
  return name.empty() ? "body" : name;
}

/// Numbered where several bodies have the name of one file, with as many digits as keep their order.
std::string body_name(const std::vector<MeshFacts>& meshes, int index, int count) {
  const std::string name = name_of(meshes[std::size_t(index) % meshes.size()].path);
  const auto with_that_name = [&](int end) {
    int number = 0;
    for (int i = 0; i < end; ++i) number += name_of(meshes[std::size_t(i) % meshes.size()].path) == name;
    return number;
  };
  const int all = with_that_name(count);
  if (all == 1) return name;
  return fmt::format("{}_{:0{}}", name, with_that_name(index) + 1, std::to_string(all).size());
}

/// "cow", "cow-pig", "cow-30", "cow-and-4-more".
std::string heap_name(const std::vector<MeshFacts>& meshes, int count) {
  std::string name = name_of(meshes[0].path);
  if (meshes.size() > most_names)
    name += fmt::format("-and-{}-more", meshes.size() - 1);
  else
    for (std::size_t i = 1; i < meshes.size(); ++i) name += "-" + name_of(meshes[i].path);
  return count > int(meshes.size()) ? fmt::format("{}-{}", name, count) : name;
}

/// Where the centres of the bodies' boxes start, in cubes that hold a body however it is turned.
class StartPlaces {
 public:
  /// cube: [m] its edge. floor: [m] where the lowest cubes begin.
  StartPlaces(int count, double cube, double floor)
      : side_(std::max(1, int(std::lround(std::cbrt(count))))), cube_(cube), floor_(floor) {}

  Vector3d at(int index) const {
    const int layer = index / (side_ * side_), place = index % (side_ * side_);
    const double aside = layer % 2 == 1 ? 0.25 : 0;  // [cubes] that columns do not stand straight
    const double middle = 0.5 * (side_ - 1);
    return {(place % side_ - middle + aside) * cube_, floor_ + (layer + 0.5) * cube_,
            (place / side_ - middle + aside) * cube_};
  }
  double width() const { return side_ * cube_; }

 private:
  int side_;
  double cube_, floor_;
};

/// [degrees] of the n-th body of one mesh. Few, so that bodies share their cages.
Vector3d turn_of(int n) {
  static const std::array<Vector3d, 6> turns{Vector3d(0, 0, 0),   Vector3d(25, 75, -15),  Vector3d(-40, 150, 10),
                                             Vector3d(90, 30, 0), Vector3d(15, -100, 50), Vector3d(-75, 210, 20)};
  return turns[std::size_t(n) % turns.size()];
}

}  // namespace

Scene scene_of_mesh(const fs::path& path, double drop_height, const Options& options) {
  const MeshFacts facts = look_at_mesh(path, options);
  BodyDescription body = body_of(facts, 0, options);
  body.name = "body";
  body.height = wanted_height(options);
  body.position = Vector3d(0, (drop_height + 0.5) * facts.height, 0);

  Scene scene;
  scene.name = path.stem().string();
  scene.description = path.filename().string() + " falls on the ground";
  scene.bodies.push_back(body);
  scene.clip.substeps = substeps_of(facts.height);
  add_stage(scene, staging_of(options), (1 + 0.5 * drop_height) * stage_size(facts), 0);
  return resolved(scene, path.filename().string(), options);
}

Scene scene_of_meshes(const std::vector<fs::path>& paths, int count, const Options& options) {
  if (count < int(paths.size()))
    throw Error(Fault::usage, {.where = "--count",
                               .what = fmt::format("is less than the number of meshes, {}", paths.size()),
                               .value = std::to_string(count),
                               .remedy = "give fewer meshes or a larger number"});
  std::vector<MeshFacts> meshes;
  for (const fs::path& path : paths) meshes.push_back(look_at_mesh(path, options));
  double lowest = largest_height, tallest = 0, diagonal = 0;
  for (const MeshFacts& facts : meshes) {
    lowest = std::min(lowest, facts.height);
    tallest = std::max(tallest, facts.height);
    diagonal = std::max(diagonal, facts.diagonal);
  }
  const StartPlaces places(count, diagonal, 0.5 * tallest);

  Scene scene;
  scene.name = heap_name(meshes, count);
  scene.description = fmt::format("{} bodies fall on the ground and on each other", count);
  for (int i = 0; i < count; ++i) {
    const MeshFacts& facts = meshes[std::size_t(i) % meshes.size()];
    BodyDescription body = body_of(facts, i, options);
    body.name = body_name(meshes, i, count);
    if (options.height) body.scale = facts.scale;
    body.rotation_degrees = turn_of(i / int(meshes.size()));
    body.position = places.at(i);
    scene.bodies.push_back(body);
  }
  scene.clip.substeps = substeps_of(lowest);
  // the last ones fall, and then come to rest
  const double fall = std::sqrt(2 * places.at(count - 1).y() / 9.81);
  scene.clip.frames = std::max(scene.clip.frames, int(std::ceil((fall + seconds_at_rest) * scene.clip.fps)));
  add_stage(scene, staging_of(options), std::max(tallest, places.width()), 0);
  return resolved(scene, scene.name, options);
}

}  // namespace umax
