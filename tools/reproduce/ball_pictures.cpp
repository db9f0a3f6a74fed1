#include "tools/reproduce/ball_pictures.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/files/sha256.h"

namespace umax {
namespace {

constexpr int num_meridians = 20, num_parallels = 10;

/// Two shades of the ball's colour, field by field.
Points field_colors(const Points& rest, const Vector3f& color) {
  const Vector3d centre = 0.5 * (rest.colwise().minCoeff() + rest.colwise().maxCoeff()).transpose();
  const Vector3d dark = color.cast<double>(), light = 0.45 * Vector3d::Ones() + 0.55 * dark;
  Points colors(rest.rows(), 3);
  for (Eigen::Index i = 0; i < rest.rows(); ++i) {
    const Vector3d out = (rest.row(i).transpose() - centre).normalized();
    const double longitude = std::atan2(out.x(), out.z()) / (2 * std::numbers::pi) + 0.5;
    const double latitude = std::acos(std::clamp(out.y(), -1.0, 1.0)) / std::numbers::pi;
    // borders as wide as the mesh's triangles, so that they show no teeth
    const double wave =
        std::sin(num_meridians * std::numbers::pi * longitude) * std::sin(num_parallels * std::numbers::pi * latitude);
    const double share = std::clamp(0.5 + 2.5 * wave, 0.0, 1.0);
    colors.row(i) = (share * dark + (1 - share) * light).transpose();
  }
  return colors;
}

}  // namespace

std::vector<std::string> ball_view() {
  return {"camera.position=[1.7,3.6,7.2]", "camera.target=[0,1.02,0]", "camera.vertical_fov=25",
          "obstacle.ground.look.color=[0.62,0.6,0.57]"};
}

Tile chequered_tile(const Run& run, int frame, const std::string& label) {
  Tile tile = tile_of(run, frame, label);
  tile.key = sha256_hex(tile.key + "chequered");
  tile.shot = [run, plain = tile.shot](double aspect) {
    RenderScene shot = plain(aspect);
    RenderObject& ball = shot.objects.front();
    auto mesh = std::make_shared<TriangleMesh>(*ball.mesh);
    mesh->colors = field_colors(run.simulation->bodies.front().shape.mesh.positions, ball.look.base_color);
    ball.mesh = mesh;
    ball.look.vertex_colors = true;
    return shot;
  };
  return tile;
}

}  // namespace umax
