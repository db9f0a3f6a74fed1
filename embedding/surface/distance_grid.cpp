#include "embedding/surface/distance_grid.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "embedding/surface/solid.h"
#include "embedding/surface/topology.h"

namespace umax {
namespace {

constexpr float unreached = 1e15f;  // [m] its square is still a float

// Distance at a sample from the nearest values of its neighbours along x, y and z: |grad d| = 1, upwind.
float eikonal_update(std::array<float, 3> a, float h) {
  std::sort(a.begin(), a.end());
  float d = a[0] + h;
  if (d <= a[1]) return d;
  const float sum2 = a[0] + a[1];
  d = 0.5f * (sum2 + std::sqrt(std::max(0.0f, sum2 * sum2 - 2 * (a[0] * a[0] + a[1] * a[1] - h * h))));
  if (d <= a[2]) return d;
  const float sum3 = sum2 + a[2];
  const float squares = a[0] * a[0] + a[1] * a[1] + a[2] * a[2];
  return (sum3 + std::sqrt(std::max(0.0f, sum3 * sum3 - 3 * (squares - h * h)))) / 3;
}

// Fast sweeping: carries unsigned distances outwards from the samples that are known.
class Sweeper {
 public:
  Sweeper(std::vector<float>& distances, const std::vector<char>& known, const Vector3i& size, double spacing)
      : distances_(distances), known_(known), size_(size), spacing_(float(spacing)) {}

  void sweep_all_directions() {
    for (int direction = 0; direction < 8; ++direction)
      for (int a = 0; a < size_[0]; ++a)
        for (int b = 0; b < size_[1]; ++b)
          for (int c = 0; c < size_[2]; ++c)
            update(direction & 4 ? size_[0] - 1 - a : a, direction & 2 ? size_[1] - 1 - b : b,
                   direction & 1 ? size_[2] - 1 - c : c);
  }

 private:
  std::size_t index(int i, int j, int k) const { return (std::size_t(i) * size_[1] + j) * size_[2] + k; }

  float nearest(std::size_t at, int position, int count, std::ptrdiff_t stride) const {
    float d = unreached;
    if (position > 0) d = std::min(d, distances_[at - stride]);
    if (position + 1 < count) d = std::min(d, distances_[at + stride]);
    return d;
  }

  void update(int i, int j, int k) {
    const std::size_t at = index(i, j, k);
    if (known_[at]) return;
    const std::array<float, 3> neighbours{nearest(at, i, size_[0], std::ptrdiff_t(size_[1]) * size_[2]),
                                          nearest(at, j, size_[1], size_[2]), nearest(at, k, size_[2], 1)};
    const float lowest = *std::min_element(neighbours.begin(), neighbours.end());
    if (lowest < distances_[at]) distances_[at] = std::min(distances_[at], eikonal_update(neighbours, spacing_));
  }

