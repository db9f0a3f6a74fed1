// Bodies whose surfaces have few and large triangles touch each other along edges and faces, too.
#include <fmt/format.h>

#include "core/step/step.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/penetration.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/program.h"
#include "tools/setup/contact_points.h"
#include "tools/setup/simulation_setup.h"

using namespace umax;

namespace {

/// An OBJ of the prism along z whose section is this polygon, with its first corner's fan for caps.
void write_prism(const std::filesystem::path& path, const std::vector<Eigen::Vector2d>& section, double length) {
  std::string text;
  const auto count = int(section.size());
  for (const double z : {-0.5 * length, 0.5 * length})
    for (const Eigen::Vector2d& corner : section) text += fmt::format("v {} {} {}\n", corner.x(), corner.y(), z);
  for (int i = 0; i < count; ++i) {
    const int a = i + 1, b = (i + 1) % count + 1;
    text += fmt::format("f {} {} {}\nf {} {} {}\n", a, b, b + count, a, b + count, a + count);
    if (i > 1) text += fmt::format("f {} {} {}\nf {} {} {}\n", 1, i + 1, i, 1 + count, i + count, i + 1 + count);
  }
  make_file(path, text);
}

const std::vector<Eigen::Vector2d> square{{-0.1, -0.1}, {0.1, -0.1}, {0.1, 0.1}, {-0.1, 0.1}};
const std::vector<Eigen::Vector2d> diamond{{-0.14, 0}, {0, -0.14}, {0.14, 0}, {0, 0.14}};
const std::vector<Eigen::Vector2d> tent{{-0.1, -0.05}, {0.1, -0.05}, {0, 0.12}};

struct Outcome {
  test::PenetrationReport worst;
  int between = 0, not_converged = 0;  // contacts, steps
  Points start, end;                   // centres of the bodies [m]
};

Points centres(const Model& model, const Points& positions) {
  Points all(Eigen::Index(model.bodies.size()), 3);
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    all.row(Eigen::Index(b)) =
        positions.middleRows(model.bodies[b].first_node, model.bodies[b].num_nodes).colwise().mean();
  return all;
}

/// Every triangle in as many as have edges of no more than this [m].
TriangleMesh divided(const TriangleMesh& mesh, double edge) {
  std::vector<Vector3d> positions;
  std::vector<Vector3i> triangles;
  for (const auto& t : mesh.triangles.rowwise()) {
    const Matrix3d corners = mesh.positions(t, Eigen::all);
    const double longest = std::max({(corners.row(0) - corners.row(1)).norm(), (corners.row(1) - corners.row(2)).norm(),
                                     (corners.row(2) - corners.row(0)).norm()});
    const int parts = int(std::ceil(longest / edge));
    std::vector<std::vector<int>> at(std::size_t(parts) + 1);
    for (int i = 0; i <= parts; ++i)
      for (int j = 0; i + j <= parts; ++j) {
        at[std::size_t(i)].push_back(int(positions.size()));
        positions.emplace_back(corners.transpose() * Vector3d(parts - i - j, i, j) / parts);
      }
    for (std::size_t i = 0; i + 1 < at.size(); ++i)
      for (std::size_t j = 0; j < at[i + 1].size(); ++j) {
        triangles.emplace_back(at[i][j], at[i + 1][j], at[i][j + 1]);
        if (j > 0) triangles.emplace_back(at[i + 1][j - 1], at[i + 1][j], at[i][j]);
      }
  }
  TriangleMesh fine;
  fine.positions.resize(Eigen::Index(positions.size()), 3);
  for (std::size_t i = 0; i < positions.size(); ++i) fine.positions.row(Eigen::Index(i)) = positions[i].transpose();
  fine.triangles.resize(Eigen::Index(triangles.size()), 3);
  for (std::size_t i = 0; i < triangles.size(); ++i) fine.triangles.row(Eigen::Index(i)) = triangles[i].transpose();
  return fine;
}

/// The bodies' surfaces in triangles small enough to bend with their cages, to be measured.
struct Measured {
  Model model;  // with these surfaces
  std::vector<test::MeasuredBody> bodies;
};
Measured measured(const Simulation& simulation) {
  Measured measured{simulation.model, {}};
  std::vector<TriangleMesh> meshes;
  int num_points = 0;
  for (std::size_t i = 0; i < simulation.bodies.size(); ++i) {
    const BodySetup& body = simulation.bodies[i];
    Model::BodyRange& range = measured.model.bodies[i];
    meshes.push_back(divided(body.shape.mesh, 0.25 * range.cell_size));
    range.surface = std::make_shared<const EmbeddedPoints>(embed_points(meshes.back().positions, body.lattice));
    range.first_point = num_points;
    range.num_points = int(range.surface->size());
    num_points += range.num_points;
  }
  for (std::size_t i = 0; i < meshes.size(); ++i)
    measured.bodies.push_back(test::measured_body(measured.model, int(i), meshes[i].triangles));
  return measured;
}

/// Depths are measured by code that is not the contact's.
Outcome run(const std::string& scene, int steps) {
  const Simulation simulation = set_up(parse_scene({.text = scene}, {}));
  const Measured surfaces = measured(simulation);
  Workspace workspace(simulation.model);
  State state = rest_state(simulation.model);
  Outcome outcome;
  outcome.start = centres(simulation.model, state.positions);
  for (int i = 0; i < steps; ++i) {
    const StepReport report = step(simulation.model, simulation.options, workspace, state);
    outcome.not_converged += report.status != StepStatus::converged;
    outcome.between += report.contacts_between;
    test::add(test::measure_penetration(surfaces.model, surfaces.bodies, state.positions), outcome.worst);
  }
  outcome.end = centres(simulation.model, state.positions);
  return outcome;
}

/// A bar along x clamped at both ends, and one that flies at it.
std::string crossing(const std::filesystem::path& mesh, const std::string& lower, const std::string& upper) {
  return fmt::format(R"([clip]
gravity = [0, 0, 0]
[body.lower]
mesh = "{0}"
cage.cells = [10, 2, 2]
fixed = [{{ min = [-0.6, -1, -1], max = [-0.45, 1, 1] }}, {{ min = [0.45, -1, -1], max = [0.6, 1, 1] }}]
{1}
[body.upper]
mesh = "{0}"
cage.cell_size = 0.1
{2}
)",
                     mesh.string(), lower, upper);
}

