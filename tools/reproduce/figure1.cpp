// Figure 1: a complex character in its lattice.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/files/sha256.h"
#include "embedding/surface/hex_faces.h"
#include "tools/reproduce/character.h"
#include "tools/reproduce/experiments.h"
#include "tools/reproduce/run_measures.h"

namespace umax {
namespace {

constexpr int bar_sides = 6;

/// A bar along an edge of the cage, as triangles.
void append_bar(const Vector3d& a, const Vector3d& b, double radius, TriangleMesh& mesh, Eigen::Index index) {
  const Vector3d along = (b - a).normalized();
  const Vector3d helper = std::abs(along.y()) < 0.9 ? Vector3d::UnitY() : Vector3d::UnitX();
  const Vector3d u = along.cross(helper).normalized(), v = along.cross(u);
  const Eigen::Index first = 2 * bar_sides * index;
  for (int i = 0; i < bar_sides; ++i) {
    const double angle = 2 * std::numbers::pi * i / bar_sides;
    const Vector3d out = std::cos(angle) * u + std::sin(angle) * v;
    for (int end = 0; end < 2; ++end) {
      mesh.positions.row(first + 2 * i + end) = ((end == 0 ? a : b) + radius * out).transpose();
      mesh.normals.row(first + 2 * i + end) = out.transpose();
    }
    const int p = int(first) + 2 * i, q = int(first) + 2 * ((i + 1) % bar_sides);
    mesh.triangles.row(2 * (bar_sides * index + i)) << p, q, p + 1;
    mesh.triangles.row(2 * (bar_sides * index + i) + 1) << p + 1, q, q + 1;
  }
}

/// The cage's outer edges as thin bars.
RenderObject cage_object(const std::vector<std::pair<int, int>>& edges, const Points& nodes, double radius) {
  auto mesh = std::make_shared<TriangleMesh>();
  const Eigen::Index count = Eigen::Index(edges.size());
  mesh->positions.resize(2 * bar_sides * count, 3);
  mesh->normals.resize(2 * bar_sides * count, 3);
  mesh->triangles.resize(2 * bar_sides * count, 3);
  for (Eigen::Index i = 0; i < count; ++i)
    append_bar(nodes.row(edges[i].first), nodes.row(edges[i].second), radius, *mesh, i);
  RenderObject object{.name = "cage", .mesh = mesh, .look = {}};
  object.look.base_color = Vector3f(0.03f, 0.05f, 0.09f);
  object.look.roughness = 0.5f;
  return object;
}

Tile with_cage(const Run& run, int frame, const std::string& label) {
  Tile tile = tile_of(run, frame, label);
  tile.key = sha256_hex(tile.key + "cage");
  tile.shot = [run, frame, plain = tile.shot](double aspect) {
    RenderScene shot = plain(aspect);
    const Model& model = run.simulation->model;
    shot.objects.push_back(
        cage_object(outer_edges(model.hexes), run.state(frame).positions, 0.025 * model.bodies.front().cell_size));
    return shot;
  };
  return tile;
}

}  // namespace

ReportSection figure1(Workbench& bench) {
  const Character character = character_of(bench);
  const Run run =
      bench.simulate("figure1", character.scene, joined({character.settings, {"clip.fps=100", "clip.frames=101"}}));
  const int lowest =
      frame_of_least(run, 1, run.num_frames(), [&](const State& state) { return highest_point(run, state); });
  const auto picture =
      bench.sheet("figure1", {tile_of(run, lowest, "surface"), with_cage(run, lowest, "surface and cage")},
                  {.width = 640, .height = 640, .columns = 2, .samples = 128});
  const BodySetup& body = run.simulation->bodies.front();
  ReportSection section{.name = "figure1", .title = "Figure 1: a character embedded in its lattice", .blocks = {}};
  section.blocks = {
      ReportText{"“Simulation of hyperelastic deformations on a hexahedral lattice embedding.”", ReportVoice::paper},
      ReportPicture{picture,
                    fmt::format("{} at {:.2f} s, landed and limited: {} triangles ride in {} hexes.", character.label,
                                run.time_of(lowest), body.shape.mesh.num_triangles(), body.lattice.num_hexes())},
      ReportTable{
          .name = "embedding",
          .caption = "What is simulated and what is shown.",
          .columns = {{"hexes"}, {"nodes"}, {"vertices"}, {"triangles"}, {"edge of a hex", "m"}},
          .rows = {
              {character.label,
               {number_cell(double(body.lattice.num_hexes()), 6), number_cell(double(body.lattice.num_nodes()), 6),
                number_cell(double(body.shape.mesh.num_vertices()), 7),
                number_cell(double(body.shape.mesh.num_triangles()), 7), number_cell(body.lattice.cell_size.x())}}}}};
  if (!bench.has_armadillo()) section.blocks.push_back(ReportText{stand_in_note(), ReportVoice::difference});
  return section;
}

}  // namespace umax
