#include "embedding/maps/factor_map.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "embedding/cage/hex_cage.h"
#include "embedding/embedding.h"

namespace umax {
namespace {

constexpr int samples_of_hex = 5;      // along each axis
constexpr double samples_of_edge = 6;  // on the paint, along the shortest edge of a hex
constexpr double least_surface =
    0.05;  // [-] of a hex's face: less surface than that does not make it a hex of the surface
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

[[noreturn]] void refuse(const std::string& what, const std::string& value, const std::string& remedy) {
  throw Error(Fault::bad_data, {"", what, value, remedy});
}

std::string text_of(const Eigen::AlignedBox3d& box) {
  return fmt::format("({:.4g}, {:.4g}, {:.4g}) to ({:.4g}, {:.4g}, {:.4g})", box.min().x(), box.min().y(),
                     box.min().z(), box.max().x(), box.max().y(), box.max().z());
}

Eigen::AlignedBox3d box_of(const Points& points, const Eigen::Affine3d& transform = Eigen::Affine3d::Identity()) {
  Eigen::AlignedBox3d box;
  for (const auto& point : points.rowwise()) box.extend(Vector3d(transform * Vector3d(point.transpose())));
  return box;
}

/// Factors of the hexes' values, NaN: none.
HexFactors to_factors(const VectorXd& values, const std::optional<FactorRange>& range) {
  HexFactors result;
  result.factors = VectorXd::Ones(values.size());
  const double low = range ? 0 : least_factor, high = range ? 1 : largest_factor;
  bool is_first = true;
  for (Eigen::Index e = 0; e < values.size(); ++e) {
    const double value = values[e];
    if (std::isnan(value)) {
      ++result.num_outside;
      continue;
    }
    result.least = is_first ? value : std::min(result.least, value);
    result.largest = is_first ? value : std::max(result.largest, value);
    is_first = false;
    // means of 0 and of 1 may be off by rounding
    if (value < low - 1e-9 || value > high + 1e-9) ++result.num_clamped;
    const double kept = std::clamp(value, low, high);
    result.factors[e] = range ? range->black + kept * (range->white - range->black) : kept;
  }
  return result;
}

/// Samples of a hex that are in the solid; all of them where none is.
void keep_solid(const SampledDistance& solid, HexSamples& samples) {
  VectorXd weights = samples.weights;
  for (Eigen::Index p = 0; p < weights.size(); ++p)
    if (signed_distance(solid, samples.points.row(p)).distance > 0) weights[p] = 0;
  if (weights.sum() > 0) samples.weights = weights;
}

/// Weighted mean of the grid over the samples that it reaches; false: there are none.
bool mean_of_grid(const VdbGrid& grid, const HexSamples& samples, Eigen::Ref<Eigen::RowVectorXd> mean) {
  const GridSamples found = grid.sample(samples.points);
  double all = 0;
  mean.setZero();
  for (Eigen::Index p = 0; p < samples.weights.size(); ++p) {
    if (!found.inside[std::size_t(p)]) continue;
    mean += samples.weights[p] * found.values.row(p);
    all += samples.weights[p];
  }
  if (all > 0) mean /= all;
  return all > 0;
}

/// Points on the parts of a mesh that may be in the cage, with the area and the colour that each stands for.
struct PaintSamples {
  std::vector<Vector3d> points, normals;
  std::vector<double> areas, luminances;
};

using Corners = std::array<Eigen::Vector4d, 3>;  // position and luminance

void sample_triangle(const Corners& c, const Eigen::AlignedBox3d& box, double spacing, PaintSamples& samples) {
  Eigen::AlignedBox3d around;
  for (const Eigen::Vector4d& corner : c) around.extend(Vector3d(corner.head<3>()));
  if (!around.intersects(box)) return;
  const Vector3d a = c[0].head<3>(), b = c[1].head<3>(), d = c[2].head<3>();
  if (std::max({(b - a).norm(), (d - b).norm(), (a - d).norm()}) > spacing) {
    const Eigen::Vector4d ab = 0.5 * (c[0] + c[1]), bd = 0.5 * (c[1] + c[2]), da = 0.5 * (c[2] + c[0]);
    for (const Corners& part : {Corners{c[0], ab, da}, {ab, c[1], bd}, {da, bd, c[2]}, {bd, da, ab}})
      sample_triangle(part, box, spacing, samples);
    return;
  }
  const Eigen::Vector4d middle = (c[0] + c[1] + c[2]) / 3;
  samples.points.emplace_back(middle.head<3>());
  samples.normals.push_back((b - a).cross(d - a).normalized());
  samples.areas.push_back(0.5 * (b - a).cross(d - a).norm());
  samples.luminances.push_back(middle[3]);
}

double luminance(const Eigen::RowVector3d& color) {
  return color.dot(Eigen::RowVector3d(0.2126, 0.7152, 0.0722));  // Rec. 709, linear
}

PaintSamples sample_surface(const TriangleMesh& mesh, const Eigen::AlignedBox3d& box, double spacing) {
  PaintSamples samples;
  for (const auto& triangle : mesh.triangles.rowwise()) {
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const int v = triangle[Eigen::Index(k)];
      corners[k] << mesh.positions.row(v).transpose(), mesh.colors.rows() > 0 ? luminance(mesh.colors.row(v)) : 0;
    }
    sample_triangle(corners, box, spacing, samples);
  }
  return samples;
}

Eigen::Map<const Points> as_points(const std::vector<Vector3d>& points) {
  return {points.front().data(), Eigen::Index(points.size()), 3};
}

/// The hex of every sample. Those that rounding (a float file's, say) put just outside the cage belong to the hex
/// beside.
VectorXi hexes_of(const PaintSamples& samples, const Lattice& lattice, double reach) {
  VectorXi hexes = find_hexes(as_points(samples.points), lattice);
  for (const double by : {-reach, reach}) {
    std::vector<std::size_t> missing;
    std::vector<Vector3d> beside;
    for (std::size_t p = 0; p < samples.points.size(); ++p) {
      if (hexes[Eigen::Index(p)] >= 0) continue;
      missing.push_back(p);
      beside.push_back(samples.points[p] + by * samples.normals[p]);
    }
    if (missing.empty()) break;
    const VectorXi found = find_hexes(as_points(beside), lattice);
    for (std::size_t i = 0; i < missing.size(); ++i) hexes[Eigen::Index(missing[i])] = found[Eigen::Index(i)];
  }
  return hexes;
}

/// Area [m^2] of a surface in each hex, and the mean luminance there.
struct PaintOfHexes {
  VectorXd area, luminance;
};

PaintOfHexes paint_of_hexes(const TriangleMesh& mesh, const Lattice& lattice, double spacing) {
  Eigen::AlignedBox3d box = box_of(lattice.rest_positions);
  box.min().array() -= 0.01 * spacing;
  box.max().array() += 0.01 * spacing;
  const PaintSamples samples = sample_surface(mesh, box, spacing);
  PaintOfHexes paint{VectorXd::Zero(lattice.num_hexes()), VectorXd::Zero(lattice.num_hexes())};
  if (samples.points.empty()) return paint;
  const VectorXi hexes = hexes_of(samples, lattice, 0.01 * spacing);
  for (Eigen::Index p = 0; p < hexes.size(); ++p) {
    if (hexes[p] < 0) continue;
    paint.area[hexes[p]] += samples.areas[std::size_t(p)];
    paint.luminance[hexes[p]] += samples.areas[std::size_t(p)] * samples.luminances[std::size_t(p)];
  }
  for (Eigen::Index e = 0; e < paint.area.size(); ++e)
    if (paint.area[e] > 0) paint.luminance[e] /= paint.area[e];
  return paint;
}

/// Shortest edge of all hexes [m].
double shortest_edge(const Lattice& lattice) {
  if (lattice.is_regular()) return lattice.cell_size.minCoeff();
  double shortest = std::numeric_limits<double>::infinity();
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const Matrix8x3d nodes = rest_nodes(lattice, e);
    for (int n = 0; n < 8; ++n)
      for (int bit = 1; bit < 8; bit <<= 1) shortest = std::min(shortest, (nodes.row(n) - nodes.row(n ^ bit)).norm());
  }
  return shortest;
}

