#include "core/model/model.h"

#include "core/base/error.h"
#include "core/element/material.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

Body two_cells() {
  Body body = test::make_block({2, 1, 1}, Vector3d::Zero(), 0.5);
  body.material.density = 800;
  return body;
}

double limit_of(Body body, LimitUnit unit, double value) {
  body.limit = {.kind = LimitKind::hard, .unit = unit, .value = value};
  return energy_limit_at(make_model({body}, {}), 0, 0);
}

}  // namespace

TEST_CASE("full cubes weigh density times volume, shared equally by their nodes") {
  const Model model = make_model({two_cells()}, {});
  CHECK(model.node_mass.sum() == Approx(800 * 2 * 0.125));
  for (Eigen::Index node = 0; node < model.num_nodes(); ++node) {
    const bool shared = model.rest_positions(node, 0) == 0.5;
    CHECK(model.node_mass[node] == Approx(800 * 0.125 / 8 * (shared ? 2 : 1)));
  }
}

TEST_CASE("partly filled cubes weigh their filled share, at least 5 percent") {
  Body body = two_cells();
  body.material.mass = MassModel::mesh;
  body.lattice.filled_fraction << 0.6, 0.001;
  CHECK(make_model({body}, {}).node_mass.sum() == Approx(800 * 0.125 * (0.6 + 0.05)));
  body.material.mass = MassModel::lattice;
  CHECK(make_model({body}, {}).node_mass.sum() == Approx(800 * 0.125 * 2));
}

TEST_CASE("bodies start with their velocity and spin about their centre of mass") {
  Body body = two_cells();
  body.velocity = {1, 2, 3};
  body.spin = {0.1, -0.2, 0.3};
  body.material.mass = MassModel::mesh;
  body.lattice.filled_fraction << 1, 0.25;  // the centre is not the middle
  const Model model = make_model({body}, {});
  const State state = rest_state(model);
  const Vector3d centre = test::mean_of(model.node_mass, state.positions);
  CHECK(centre.x() < 0.49);
  CHECK((test::momentum(model, state) - test::total_mass(model) * body.velocity).norm() < 1e-12);
  for (Eigen::Index i = 0; i < model.num_nodes(); ++i) {
    const Vector3d expected = body.velocity + body.spin.cross(Vector3d(state.positions.row(i).transpose() - centre));
    CHECK((state.velocities.row(i).transpose() - expected).norm() < 1e-14);
  }
}

TEST_CASE("fixed nodes start at rest whatever the body does") {
  Body body = two_cells();
  body.velocity = {1, 2, 3};
  body.fixed_nodes = {0, 5};
  const State state = rest_state(make_model({body}, {}));
  CHECK(state.velocities.row(0).norm() == 0);
  CHECK(state.velocities.row(5).norm() == 0);
  CHECK(state.velocities.row(1).norm() > 1);
}

TEST_CASE("bad materials are refused by the name of body and key") {
  Body body = two_cells();
  body.name = "jelly";
  CHECK(test::complaint(body).empty());
  std::string key;
  SECTION("zero stiffness") {
    body.material.young = 0.0, key = "material.young";
  }
  SECTION("negative stiffness") {
    body.material.young = -1.0, key = "material.young";
  }
  SECTION("stiffness that is not a number") {
    body.material.young = std::nan(""), key = "material.young";
  }
  SECTION("a bad stiffness key") {
    body.material.young.times = {0, 1};
    body.material.young.values = {1e5, -1};
    key = "material.young";
  }
  SECTION("incompressible") {
    body.material.poisson = 0.5, key = "material.poisson";
  }
  SECTION("poisson too low") {
    body.material.poisson = -1, key = "material.poisson";
  }
  SECTION("poisson not a number") {
    body.material.poisson = std::nan(""), key = "material.poisson";
  }
  SECTION("weightless") {
    body.material.density = 0, key = "material.density";
  }
  SECTION("endless density") {
    body.material.density = INFINITY, key = "material.density";
  }
  SECTION("negative mass damping") {
    body.material.damping_mass = -1, key = "material.damping_mass";
  }
  SECTION("endless mass damping") {
    body.material.damping_mass = INFINITY, key = "material.damping_mass";
  }
  SECTION("negative stiffness damping") {
    body.material.damping_stiffness = -1, key = "material.damping_stiffness";
  }
  SECTION("negative friction") {
    body.friction = -0.1, key = "friction";
  }
  SECTION("endless friction") {
    body.friction = INFINITY, key = "friction";
  }
  SECTION("zero limit") {
    body.limit = {LimitKind::hard, LimitUnit::energy, 0.0}, key = "limit";
  }
  SECTION("negative limit") {
    body.limit = {LimitKind::hard, LimitUnit::stretch, -0.2}, key = "limit";
  }
  SECTION("velocity not a number") {
    body.velocity.x() = std::nan(""), key = "velocity";
  }
  SECTION("spin not a number") {
    body.spin.y() = INFINITY, key = "spin";
  }
  SECTION("fixed node not there") {
    body.fixed_nodes = {12}, key = "fixed_nodes";
  }
  SECTION("surface in a hex not there") {
    body.surface.hex[3] = 2, key = "surface";
  }
  SECTION("nothing wrong") {
    return;
  }
  const std::string text = test::complaint(body);
  CHECK(text.find("body.jelly." + key) != std::string::npos);
}

TEST_CASE("a bad cage is refused by the name of its body") {
  Body body = two_cells();
  body.name = "jelly";
  body.lattice.rest_positions(0, 0) = std::nan("");
  CHECK(test::complaint(body).find("jelly") != std::string::npos);
}

