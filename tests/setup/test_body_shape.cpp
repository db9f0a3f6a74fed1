// Shapes of bodies: what is read once for several of them, and what others hit.
#include "tools/setup/body_shape.h"

#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tools/setup/simulation_setup.h"

using namespace umax;

namespace {

Simulation simulation_of(const std::string& text) {
  return set_up(parse_scene({.text = text}, {}));
}

/// A body of few cells.
std::string body(const std::string& name, const std::string& keys) {
  return "[body." + name + "]\ncage.cells = [2, 2, 2]\n" + keys;
}

/// A tetrahedron in centimetres, whose base is left out if it is open.
std::string tetrahedron(bool is_open) {
  return std::string("v 0 0 0\nv 30 0 0\nv 0 40 0\nv 0 0 50\nf 1 2 4\nf 1 4 3\nf 2 3 4\n") +
         (is_open ? "" : "f 1 3 2\n");
}

/// How far the vertices of what others hit are from those of the placed mesh [m].
double largest_error(const Model::BodyRange& body, const TriangleMesh& placed) {
  double largest = 0;
  for (Eigen::Index v = 0; v < placed.num_vertices(); ++v)
    largest =
        std::max(largest, (body.rest_pose.world(body.rest_scale * body.rest_surface->vertices.row(v).transpose()) -
                           placed.positions.row(v).transpose())
                              .norm());
  return largest;
}

}  // namespace

TEST_CASE("bodies of one shape share the surface that others hit, wherever they are, however turned and large") {
  const TemporaryFolder folder;
  make_file(folder / "t.obj", tetrahedron(false));
  const std::string mesh = "mesh = \"" + (folder / "t.obj").string() + "\"\nunit = \"cm\"\nup = \"z\"\n";
  const Simulation simulation = simulation_of(
      body("a", mesh + "position = [0, 1, 0]\n") + body("b", mesh + "position = [3, 1, 0]\nrotation = [20, 30, 40]\n") +
      body("c", mesh + "scale = 2\nposition = [0, 1, 3]\nrotation = [20, 30, 40]\n") +
      body("d", "shape = \"box\"\nsize = [1, 2, 1]\nrotation = [0, 0, 20]\ndrop_height = 1.5\n") +
      "[obstacle.ground]\nshape = \"plane\"\n");
  const auto& bodies = simulation.model.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    CAPTURE(i);
    REQUIRE(bodies[i].rest_surface);
    CHECK(largest_error(bodies[i], simulation.bodies[i].shape.mesh) < 1e-14);
    CHECK((bodies[i].rest_pose.rotation.transpose() * bodies[i].rest_pose.rotation - Matrix3d::Identity()).norm() <
          1e-14);
  }
  CHECK(bodies[0].rest_surface == bodies[1].rest_surface);
  CHECK(bodies[0].rest_surface == bodies[2].rest_surface);
  CHECK(bodies[0].rest_scale == 1);
  CHECK(bodies[2].rest_scale == Approx(2));
  CHECK(simulation.bodies[0].shape.own == simulation.bodies[2].shape.own);
}

TEST_CASE("bodies that differ in their place alone are caged once") {
  const std::string ball = "shape = \"sphere\"\nradius = 0.3\ncage.cells = 100\nrotation = [10, 20, 30]\n";
  const std::string here = "[body.a]\n" + ball + "position = [0.1, 1, 0]\n";
  const std::string there =
      "[body.b]\n" + ball + "position = [2.3, 1.7, -5]\nmaterial.density = 700\nlimit.stretch = 0.1\n";
  const Simulation simulation =
      simulation_of(here + there + "[body.c]\n" + ball + "cage.clip = \"box\"\nposition = [5, 1, 0]\n[body.d]\n" +
                    ball + "scale = 1.5\nposition = [7, 1, 0]\n");
  const auto& bodies = simulation.bodies;
  CHECK(bodies[0].embedding == bodies[1].embedding);
  CHECK(bodies[0].embedding != bodies[2].embedding);
  CHECK(bodies[0].embedding != bodies[3].embedding);

  // the first as it is alone, to the last bit; the second but for rounding
  const Simulation first = simulation_of(here), second = simulation_of(there);
  CHECK(first.bodies[0].lattice.rest_positions == bodies[0].lattice.rest_positions);
  CHECK(first.bodies[0].lattice.filled_fraction == bodies[0].lattice.filled_fraction);
  CHECK(first.bodies[0].shape.mesh.positions == bodies[0].shape.mesh.positions);
  const Lattice &shared = bodies[1].lattice, &alone = second.bodies[0].lattice;
  CHECK(shared.hexes == alone.hexes);
  CHECK((shared.rest_positions - alone.rest_positions).cwiseAbs().maxCoeff() < 1e-13);
  CHECK((shared.filled_fraction - alone.filled_fraction).cwiseAbs().maxCoeff() < 1e-3);
  CHECK((deform_points(points_of(*bodies[1].embedding), shared.hexes, shared.rest_positions) -
         bodies[1].shape.mesh.positions)
            .cwiseAbs()
            .maxCoeff() < 1e-13);
}

