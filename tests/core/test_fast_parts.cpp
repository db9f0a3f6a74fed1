// Parts of one body that move against each other faster than half a cell between two looks.
#include "core/contact/fast_parts.h"

#include <map>

#include "core/contact/contact.h"
#include "core/element/rotation.h"
#include "embedding/surface/shapes.h"
#include "tests/support/catch.h"
#include "tests/support/touchable.h"

using namespace umax;
using namespace umax::test;

namespace {

constexpr double cell = 0.05;

// One body: a sheet of 9 x 1 x 9 hexes about the origin, held at its rim, and a block of 2 x 2 x 2 hexes that is `gap` hexes
// above it.
Body sheet_and_block(int gap) {
  const Body parts[] = {touchable_block("sheet", {9, 1, 9}, Vector3d::Zero(), cell, 2),
                        touchable_block("block", {2, 2, 2}, {4 * cell, (1 + gap) * cell, 4 * cell}, cell, 4)};
  const Vector3i offsets[] = {{0, 0, 0}, {4, 1 + gap, 4}};
  Body body;
  body.name = "both";
  body.material.mass = MassModel::lattice;
  Cells cells(81 + 8, 3);
  cells.topRows(81) = parts[0].lattice.cells;
  cells.bottomRows(8) = parts[1].lattice.cells.rowwise() + offsets[1].transpose();
  body.lattice = make_lattice(cells, Vector3d::Zero(), Vector3d::Constant(cell));
  std::map<std::array<int, 3>, int> hex_at;
  for (int e = 0; e < int(body.lattice.num_hexes()); ++e)
    hex_at[{body.lattice.cells(e, 0), body.lattice.cells(e, 1), body.lattice.cells(e, 2)}] = e;
  const Eigen::Index count = parts[0].surface.size(), all = count + parts[1].surface.size();
  body.surface.hex.resize(all);
  body.surface.weights.resize(all, 8);
  body.surface.weights << parts[0].surface.weights, parts[1].surface.weights;
  Points vertices(0, 3);
  Triangles triangles(0, 3);
  for (int part = 0; part < 2; ++part) {
    for (Eigen::Index p = 0; p < parts[part].surface.size(); ++p) {
      const Vector3i at = parts[part].lattice.cells.row(parts[part].surface.hex[p]).transpose() + offsets[part];
      body.surface.hex[part * count + p] = hex_at.at({at[0], at[1], at[2]});
    }
    const RestSurface& surface = *parts[part].rest_surface;
    const Eigen::Index first = vertices.rows();
    vertices.conservativeResize(first + surface.vertices.rows(), 3);
    vertices.bottomRows(surface.vertices.rows()) = surface.vertices;
    triangles.conservativeResize(triangles.rows() + surface.triangles.rows(), 3);
    triangles.bottomRows(surface.triangles.rows()) = surface.triangles.array() + int(first);
  }
  body.rest_surface = std::make_shared<const RestSurface>(make_rest_surface(vertices, triangles));
  for (int node = 0; node < int(body.lattice.num_nodes()); ++node) {
    const Vector3d at = body.lattice.rest_positions.row(node).transpose() / cell;
    if (at.y() < 1.5 && (std::abs(at.x() - 4.5) > 4 || std::abs(at.z() - 4.5) > 4)) body.fixed_nodes.push_back(node);
  }
  return body;
}

// moves the block's nodes; the block is what lies above the sheet
void move_block(const Model& model, const Vector3d& by, Points& positions) {
  for (int node = 0; node < int(model.num_nodes()); ++node)
    if (model.rest_positions(node, 1) > 1.5 * cell) positions.row(node) += by.transpose();
}

}  // namespace

TEST_CASE("parts of one body that pass each other are found, however it flies and turns as a whole") {
  const Model model = make_model({sheet_and_block(2)}, {});
  const ContactGeometry geometry = make_contact_geometry(model);
  const Points& from = model.rest_positions;
  const auto pairs_to = [&](const Points& to) {
    return fast_parts(model, geometry.touchable, geometry.hex_starts, from, to);
  };
  Points through = from, beside = from, nearer = from;
  move_block(model, {0, -6 * cell, 0}, through);  // from two cells above the sheet to one below it
  move_block(model, {6 * cell, 0, 0}, beside);
  move_block(model, {0, -0.4 * cell, 0}, nearer);
  REQUIRE(pairs_to(through).size() == 1);
  CHECK(pairs_to(through)[0].approach == Approx(6 / felt_motion).epsilon(0.05));
  CHECK(pairs_to(beside).empty());
  CHECK(pairs_to(nearer).empty());

  const Matrix3d rotation = rotation_from_degrees({20, 40, -30});
  const auto flown = [&](const Points& positions) -> Points {
    return (positions * rotation.transpose()).rowwise() + Eigen::RowVector3d(3, -2, 1);
  };
  CHECK(pairs_to(flown(from)).empty());
  CHECK(pairs_to(flown(through)).size() == 1);
  Body deaf = sheet_and_block(2);
  deaf.contact = ContactWith::others;
  const Model other = make_model({deaf}, {});
  CHECK(fast_parts(other, find_touchable(other), geometry.hex_starts, from, through).empty());
}

TEST_CASE("a part of a body does not pass through another one, however fast") {
  Body body = sheet_and_block(3);
  body.material.young = 2e6;
  const Model model = make_model({body}, {});
  const double speed = GENERATE(10, 30);  // [m/s] 3.3 and 10 cells a step
  CAPTURE(speed);
  State state = rest_state(model);
  move_block(model, {0, -speed, 0}, state.velocities);
  int substeps = 0, within = 0;
  simulate(model, StepOptions(), 20, state, [&](const StepReport& report, const State&) {
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_penetration < 2e-2 * cell);
    substeps = std::max(substeps, report.substeps);
    within = std::max(within, report.contacts_within);
  });
  CHECK((substeps > 1) == (speed > 20));
  CHECK(within > 0);
  // the block is above the sheet's middle
  double block = 0, sheet = 0;
  for (int node = 0; node < int(model.num_nodes()); ++node) {
    const Vector3d at = model.rest_positions.row(node).transpose() / cell;
    if (at.y() > 1.5)
      block += state.positions(node, 1) / 27;
    else if (std::abs(at.x() - 4.5) < 1 && std::abs(at.z() - 4.5) < 1)
      sheet += state.positions(node, 1) / 8;
  }
  CHECK(block > sheet + cell);
}
