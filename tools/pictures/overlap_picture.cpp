#include "tools/pictures/overlap_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/step/step.h"
#include "render/annotation/annotate.h"
#include "render/raster/rasterize.h"
#include "tools/pictures/plot_scale.h"
#include "tools/pictures/studio_view.h"
#include "tools/setup/body_contact.h"

namespace umax {
namespace {

constexpr double mark_share = 0.005;   // of a view's size: half a mark's
constexpr double seen_through = 0.8;   // of a mark behind a surface
constexpr double surroundings = 2.5;   // times the deepest place, of what is seen from nearby
constexpr std::size_t most_names = 8;  // of overlaps in the picture

/// Points inside bodies: where, and how deep [m].
struct Marks {
  std::vector<Vector3d> places;
  std::vector<double> depths;
};

Marks find_marks(const Simulation& simulation, const State& state) {
  const Model& model = simulation.model;
  const VectorXd depths = overlap_depths(model, state);
  Marks marks;
  for (Eigen::Index p = 0; p < depths.size(); ++p) {
    if (depths[p] <= 0) continue;
    marks.places.emplace_back(hex_nodes(model, state.positions, surface_hex(model, p)).transpose() *
                              surface_weights(model, p));
    marks.depths.push_back(depths[p]);
  }
  return marks;
}

/// An octahedron at each place.
RenderObject draw_marks(const Marks& marks, double radius, const Legend& legend) {
  static const Eigen::Matrix<int, 8, 3> faces{{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4},
                                              {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  const auto count = Eigen::Index(marks.places.size());
  auto mesh = std::make_shared<TriangleMesh>();
  mesh->positions.resize(6 * count, 3);
  mesh->normals.resize(6 * count, 3);
  mesh->colors.resize(6 * count, 3);
  mesh->triangles.resize(8 * count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Vector3d color = color_on(legend, 1e3 * marks.depths[std::size_t(i)]).cast<double>();
    for (int corner = 0; corner < 6; ++corner) {
      const Vector3d direction = (corner % 2 ? -1 : 1) * Vector3d::Unit(corner / 2);
      mesh->positions.row(6 * i + corner) = (marks.places[std::size_t(i)] + radius * direction).transpose();
      mesh->normals.row(6 * i + corner) = direction.transpose();
      mesh->colors.row(6 * i + corner) = color.transpose();
    }
    mesh->triangles.middleRows(8 * i, 8) = faces.array() + int(6 * i);
  }
  RenderObject object{.name = "marks", .mesh = mesh, .look = {}};
  object.look.vertex_colors = true;
  object.look.roughness = 1;
  return object;
}

/// The second picture's marks over the first, wherever it is not its backdrop.
void lay_over(const Image8& marks, Image8& picture) {
  const std::uint8_t* backdrop = marks.pixel(0, 0);
  for (std::size_t i = 0; i < picture.values.size(); i += 3) {
    if (std::equal(backdrop, backdrop + 3, marks.values.data() + i)) continue;
    for (std::size_t c = i; c < i + 3; ++c)
      picture.values[c] =
          std::uint8_t(std::lround(seen_through * marks.values[c] + (1 - seen_through) * picture.values[c]));
  }
}

struct View {
  Box box;  // that is seen
  std::string label;
};

Image8 draw_view(const Simulation& simulation, const Stage& stage, const State& state, const Marks& marks,
                 const Legend& legend, const View& view, Rasterizer& rasterizer, int threads) {
  CameraDescription description;
  description.vertical_fov_degrees = 24;
  const Camera camera = frame_camera(description, view.box, double(view_width) / view_height);
  const double size = view.box.diagonal().norm();
  const RasterizeOptions options{.width = view_width, .height = view_height, .threads = threads};
  RenderScene shot = make_shot(simulation, stage, state, camera);
  light_evenly(simulation, size, shot);
  for (RenderObject& object : shot.objects) {
    object.look = Look();
    object.look.roughness = 0.6f;
  }
  Image8 picture = present(rasterizer.draw(shot, options), shot);
  if (!marks.places.empty()) {
    shot.objects = {draw_marks(marks, mark_share * size, legend)};
    lay_over(present(rasterizer.draw(shot, options), shot), picture);
  }
  draw_label(picture, view.label, 0.02f, 0.02f, {.size = 0.035f});
  return picture;
}

/// Around the marks near the deepest one: as far as half its body's cells go.
Box box_of_deepest(const Simulation& simulation, const Marks& marks) {
  const auto deepest = std::max_element(marks.depths.begin(), marks.depths.end()) - marks.depths.begin();
  double cell = 0;
  for (const Model::BodyRange& body : simulation.model.bodies) cell = std::max(cell, body.cell_size);
  const double reach = std::max(2 * cell, 2 * marks.depths[std::size_t(deepest)]);
  Box near(marks.places[std::size_t(deepest)]);
  for (const Vector3d& place : marks.places)
    if ((place - marks.places[std::size_t(deepest)]).norm() <= reach) near.extend(place);
  const double half = std::max(0.5 * surroundings * near.sizes().maxCoeff(), cell);
  const Vector3d centre = near.center();
  return {centre - Vector3d::Constant(half), centre + Vector3d::Constant(half)};
}

void name_overlaps(const Simulation& simulation, std::vector<Overlap> overlaps, Image8& view) {
  std::stable_sort(overlaps.begin(), overlaps.end(),
                   [](const Overlap& a, const Overlap& b) { return a.depth > b.depth; });
  const std::size_t shown = std::min(overlaps.size(), most_names);
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < shown; ++i)
    lines.push_back(
        fmt::format("{} {:.3g} mm deep in {}", simulation.model.bodies[overlaps[i].a].name, 1e3 * overlaps[i].depth,
                    overlaps[i].a == overlaps[i].b ? "itself" : simulation.model.bodies[overlaps[i].b].name));
  if (shown < overlaps.size()) lines.push_back(fmt::format("and {} more", overlaps.size() - shown));
  if (lines.empty()) lines.emplace_back("no bodies overlap");
  constexpr float line = 0.04f;
  for (std::size_t i = 0; i < lines.size(); ++i)
    draw_label(view, lines[i], 0.02f, 0.97f - line * float(lines.size() - i), {.size = 0.026f});
}

}  // namespace

Image8 overlap_picture(const Simulation& simulation, int threads) {
  const State state = rest_state(simulation.model);
  const Marks marks = find_marks(simulation, state);
  const Box all = box_of(simulation, state.positions);
  Stage stage = make_stage(simulation, all);
  stage.legend.reset();
  Legend legend{.title = "mm deep", .low = 0, .high = 1};
  if (!marks.depths.empty())
    legend.high =
        make_scale({}, 0, 1e3 * *std::max_element(marks.depths.begin(), marks.depths.end()), 0, 1, 6, true).high;
  Rasterizer rasterizer(threads);
  std::vector<View> framed{{all, "at the start"}};
  if (!marks.places.empty()) framed.push_back({box_of_deepest(simulation, marks), "the deepest place"});
  std::vector<Image8> views;
  for (const View& view : framed)
    views.push_back(draw_view(simulation, stage, state, marks, legend, view, rasterizer, threads));
  name_overlaps(simulation, find_overlaps(simulation.model, state), views.front());
  return side_by_side(views, legend);
}

}  // namespace umax
