// Bodies whose hexes come from files: set-up, the verbs and what they refuse.
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/element/hexahedron.h"
#include "core/element/rotation.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/tools/hex_bar.h"
#include "tests/tools/program.h"
#include "tools/setup/simulation_setup.h"

using namespace umax;
using namespace umax::testing;

namespace {

HexDocument bar_document() {
  return document_of(twisted_bar());
}

std::string message_of(const std::string& scene) {
  try {
    set_up(load_scene(scene));
  } catch (const Error& error) {
    CHECK(error.fault() == Fault::bad_data);
    return error.what();
  }
  return "";
}

double volume_of(const Lattice& lattice) {
  double volume = 0;
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) volume += make_hex_shape(rest_nodes(lattice, e), 0.3).volume;
  return volume;
}

}  // namespace

TEST_CASE("a file of hexes is a body and its cage, placed as meshes are") {
  const TemporaryFolder folder;
  make_file(folder / "bar.vtu", vtu(bar_document(), {.format = "binary"}));
  const auto scene =
      write_scene(folder, bar_scene("bar.vtu", "unit = \"cm\"\nup = \"z\"\nheight = 2\nmaterial.density = 700\n"));
  const Simulation simulation = set_up(load_scene(scene.string()));
  const BodySetup& body = simulation.bodies.front();
  const TriangleMesh& surface = body.shape.mesh;
  CHECK(body.lattice.num_hexes() == 32);
  CHECK_FALSE(body.lattice.is_regular());
  CHECK(surface.num_vertices() == 81 - 7);
  const double low = surface.positions.col(1).minCoeff(), high = surface.positions.col(1).maxCoeff();
  CHECK(high - low == Approx(2));
  CHECK(low == Approx(0.01));

  // vertices are nodes, to the last bit
  const EmbeddedPoints points = points_of(*body.embedding);
  for (Eigen::Index v = 0; v < surface.num_vertices(); ++v) {
    const int node = body.shape.hexes->surface_nodes[std::size_t(v)];
    CHECK(surface.positions.row(v) == body.lattice.rest_positions.row(node));
    CHECK(points.weights.row(v).maxCoeff() == 1);
  }
  CHECK(simulation.model.node_mass.sum() == Approx(700 * volume_of(body.lattice)).epsilon(1e-12));
  // the file's factors act
  for (const Eigen::Index e : {0, 7, 31}) CHECK(simulation.model.limit_factor[e] == 1 + 0.25 * double(e));
  CHECK(simulation.model.young_factor == VectorXd::Ones(32));
}

TEST_CASE("a surface rides in the hexes of cage.mesh, which are placed along with it") {
  const TemporaryFolder folder;
  const Lattice crooked = test::distorted_lattice(make_box_lattice({4, 4, 4}, {-60, -60, -60}, {30, 30, 30}), 0.25);
  make_file(folder / "cage.msh", gmsh_2(document_of(crooked), true));
  const std::string body = R"(
[body.ball]
shape = "sphere"
radius = 50
cage.mesh = "cage.msh"
)";
  make_file(folder / "plain.toml", body);
  make_file(folder / "placed.toml", body + "scale = 0.01\nrotation = [10, 20, 30]\nposition = [3, 4, 5]\n");
  const Simulation plain = set_up(load_scene((folder / "plain.toml").string()));
  const Simulation placed = set_up(load_scene((folder / "placed.toml").string()));
  const BodySetup &a = plain.bodies.front(), &b = placed.bodies.front();
  CHECK(a.lattice.rest_positions == crooked.rest_positions);
  CHECK(a.embedding->hex == b.embedding->hex);
  CHECK((points_of(*a.embedding).weights - points_of(*b.embedding).weights).cwiseAbs().maxCoeff() < 1e-10);
  CHECK(b.lattice.rest_positions.colwise().mean().isApprox(
      (crooked.rest_positions.colwise().mean() * 0.01 * rotation_from_degrees({10, 20, 30}).transpose()) +
          Eigen::RowVector3d(3, 4, 5),
      1e-3));
  // mass by what the sphere fills of each hex
  CHECK(placed.model.node_mass.sum() < 500 * 1.2 * 1.2 * 1.2);
  CHECK(b.cage.filled_volume == Approx(4 * EIGEN_PI / 3 * 0.125).epsilon(0.01));
}