void check_stopped(const Outcome& outcome) {
  CHECK(outcome.between > 0);
  CHECK(outcome.not_converged == 0);
  CHECK(outcome.worst.between.cells < 2e-2);
  CHECK(outcome.worst.crossing.cells < 2e-2);
}

}  // namespace

TEST_CASE("bars of twelve triangles that cross stop each other, whatever their height and place") {
  const TemporaryFolder folder;
  write_prism(folder / "bar.obj", square, 1);
  const double along = GENERATE(0.0, 0.013, 0.31), below = GENERATE(-0.17, 0.0, 0.05);
  CAPTURE(along, below);
  // upright, it flies sideways at the lying one: no vertex of either is near
  const Outcome outcome = run(crossing(folder / "bar.obj", "rotation = [0, 90, 0]\nposition = [0, 0, 0]",
                                       fmt::format("rotation = [90, 0, 0]\nposition = [{}, {}, 0.23]\n"
                                                   "velocity = [0, 0, -2]",
                                                   along, below)),
                              20);
  check_stopped(outcome);
  CHECK(outcome.end(1, 2) > 0.19);
}

TEST_CASE("ridges that cross each other stop each other") {
  const TemporaryFolder folder;
  const bool is_tent = GENERATE(false, true);
  write_prism(folder / "bar.obj", is_tent ? tent : diamond, 1);
  const double along = GENERATE(0.0, 0.0137, 0.029);
  CAPTURE(is_tent, along);
  const double ridges = is_tent ? 0.24 : 0.28;  // [m] between the bars' axes where they meet
  const Outcome outcome =
      run(crossing(folder / "bar.obj", "rotation = [0, 90, 0]\nposition = [0, 0, 0]",
                   fmt::format("rotation = [{}, 0, 0]\nposition = [{}, {}, 0.02]\nvelocity = [0, -1, 0]",
                               is_tent ? 180 : 0, along, ridges + 0.03)),
          20);
  check_stopped(outcome);
  CHECK(outcome.end(1, 1) > 0.2);
}

TEST_CASE("a ridge lands on a floor of two large triangles, which is a body") {
  const TemporaryFolder folder;
  write_prism(folder / "bar.obj", tent, 1);
  write_prism(folder / "floor.obj", {{-1, -0.1}, {1, -0.1}, {1, 0.1}, {-1, 0.1}}, 2);
  const Outcome outcome = run(fmt::format(R"([clip]
frames = 40
[body.floor]
mesh = "{}"
position = [0, 0, 0]
cage.cells = [10, 1, 10]
fixed = [{{ min = [-2, -1, -2], max = [2, -0.09, 2] }}]
[body.tent]
mesh = "{}"
rotation = [180, 30, 0]
position = [0.03, 0.25, 0.02]
cage.cell_size = 0.1
)",
                                          (folder / "floor.obj").string(), (folder / "bar.obj").string()),
                              40);
  check_stopped(outcome);
  CHECK(outcome.end(1, 1) > 0.1);
}