/// Carries values into the hexes that are `open`, one layer of neighbours (that share a node) after the other.
void fill_inwards(const Hexes& hexes, Eigen::Index num_nodes, std::vector<char> open, VectorXd& values) {
  for (bool grown = true; grown;) {
    grown = false;
    VectorXd sums = VectorXd::Zero(num_nodes), counts = VectorXd::Zero(num_nodes);
    for (Eigen::Index e = 0; e < hexes.rows(); ++e) {
      if (open[std::size_t(e)]) continue;
      for (const int node : hexes.row(e)) {
        sums[node] += values[e];
        counts[node] += 1;
      }
    }
    for (Eigen::Index e = 0; e < hexes.rows(); ++e) {
      if (!open[std::size_t(e)]) continue;
      double sum = 0, count = 0;
      for (const int node : hexes.row(e)) {
        sum += sums[node];
        count += counts[node];
      }
      if (count == 0) continue;
      values[e] = sum / count;
      open[std::size_t(e)] = 0;
      grown = true;
    }
  }
}

void require_colors(const TriangleMesh& mesh) {
  if (mesh.colors.rows() == 0)
    refuse("the mesh has no vertex colours", "", "paint its vertices and export it with its colours");
  long long num_bad = 0;
  Eigen::Index first = 0;
  for (Eigen::Index v = 0; v < mesh.colors.rows(); ++v)
    if (!mesh.colors.row(v).allFinite() || mesh.colors.row(v).minCoeff() < 0)
      if (num_bad++ == 0) first = v;
  if (num_bad > 0)
    refuse(fmt::format("{} of {} vertex colours are negative or not finite, the first is that of vertex {}", num_bad,
                       mesh.colors.rows(), first),
           fmt::format("({:g}, {:g}, {:g})", mesh.colors(first, 0), mesh.colors(first, 1), mesh.colors(first, 2)),
           "paint with colours from black to white");
}

}  // namespace