TEST_CASE("bad obstacles are refused by name") {
  Obstacle obstacle = test::make_ground();
  obstacle.name = "table";
  SECTION("negative friction") {
    obstacle.friction = -1;
  }
  SECTION("endless friction") {
    obstacle.friction = INFINITY;
  }
  SECTION("ball without size") {
    obstacle.shape = Ball{0};
  }
  SECTION("box without height") {
    obstacle.shape = Block{{1, 0, 1}};
  }
  SECTION("mesh without a distance") {
    obstacle.shape = MeshShape{};
  }
  SECTION("position not a number") {
    obstacle.position = Track<Vector3d>(Vector3d(0, std::nan(""), 0));
  }
  SECTION("rotation not a number") {
    obstacle.rotation_degrees = Track<Vector3d>(Vector3d(0, INFINITY, 0));
  }
  std::string text;
  try {
    make_model({two_cells()}, {obstacle});
  } catch (const Error& error) {
    text = error.what();
  }
  CHECK(text.find("obstacle.table") != std::string::npos);
}

TEST_CASE("a limit given as energy, density or stretch is the same limit") {
  Body body = two_cells();
  body.material.young = 2e5;
  const double density = density_from_stretch(2e5, 0.1);
  CHECK(density == Approx(0.5 * 2e5 * 0.01));
  CHECK(limit_of(body, LimitUnit::stretch, 0.1) == Approx(density * 0.125));
  CHECK(limit_of(body, LimitUnit::density, density) == Approx(density * 0.125));
  CHECK(limit_of(body, LimitUnit::energy, density * 0.125) == Approx(density * 0.125));
  CHECK(std::isinf(energy_limit_at(make_model({body}, {}), 0, 0)));
}

TEST_CASE("limits and stiffness follow their keys") {
  Body body = two_cells();
  body.material.young.times = {0, 1};
  body.material.young.values = {1e5, 3e5};
  body.limit = {.kind = LimitKind::hard, .unit = LimitUnit::energy, .value = 0.0};
  body.limit.value.times = {0, 2};
  body.limit.value.values = {100, 10};
  const Model model = make_model({body}, {});
  CHECK(young_at(model, 1, 0.5) == Approx(2e5));
  CHECK(energy_limit_at(model, 1, 1) == Approx(55));
  CHECK(energy_limit_at(model, 1, 5) == Approx(10));
}

TEST_CASE("factors per hex scale stiffness and limit of that hex only") {
  Body body = two_cells();
  test::limit_energy(body, 10);
  Model model = make_model({body}, {});
  model.young_factor[1] = 2;
  model.limit_factor[1] = 3;
  CHECK(young_at(model, 1, 0) == Approx(2 * young_at(model, 0, 0)));
  CHECK(energy_limit_at(model, 1, 0) == Approx(30));
  CHECK(energy_limit_at(model, 0, 0) == Approx(10));
}

TEST_CASE("bodies keep their own nodes, hexes and surface in the common model") {
  Body a = two_cells(), b = test::make_block({1, 2, 1}, {5, 0, 0}, 0.25);
  b.name = "other";
  b.material.poisson = 0.1;
  const Model model = make_model({a, b}, {});
  REQUIRE(model.bodies.size() == 2);
  CHECK(model.num_hexes() == 4);
  CHECK(model.num_nodes() == 24);
  CHECK(model.bodies[1].first_node == 12);
  CHECK(model.bodies[1].cell_size == Approx(0.25));
  for (Eigen::Index e = 0; e < 4; ++e) {
    const Model::BodyRange& body = model.bodies[model.hex_body[e]];
    CHECK(model.hexes.row(e).minCoeff() >= body.first_node);
    CHECK(model.hexes.row(e).maxCoeff() < body.first_node + body.num_nodes);
    CHECK(model.shapes[model.hex_shape[e]].poisson == body.material.poisson);
  }
  for (Eigen::Index p = 0; p < model.num_points(); ++p) {
    const Model::BodyRange& body = model.bodies[model.hex_body[surface_hex(model, p)]];
    CHECK((p >= body.first_point && p < body.first_point + body.num_points));
    const Points& rest = &body == &model.bodies[0] ? a.surface_rest : b.surface_rest;
    Vector3d position = Vector3d::Zero();
    for (int n = 0; n < 8; ++n)
      position +=
          surface_weights(model, p)[n] * model.rest_positions.row(model.hexes(surface_hex(model, p), n)).transpose();
    CHECK((position - rest.row(p - body.first_point).transpose()).norm() < 1e-14);
  }
}

TEST_CASE("bodies with the same points in the same hexes have one copy of them, in parts of the model too") {
  const Body a = two_cells(), b = test::make_block({1, 2, 1}, {5, 0, 0}, 0.25);
  Body moved = a, loose = a;
  moved.lattice.rest_positions.col(0).array() += 7;
  loose.surface.weights.row(0).reverseInPlace();
  const Model model = make_model({a, b, moved, loose}, {});
  CHECK(model.bodies[2].surface == model.bodies[0].surface);
  CHECK(model.bodies[1].surface != model.bodies[0].surface);
  CHECK(model.bodies[3].surface != model.bodies[0].surface);
  CHECK(part_of(model, {2}).bodies[0].surface == model.bodies[0].surface);
  const int point = model.bodies[2].first_point + 3;
  CHECK(surface_hex(model, point) == model.bodies[2].first_hex + a.surface.hex[3]);
  CHECK(surface_weights(model, point) == a.surface.weights.row(3).transpose());
}