  std::vector<float>& distances_;
  const std::vector<char>& known_;
  Vector3i size_;
  float spacing_;
};

// makes the values unsigned and replaces those beyond the cut-off
void spread_distances(float cut_off, SampledDistance& grid) {
  std::vector<char> known(grid.values.size());
  for (std::size_t s = 0; s < known.size(); ++s) {
    grid.values[s] = std::abs(grid.values[s]);
    known[s] = char(grid.values[s] < cut_off);
    if (!known[s]) grid.values[s] = unreached;
  }
  Sweeper sweeper(grid.values, known, grid.size, grid.spacing);
  for (int round = 0; round < 2; ++round) sweeper.sweep_all_directions();
}

std::vector<char> negative(const std::vector<float>& values) {
  std::vector<char> result(values.size());
  std::transform(values.begin(), values.end(), result.begin(), [](float d) { return char(d < 0); });
  return result;
}

std::vector<char> inside_by_lines(const Solid& solid, const SampledDistance& grid) {
  std::vector<std::array<int, 3>> points;
  points.reserve(grid.values.size());
  for (int i = 0; i < grid.size[0]; ++i)
    for (int j = 0; j < grid.size[1]; ++j)
      for (int k = 0; k < grid.size[2]; ++k) points.push_back({i, j, k});
  return are_inside(solid, {grid.origin, Vector3d::Constant(grid.spacing), grid.size}, points);
}

Vector3d unit_normal(const TriangleMesh& mesh, int t) {
  const Vector3d a = mesh.positions.row(mesh.triangles(t, 0)), b = mesh.positions.row(mesh.triangles(t, 1)),
                 c = mesh.positions.row(mesh.triangles(t, 2));
  return (b - a).cross(c - a).normalized();
}

Vector3d centroid(const TriangleMesh& mesh, int t) {
  return (mesh.positions.row(mesh.triangles(t, 0)) + mesh.positions.row(mesh.triangles(t, 1)) +
          mesh.positions.row(mesh.triangles(t, 2))) /
         3.0;
}

bool is_sharp(const TriangleMesh& mesh, int t0, int t1, double min_cosine) {
  const Vector3d n0 = unit_normal(mesh, t0), n1 = unit_normal(mesh, t1);
  const bool convex = n0.dot(centroid(mesh, t1) - centroid(mesh, t0)) < 0;
  return convex && n0.dot(n1) < min_cosine;
}

}  // namespace

SampledDistance make_distance_grid(const TriangleMesh& mesh, const DistanceGridOptions& options,
                                   std::vector<std::string>* notes) {
  constexpr int padding = 3;
  constexpr double narrow_band = LevelSetOptions{}.band_voxels;
  if (mesh.num_triangles() == 0)
    throw Error(Fault::bad_data, {"distance grid", "needs a mesh with triangles", "none", "give another mesh"});
  if (options.max_samples_per_axis < 4 || options.max_samples_per_axis > 1024)
    throw Error(Fault::bad_data, {"distance grid", "samples along an axis must be 4 to 1024",
                                  std::to_string(options.max_samples_per_axis), ""});
  const Vector3d low = mesh.positions.colwise().minCoeff(), high = mesh.positions.colwise().maxCoeff();
  SampledDistance grid;
  grid.spacing = (high - low).maxCoeff() / std::max(1, options.max_samples_per_axis - 1 - 2 * padding);
  if (!(grid.spacing > 0))
    throw Error(Fault::bad_data, {"distance grid", "needs a mesh with an extent", "0 m", "give another mesh"});
  for (int axis = 0; axis < 3; ++axis)
    grid.size[axis] = int(std::ceil((high - low)[axis] / grid.spacing)) + 1 + 2 * padding;
  grid.origin = low - Vector3d::Constant(padding * grid.spacing);

  // right near the surface, then outwards and inwards from there
  const Solid solid = make_solid(mesh, close_surface(mesh), grid.spacing);
  if (notes) notes->insert(notes->end(), solid.notes.begin(), solid.notes.end());
  const double band = std::max(narrow_band, options.band / grid.spacing);
  const bool reuse = solid.level_set && band == narrow_band && solid.level_set->voxel() == grid.spacing;
  grid.values = reuse ? solid.level_set->dense(Vector3i::Constant(-padding), grid.size)
                      : LevelSet(mesh.positions, mesh.triangles, grid.origin,
                                 {.voxel = grid.spacing, .band_voxels = band, .is_signed = solid.level_set.has_value()})
                            .dense(Vector3i::Zero(), grid.size);
  const std::vector<char> inside = solid.level_set ? negative(grid.values) : inside_by_lines(solid, grid);
  spread_distances(float((band - 0.01) * grid.spacing), grid);
  for (std::size_t s = 0; s < inside.size(); ++s)
    if (inside[s]) grid.values[s] = -grid.values[s];
  return grid;
}

std::vector<std::array<int, 2>> sharp_edges(const TriangleMesh& mesh, double dihedral_degrees) {
  const double min_cosine = std::cos(dihedral_degrees * std::numbers::pi / 180);
  std::vector<std::array<int, 2>> edges;
  for_each_edge(edge_uses(mesh.triangles, weld(mesh.positions)), [&](auto first, auto last) {
    if (last - first == 1 || (last - first == 2 && is_sharp(mesh, first[0].triangle, first[1].triangle, min_cosine)))
      edges.push_back({first->low, first->high});
  });
  return edges;
}

Points sharp_edge_points(const TriangleMesh& mesh, const SharpEdgeOptions& options) {
  if (!(options.spacing > 0))
    throw Error(Fault::bad_data, {"edge points", "need a positive spacing", std::to_string(options.spacing), ""});
  std::vector<char> end_taken(std::size_t(mesh.num_vertices()), 0);
  std::vector<Vector3d> points;
  for (const auto& [low, high] : sharp_edges(mesh, options.dihedral_degrees)) {
    const Vector3d a = mesh.positions.row(low), b = mesh.positions.row(high);
    for (const int end : {low, high})
      if (!std::exchange(end_taken[std::size_t(end)], 1)) points.push_back(mesh.positions.row(end));
    const int parts = std::max(1, int(std::ceil((b - a).norm() / options.spacing)));
    for (int k = 1; k < parts; ++k) points.push_back(a + (b - a) * (double(k) / parts));
  }
  Points result(Eigen::Index(points.size()), 3);
  for (std::size_t p = 0; p < points.size(); ++p) result.row(Eigen::Index(p)) = points[p];
  return result;
}

}  // namespace umax