GridMeans means_of_grid(const VdbGrid& grid, const Eigen::Affine3d& file_from_world, const Lattice& lattice,
                        const SampledDistance* solid, Eigen::Index num_columns) {
  GridMeans means{MatrixXd::Zero(lattice.num_hexes(), num_columns),
                  std::vector<char>(std::size_t(lattice.num_hexes()), 0)};
  parallel_blocks(lattice.num_hexes(), 64, [&](Eigen::Index begin, Eigen::Index end) {
    Eigen::RowVectorXd mean(num_columns);
    for (Eigen::Index e = begin; e < end; ++e) {
      HexSamples samples = sample_hex(rest_nodes(lattice, e), samples_of_hex);
      if (solid && lattice.filled_fraction[e] < 1) keep_solid(*solid, samples);
      samples.points = ((samples.points * file_from_world.linear().transpose()).rowwise() +
                        file_from_world.translation().transpose())
                           .eval();
      means.reached[std::size_t(e)] = char(mean_of_grid(grid, samples, mean));
      means.values.row(e) = mean;
    }
  });
  if (std::find(means.reached.begin(), means.reached.end(), 1) == means.reached.end())
    refuse(fmt::format("the grid \"{}\" reaches no hex of the body", grid.name()),
           fmt::format("a grid from {} and a cage from {} in the coordinates of the body's mesh file",
                       text_of(grid.box()), text_of(box_of(lattice.rest_positions, file_from_world))),
           "write the grid in the coordinates of the body's mesh file");
  return means;
}

HexFactors factors_from_grid(const VdbGrid& grid, const Eigen::Affine3d& file_from_world, const Lattice& lattice,
                             const SampledDistance* solid, const std::optional<FactorRange>& range) {
  const GridMeans means = means_of_grid(grid, file_from_world, lattice, solid, 1);
  VectorXd values = means.values.col(0);
  for (Eigen::Index e = 0; e < values.size(); ++e)
    if (!means.reached[std::size_t(e)]) values[e] = nothing;
  return to_factors(values, range);
}

HexFactors factors_from_paint(const TriangleMesh& painted, const TriangleMesh& surface, const Lattice& lattice,
                              const FactorRange& range) {
  require_colors(painted);
  const double spacing = shortest_edge(lattice) / samples_of_edge;
  const PaintOfHexes paint = paint_of_hexes(painted, lattice, spacing);
  if (!(paint.area.maxCoeff() > 0))
    refuse("the painted surface touches no hex of the body",
           fmt::format("paint from {} and a cage from {} m, as placed", text_of(box_of(painted.positions)),
                       text_of(box_of(lattice.rest_positions))),
           "give a mesh in the coordinates of the body's own mesh file");

  const VectorXd own_area = paint_of_hexes(surface, lattice, spacing).area;
  VectorXd values(lattice.num_hexes());
  std::vector<char> within(std::size_t(lattice.num_hexes()), 0);
  const VectorXd volumes = hex_volumes(lattice);
  for (Eigen::Index e = 0; e < values.size(); ++e) {
    const bool on_surface = own_area[e] > least_surface * std::pow(volumes[e], 2.0 / 3);
    values[e] = paint.area[e] > 0 ? paint.luminance[e] : nothing;
    within[std::size_t(e)] = char(paint.area[e] == 0 && !on_surface);
  }
  HexFactors result = to_factors(values, range);
  result.num_outside -= int(std::count(within.begin(), within.end(), 1));
  fill_inwards(lattice.hexes, lattice.num_nodes(), within, result.factors);
  return result;
}

HexDirections directions_from_grid(const VdbGrid& grid, const Eigen::Affine3d& file_from_world, const Lattice& lattice,
                                   const SampledDistance* solid, const Vector3d& uniform) {
  constexpr double least_lead = 1e-3;  // [-] of the first eigenvalue over the second: less is no direction
  const GridMeans means = means_of_grid(grid, file_from_world, lattice, solid, 6);
  const Matrix3d world_from_file = file_from_world.linear().transpose();  // to a factor
  HexDirections result;
  result.directions = uniform.normalized().transpose().replicate(lattice.num_hexes(), 1);
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    const auto m = means.values.row(e);
    Matrix3d mean;
    mean << m[0], m[3], m[4], m[3], m[1], m[5], m[4], m[5], m[2];
    const Eigen::SelfAdjointEigenSolver<Matrix3d> axes(mean);
    if (!(axes.eigenvalues()[2] - axes.eigenvalues()[1] > least_lead)) {
      ++result.num_outside;
      continue;
    }
    const Vector3d direction = (world_from_file * axes.eigenvectors().col(2)).normalized();
    result.directions.row(e) = (direction.dot(uniform) < 0 ? Vector3d(-direction) : direction).transpose();
  }
  return result;
}

}  // namespace umax
