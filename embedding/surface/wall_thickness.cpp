#include "embedding/surface/wall_thickness.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/parallel.h"

namespace umax {
namespace {

constexpr double of_tips = 0.02;     // of the area
constexpr double facing_away = 0.5;  // [-] cosine
constexpr Eigen::Index block = 256;

}  // namespace

double wall_thickness(const RestSurface& surface, double reach) {
  const Eigen::Index count = surface.triangles.rows();
  std::vector<std::pair<double, double>> walls(std::size_t(count), {std::numeric_limits<double>::infinity(), 0});
  parallel_blocks(count, block, [&](Eigen::Index begin, Eigen::Index end) {
    for (int t = int(begin); t < int(end); ++t) {
      const Vector3d a = corner_of(surface, t, 0), b = corner_of(surface, t, 1), c = corner_of(surface, t, 2);
      const Vector3d centre = (a + b + c) / 3, normal = surface.triangle_normals.row(t).transpose();
      auto& [thickness, area] = walls[std::size_t(t)];
      area = 0.5 * (b - a).cross(c - a).norm();
      const SurfaceHit hit = nearest_alike(surface, centre, -normal, facing_away, reach);
      if (hit.triangle >= 0 && (hit.point - centre).dot(normal) < 0) thickness = (hit.point - centre).norm();
    }
  });
  std::sort(walls.begin(), walls.end());
  double all = 0, thinner = 0;
  for (const auto& [thickness, area] : walls) all += area;
  for (const auto& [thickness, area] : walls) {
    thinner += area;
    if (thinner > of_tips * all) return thickness;
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace umax
