// Cameras of USD: prims with their parents' transforms, as samples in time have them.
#include <cmath>
#include <numbers>
#include <optional>

#include "embedding/cameras/camera_readers.h"
#include "embedding/cameras/usda_text.h"

namespace umax::cameras {
namespace {

using Eigen::Matrix4d;

Samples samples_of(const std::filesystem::path& path, const UsdAttribute& attribute, const std::string& name,
                   int width) {
  Samples samples{.times = {}, .values = {}, .width = width};
  const auto add = [&](double time, const UsdValue& value) {
    if (int(value.numbers.size()) != width) refuse(path, "has an attribute with another number of values", name);
    for (const double number : value.numbers)
      if (!std::isfinite(number)) refuse(path, "has an attribute that is not finite", name);
    samples.times.push_back(time);
    samples.values.insert(samples.values.end(), value.numbers.begin(), value.numbers.end());
  };
  for (const auto& [time, value] : attribute.samples)
    if (!value.numbers.empty()) add(time, value);  // "None" is no sample
  if (samples.times.empty()) add(0, attribute.value);
  return samples;
}

Matrix4d rotation_about(int axis, double degrees) {
  Matrix4d matrix = Matrix4d::Identity();
  const double angle = degrees * std::numbers::pi / 180;
  matrix.topLeftCorner<3, 3>() = Eigen::AngleAxisd(angle, Vector3d::Unit(axis)).toRotationMatrix();
  return matrix;
}

/// One step of a transform, on column vectors.
struct Step {
  std::string kind;  // "translate", "rotateXYZ", …
  Samples samples;
  bool inverse = false;

  Matrix4d at(double time) const {
    const Matrix4d matrix = forwards(samples.at(time));
    return inverse ? Matrix4d(matrix.inverse()) : matrix;
  }