TEST_CASE("points between vertices are contact's alone, and none where a body touches obstacles only") {
  const TemporaryFolder folder;
  write_prism(folder / "bar.obj", square, 1);
  const auto of = [&](const std::string& contact) {
    return set_up(parse_scene({.text = fmt::format("[clip]\nframes = 2\n[body.bar]\nmesh = \"{}\"\n"
                                                   "position = [0, 1, 0]\ncage.cells = [2, 2, 10]\ncontact = \"{}\"\n",
                                                   (folder / "bar.obj").string(), contact)},
                              {}));
  };
  for (const std::string contact : {"obstacles", "none", "others"}) CHECK(of(contact).model.bodies[0].num_points == 8);
  const Simulation simulation = of("all");
  CHECK(simulation.model.bodies[0].num_points > 1000);
  CHECK(simulation.bodies[0].embedding->hex.size() == 8);
  // where they are at rest: on the bar, the vertices first
  const EmbeddedPoints& points = *simulation.model.bodies[0].surface;
  double farthest = 0;
  for (Eigen::Index p = 0; p < points.size(); ++p) {
    const Vector3d place =
        points.weights.row(p) * hex_nodes(simulation.model, simulation.model.rest_positions, points.hex[p]);
    const Vector3d from_centre = (place - Vector3d(0, 1, 0)).cwiseAbs();
    const double outside = std::max({from_centre.x() - 0.1, from_centre.y() - 0.1, from_centre.z() - 0.5});
    farthest = std::max(farthest, std::abs(outside));
    if (p < 8) CHECK((place - simulation.bodies[0].shape.mesh.positions.row(p).transpose()).norm() < 1e-12);
  }
  CHECK(farthest < 1e-9);
}

TEST_CASE("a run whose contacts are between vertices goes on to the same bytes") {
  const TemporaryFolder folder;
  write_prism(folder / "bar.obj", square, 1);
  make_file(folder / "cross.toml",
            crossing(folder / "bar.obj", "rotation = [0, 90, 0]\nposition = [0, 0, 0]",
                     "rotation = [90, 0, 0]\nposition = [0.013, 0.05, 0.215]\nvelocity = [0, 0, -1]"));
  const auto simulate = [&](const std::string& run, const Words& more) {
    return exit_code_of(Words{"simulate", (folder / "cross.toml").string(), "-o", (folder / run).string(), "--quiet"} +
                        more);
  };
  REQUIRE(simulate("whole", {"--set", "clip.frames=12"}) == 0);
  REQUIRE(simulate("resumed", {"--set", "clip.frames=5"}) == 0);
  REQUIRE(simulate("resumed", {"--set", "clip.frames=12", "--resume"}) == 0);
  CHECK(states_of(folder / "whole") == states_of(folder / "resumed"));
}

TEST_CASE("a mesh obstacle with thin walls is told finely enough to hold what falls on it, or said to be too thin") {
  const TemporaryFolder folder;
  const double thickness = GENERATE(0.008, 0.003);
  write_prism(folder / "sheet.obj", {{-0.5, -thickness}, {0.5, -thickness}, {0.5, 0}, {-0.5, 0}}, 1);
  const Simulation simulation = set_up(parse_scene({.text = fmt::format(R"([clip]
frames = 12
[body.ball]
shape = "sphere"
radius = 0.1
position = [0.02, 0.35, 0.03]
velocity = [0, -5, 0]
cage.cells = [3, 3, 3]
[obstacle.sheet]
shape = "mesh"
mesh = "{}"
position = [0, 0, 0]
)",
                                                                        (folder / "sheet.obj").string())},
                                                   {}));
  const bool is_told = thickness > 0.005;
  REQUIRE(simulation.warnings.size() == (is_told ? 0 : 1));
  if (!is_told) {
    CHECK(simulation.warnings[0].find("obstacle.sheet: it has walls of 0.003 m") == 0);
    return;
  }
  Workspace workspace(simulation.model);
  State state = rest_state(simulation.model);
  for (int i = 0; i < 12; ++i) {
    const StepReport report = step(simulation.model, simulation.options, workspace, state);
    CHECK(report.status == StepStatus::converged);
    CHECK(state.positions.col(1).minCoeff() > -0.02);
  }
}

TEST_CASE("a plate lies on the ground though it touches in more places than its nodes can tell apart") {
  const TemporaryFolder folder;
  write_prism(folder / "plate.obj", {{-1, -0.03}, {1, -0.03}, {1, 0.03}, {-1, 0.03}}, 2);
  const Simulation simulation = set_up(parse_scene({.text = R"(
[clip]
frames = 14
substeps = 6
[body.plate]
mesh = "plate.obj"
position = [0, 0.06, 0]
friction = 0.5
cage.cells = 49
material.young = "15 kPa"
material.density = "500 kg/m^3"
limit.stretch = "20 %"
[obstacle.ground]
shape = "plane"
friction = 0.5
)",
                                                    .file = "plate.toml",
                                                    .folder = folder.path(),
                                                    .name = "plate"}));
  Workspace workspace(simulation.model);
  State state = rest_state(simulation.model);
  long long sweeps = 0;
  int most_contacts = 0;
  for (int i = 0; i < 78; ++i) {
    const StepReport report = step(simulation.model, simulation.options, workspace, state);
    REQUIRE(report.status == StepStatus::converged);
    CHECK(report.kkt_residual < 1e-3);
    CHECK(report.max_penetration < 1e-3);
    sweeps += report.linear_iterations;
    most_contacts = std::max(most_contacts, report.contacts);
  }
  CHECK(3 * most_contacts > simulation.model.num_nodes());
  CHECK(sweeps < 25000);  // 54,000 as long as forces went on being shared anew
}