TEST_CASE("a surface that leaves the hexes of cage.mesh is refused with vertex and distance") {
  const TemporaryFolder folder;
  make_file(folder / "cage.msh", gmsh_4(document_of(make_box_lattice({2, 2, 2}, {-1, -1, -1}, {1, 1, 1})), false));
  make_file(folder / "ball.toml", "[body.ball]\nshape = \"sphere\"\nradius = 1.5\ncage.mesh = \"cage.msh\"\n");
  const std::string text = message_of((folder / "ball.toml").string());
  CAPTURE(text);
  CHECK(text.find("body.ball: vertex ") == 0);
  CHECK(text.find("lies outside the cage") != std::string::npos);
  CHECK(text.find(" m from its nearest face (and ") != std::string::npos);
}

TEST_CASE("umax runs, inspects and turns a file of hexes") {
  const TemporaryFolder folder;
  make_file(folder / "bar.msh", gmsh_4(bar_document(), true));
  const std::string mesh = (folder / "bar.msh").string(), run = (folder / "run").string();
  const Words small{"--quick", "--size", "32x18", "--samples", "1", "--set", "clip.frames=6"};
  const ProcessResult drop = umax_program(Words{"drop", mesh, "-o", run} + small);
  INFO(drop.messages);
  REQUIRE(drop.exit_code == 0);
  CHECK(states_of(run).size() == 6);
  CHECK(std::filesystem::exists(std::filesystem::path(run) / "clip.mp4"));
  // the resolved scene asks for no cells, and gives the same states again
  const std::string resolved = file_text(std::filesystem::path(run) / "scene.toml");
  CHECK(resolved.find("mesh_sha256 = \"") != std::string::npos);
  CHECK(resolved.find("cage.") == std::string::npos);
  const std::string again = (folder / "again").string();
  REQUIRE(exit_code_of({"simulate", run + "/scene.toml", "-o", again}) == 0);
  CHECK(states_of(again) == states_of(run));

  CHECK(exit_code_of(Words{"turntable", mesh, "-o", (folder / "around").string(), "--frames", "1"} + small) == 0);

  const ProcessResult inspect = umax_program({"inspect", mesh, "--json"});
  REQUIRE(inspect.exit_code == 0);
  const auto json = nlohmann::json::parse(inspect.output);
  CHECK(json["cells"] == 32);
  CHECK(json["nodes"] == 81);
  CHECK(json["vertices"] == 74);
  CHECK(json["watertight"] == true);
  CHECK(json["cell_size_m"].is_number());
  CHECK(json["lattice_volume_m3"].get<double>() == Approx(volume_of(twisted_bar())).epsilon(1e-12));
  CHECK(json["lattice_mass_kg"].get<double>() == Approx(500 * volume_of(twisted_bar())).epsilon(1e-12));
  CHECK(json["hexes"]["worst_scaled_jacobian"].get<double>() < 0.99);
  CHECK(json["hexes"]["worst_scaled_jacobian"].get<double>() > 0.3);
  CHECK(json["hexes"]["edge_m"][0].get<double>() < json["hexes"]["edge_m"][1].get<double>());
  CHECK(umax_program({"inspect", mesh}).output.find("worst scaled Jacobian") != std::string::npos);

  const ProcessResult cells = umax_program({"drop", mesh, "--cells", "100", "-o", run + "2"});
  CHECK(cells.exit_code == 2);
  CHECK(cells.messages.find("the hexes of bar.msh are the cage") != std::string::npos);
}

TEST_CASE("a file of tangled hexes ends every verb with 65 and the hex's name") {
  const TemporaryFolder folder;
  HexDocument bar = bar_document();
  std::rotate(bar.hexes[9].begin(), bar.hexes[9].begin() + 4, bar.hexes[9].end());
  make_file(folder / "bar.msh", gmsh_2(bar, false));
  make_file(folder / "bar.toml", bar_scene("bar.msh"));
  for (const Words& words : {Words{"inspect", (folder / "bar.msh").string()},
                             Words{"drop", (folder / "bar.msh").string(), "-o", (folder / "run").string()},
                             Words{"run", (folder / "bar.toml").string(), "-o", (folder / "run").string()}}) {
    const ProcessResult result = umax_program(words);
    CHECK(result.exit_code == 65);
    CHECK(result.messages.find("1 of 32 hexes is inverted or tangled") != std::string::npos);
    CHECK(result.messages.find("element 11 (-") != std::string::npos);
  }
  CHECK_FALSE(std::filesystem::exists(folder / "run"));
}