 private:
  Matrix4d forwards(const std::vector<double>& v) const {
    Matrix4d matrix = Matrix4d::Identity();
    if (kind == "translate") matrix.topRightCorner<3, 1>() = Vector3d(v[0], v[1], v[2]);
    if (kind == "scale") matrix.diagonal() << v[0], v[1], v[2], 1;
    if (kind == "orient") {
      const Eigen::Quaterniond turn(v[3], v[0], v[1], v[2]);
      matrix.topLeftCorner<3, 3>() = turn.normalized().toRotationMatrix();
    }
    if (kind == "transform") matrix = Eigen::Map<const Matrix4d>(v.data());  // rows there, columns here
    if (kind.starts_with("rotate"))
      for (std::size_t i = 6; i < kind.size(); ++i)  // the first letter's turn comes first
        matrix = rotation_about(kind[i] - 'X', v[kind.size() == 7 ? 0 : std::size_t(kind[i] - 'X')]) * matrix;
    return matrix;
  }
};

int width_of(const std::string& kind) {
  if (kind == "transform") return 16;
  if (kind == "orient") return 4;
  if (kind == "translate" || kind == "scale") return 3;
  const bool turns = kind.starts_with("rotate") && kind.find_first_not_of("XYZ", 6) == kind.npos;
  return turns && kind.size() == 7 ? 1 : turns && kind.size() == 9 ? 3 : 0;
}

Step step_of(const std::filesystem::path& path, const UsdPrim& prim, std::string name) {
  static const std::string inverted = "!invert!", prefix = "xformOp:";
  Step step;
  step.inverse = name.starts_with(inverted);
  if (step.inverse) name.erase(0, inverted.size());
  const auto found = prim.attributes.find(name);
  if (found == prim.attributes.end() || !name.starts_with(prefix))
    refuse(path, "names a transform that is not there", prim.name + "." + name);
  step.kind = name.substr(prefix.size(), name.find(':', prefix.size()) - prefix.size());
  const int width = width_of(step.kind);
  if (width == 0) refuse(path, "has an unknown transform", prim.name + "." + name);
  step.samples = samples_of(path, found->second, prim.name + "." + name, width);
  if (step.kind != "orient") return step;
  step.samples.between = Samples::Between::turns;  // (w, x, y, z) in the file
  for (std::size_t i = 0; i < step.samples.values.size(); i += 4)
    std::rotate(step.samples.values.begin() + std::ptrdiff_t(i), step.samples.values.begin() + std::ptrdiff_t(i) + 1,
                step.samples.values.begin() + std::ptrdiff_t(i) + 4);
  return step;
}

/// Adds a prim's steps behind those of its parents.
void add_steps(const std::filesystem::path& path, const UsdPrim& prim, std::vector<Step>& steps) {
  const auto order = prim.attributes.find("xformOpOrder");
  if (order == prim.attributes.end()) return;
  for (const std::string& name : order->second.value.words) {
    if (name == "!resetXformStack!")
      steps.clear();
    else
      steps.push_back(step_of(path, prim, name));
  }
}

struct Found {
  const UsdPrim* prim;
  std::vector<const UsdPrim*> parents;  // from the outermost
};

void find_cameras(const UsdPrim& prim, std::vector<const UsdPrim*>& parents, std::vector<Found>& found) {
  if (prim.type == "Camera") found.push_back({&prim, parents});
  parents.push_back(&prim);
  for (const UsdPrim& child : prim.children) find_cameras(child, parents, found);
  parents.pop_back();
}

double number_in(const UsdPrim& file, const std::string& name, double otherwise) {
  const auto found = file.metadata.find(name);
  return found == file.metadata.end() || found->second.numbers.empty() ? otherwise : found->second.numbers[0];
}

/// Metres and y up, of what the file says of its own axes and unit.
Matrix4d from_file_axes(const UsdPrim& file) {
  Matrix4d matrix = Matrix4d::Identity();
  const auto up = file.metadata.find("upAxis");
  if (up != file.metadata.end() && !up->second.words.empty() && up->second.words[0] == "Z")
    matrix = rotation_about(0, -90);
  matrix.topRows<3>() *= number_in(file, "metersPerUnit", 0.01);  // the standard's, where it says nothing
  return matrix;
}

Samples number_of(const std::filesystem::path& path, const UsdPrim& camera, const std::string& name, double otherwise) {
  const auto found = camera.attributes.find(name);
  if (found == camera.attributes.end()) return {.times = {0}, .values = {otherwise}};
  return samples_of(path, found->second, camera.name + "." + name, 1);
}

void require_plain_lens(const std::filesystem::path& path, const UsdPrim& camera) {
  const auto projection = camera.attributes.find("projection");
  if (projection != camera.attributes.end() && !projection->second.value.words.empty() &&
      projection->second.value.words[0] != "perspective")
    refuse(path, "has a camera without perspective", camera.name, "make it a perspective camera");
  for (const char* offset : {"horizontalApertureOffset", "verticalApertureOffset"})
    for (const double value : number_of(path, camera, offset, 0).values)
      if (value != 0) refuse(path, "has a camera with a shifted lens", camera.name, "set its shift to 0");
}

/// Time code of the first sample of what moves the camera.
std::optional<double> first_sample(const std::vector<Step>& steps) {
  std::optional<double> first;
  for (const Step& step : steps)
    if (step.samples.times.size() > 1) first = std::min(first.value_or(step.samples.times[0]), step.samples.times[0]);
  return first;
}

}  // namespace

MovingCamera read_usda(const std::filesystem::path& path, std::string_view text, const std::string& name) {
  const UsdPrim file = parse_usda(path, text);
  std::vector<Found> cameras;
  std::vector<const UsdPrim*> parents;
  find_cameras(file, parents, cameras);
  std::vector<std::vector<std::string>> names;
  for (const Found& found : cameras) {
    names.push_back({found.prim->name});
    if (found.parents.size() > 1) names.back().push_back(found.parents.back()->name);  // what programs name it by
  }
  const Found& chosen = cameras[choose(path, names, name)];
  require_plain_lens(path, *chosen.prim);

  std::vector<Step> steps;
  for (const UsdPrim* parent : chosen.parents) add_steps(path, *parent, steps);
  add_steps(path, *chosen.prim, steps);
  const double codes_per_second = number_in(file, "timeCodesPerSecond", number_in(file, "framesPerSecond", 24));
  if (!(codes_per_second > 0)) refuse(path, "has no sensible timeCodesPerSecond");
  const double first_code = number_in(file, "startTimeCode", first_sample(steps).value_or(0));
  return {.name = chosen.prim->name,
          .start = first_code / codes_per_second,
          .at = [steps, codes_per_second, axes = from_file_axes(file),
                 focal = number_of(path, *chosen.prim, "focalLength", 50),
                 film = number_of(path, *chosen.prim, "verticalAperture", 15.2908)](double time) {
            const double code = time * codes_per_second;
            Matrix4d matrix = axes;
            for (const Step& step : steps) matrix = matrix * step.at(code);
            const double half = std::atan(film.at(code)[0] / (2 * focal.at(code)[0]));
            return place_from(matrix, half * 360 / std::numbers::pi);
          }};
}

}  // namespace umax::cameras