TEST_CASE("a body has a surface for others only where something may touch it, and an inside") {
  const std::string box = "shape = \"box\"\nsize = [0.1, 0.1, 0.1]\n";
  const auto has_surface = [](const Simulation& simulation, int i) {
    return simulation.model.bodies[std::size_t(i)].rest_surface != nullptr;
  };
  const std::string obstacles = box + "contact = \"obstacles\"\n", others = box + "contact = \"others\"\n";
  CHECK(has_surface(simulation_of(body("a", box)), 0));
  CHECK_FALSE(has_surface(simulation_of(body("a", obstacles)), 0));
  CHECK_FALSE(has_surface(simulation_of(body("a", others)), 0));  // there is no other
  const Simulation two = simulation_of(body("a", others) + body("b", others + "position = [2, 0, 0]\n"));
  CHECK(has_surface(two, 0));
  CHECK(has_surface(two, 1));
  const Simulation paired = simulation_of(body("a", obstacles) + body("b", obstacles + "position = [2, 0, 0]\n") +
                                          "[pair.p]\nbodies = [\"a\", \"b\"]\n");
  CHECK(has_surface(paired, 0));
  CHECK(has_surface(paired, 1));

  const TemporaryFolder folder;
  make_file(folder / "open.obj", tetrahedron(true));
  CHECK_FALSE(has_surface(
      simulation_of(body("a", "mesh = \"" + (folder / "open.obj").string() + "\"\nheight = \"30 cm\"\n")), 0));
}

TEST_CASE("others hit the outer faces of a body of hexes") {
  const TemporaryFolder folder;
  make_file(folder / "two.msh",
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n12\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n6 1 0 1\n"
            "7 1 1 1\n8 0 1 1\n9 2 0 0\n10 2 1 0\n11 2 0 1\n12 2 1 1\n$EndNodes\n$Elements\n2\n"
            "1 5 2 0 1 1 2 3 4 5 6 7 8\n2 5 2 0 1 2 9 10 3 6 11 12 7\n$EndElements\n");
  const Simulation simulation = simulation_of("[body.a]\nmesh = \"" + (folder / "two.msh").string() +
                                              "\"\nunit = \"cm\"\nrotation = [10, 20, 30]\nposition = [1, 2, 3]\n");
  const Model::BodyRange& hexes = simulation.model.bodies[0];
  REQUIRE(hexes.rest_surface);
  CHECK(hexes.rest_surface->triangles.rows() == 20);
  CHECK(largest_error(hexes, simulation.bodies[0].shape.mesh) < 1e-14);
  CHECK(nearest_point(*hexes.rest_surface, hexes.rest_pose.local({1, 2, 3}), 1).distance == Approx(-0.005));
}

TEST_CASE("scenes that share a library are set up as each alone, and cages of equal bodies are made once") {
  const TemporaryFolder folder;
  make_file(folder / "t.obj", tetrahedron(false));
  const std::string mesh = "mesh = \"" + (folder / "t.obj").string() + "\"\nunit = \"cm\"\nup = \"z\"\n";
  const std::string ground = "[obstacle.ground]\nshape = \"plane\"\n";
  const auto text = [&](const std::string& of_a, const std::string& place_of_b = "[3.3, 1, 0]") {
    return body("a", mesh + "position = [0, 1.1, 0]\n" + of_a) + body("b", mesh + "position = " + place_of_b + "\n") +
           ground;
  };
  ShapeLibrary library{.keeps_cages = true};
  std::vector<std::shared_ptr<const Embedding>> embeddings;
  for (const std::string& one :
       {text("limit.stretch = 0.1\n"), text("limit.stretch = 0.3\n"), text("", "[0.7, 2.3, 0]"), text("scale = 1.7\n"),
        text("rotation = [3, 4, 5]\n"), text("material.young = 1e4\n")}) {
    const Simulation alone = simulation_of(one);
    const Simulation shared = set_up(parse_scene({.text = one}, {}), library);
    CAPTURE(one);
    CHECK(shared.digest == alone.digest);
    CHECK(shared.warnings == alone.warnings);
    for (std::size_t i = 0; i < 2; ++i) {
      CHECK(shared.bodies[i].shape.mesh.positions == alone.bodies[i].shape.mesh.positions);
      CHECK(shared.bodies[i].lattice.rest_positions == alone.bodies[i].lattice.rest_positions);
      CHECK(shared.bodies[i].embedding->local == alone.bodies[i].embedding->local);
    }
    embeddings.push_back(shared.bodies[0].embedding);
  }
  for (const std::size_t i : {1, 2, 5}) CHECK(embeddings[i] == embeddings[0]);
  for (const std::size_t i : {3, 4}) CHECK(embeddings[i] != embeddings[0]);
}
