// Which bodies of a scene touch each other, and what is said of those that cannot.
#include "tools/setup/body_contact.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "embedding/embedding.h"
#include "render/image/image_io.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/tools/program.h"
#include "tools/setup/simulation_setup.h"
#include "tools/setup/stepping.h"

using namespace umax;

namespace {

/// Three small boxes apart, each with these keys.
std::string three_boxes(const std::string& a, const std::string& b, const std::string& c) {
  std::string text = "[clip]\nframes = 2\n";
  double x = 0;
  for (const auto& [name, keys] : {std::pair("a", a), std::pair("b", b), std::pair("c", c)}) {
    text += "[body." + std::string(name) + "]\nshape = \"box\"\nsize = [0.2, 0.2, 0.2]\ncage.cells = [1, 1, 1]\n";
    text += "position = [" + std::to_string(x++) + ", 1, 0]\n" + keys + "\n";
  }
  return text;
}

Simulation simulation_of(const std::string& text) {
  return set_up(parse_scene({.text = text}, {}));
}

/// What is said of three boxes of which the first `num_open` have lost their inside.
std::vector<std::string> warnings_of(Model model, int num_open) {
  for (int i = 0; i < num_open; ++i) model.bodies[std::size_t(i)].rest_surface = nullptr;
  std::vector<std::string> warnings;
  warn_of_open_meshes(model, warnings);
  return warnings;
}

/// The middle of a ring's thickness, by its surface: make_ring() has 64 vertices around each place.
Points centre_line(const Simulation& simulation, const State& state, std::size_t body) {
  constexpr Eigen::Index around = 64;
  const Model::BodyRange& range = simulation.model.bodies[body];
  Points surface;
  deform_positions(*simulation.bodies[body].embedding, simulation.bodies[body].lattice.hexes,
                   state.positions.middleRows(range.first_node, range.num_nodes), surface);
  Points line(surface.rows() / around, 3);
  for (Eigen::Index i = 0; i < line.rows(); ++i) line.row(i) = surface.middleRows(around * i, around).colwise().mean();
  return line;
}

/// How often one closed line winds around the other, by the integral of Gauss: a whole number, whatever their shape.
double linking_number(const Points& a, const Points& b) {
  double sum = 0;
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < b.rows(); ++j) {
      const Eigen::Index k = (i + 1) % a.rows(), l = (j + 1) % b.rows();
      const Vector3d along_a = a.row(k) - a.row(i), along_b = b.row(l) - b.row(j);
      const Vector3d between = 0.5 * (a.row(k) + a.row(i) - b.row(l) - b.row(j));
      sum += between.dot(along_a.cross(along_b)) / std::pow(between.norm(), 3);
    }
  return sum / (4 * std::numbers::pi);
}

}  // namespace

TEST_CASE(
    "the rings of the chain hang in each other while its fall stretches them, and none gets into the next but one") {
  const Simulation simulation = set_up(load_scene("chain"));
  Stepping stepping = begin_stepping(simulation);
  State state = rest_state(simulation.model);
  for (int step = 0; step < 32; ++step) {  // until the lowest ring has hit the ground
    const StepReport report = advance(stepping, {}, state);
    CHECK(report.status == StepStatus::converged);
    CHECK(report.max_energy_ratio <= 1.001);
    if (step % 8 != 7) continue;
    CAPTURE(step);
    std::vector<Points> lines;
    for (std::size_t b = 0; b < simulation.bodies.size(); ++b) lines.push_back(centre_line(simulation, state, b));
    for (std::size_t b = 1; b < lines.size(); ++b)
      CHECK(std::abs(linking_number(lines[b - 1], lines[b])) == Approx(1).margin(0.02));
    for (std::size_t b = 2; b < lines.size(); ++b)
      CHECK(linking_number(lines[b - 2], lines[b]) == Approx(0).margin(0.02));
  }
}

TEST_CASE("bodies touch as their keys say, both allowing it, and pairs are exceptions") {
  const Model model =
      simulation_of(three_boxes("friction = 0.3", "friction = 0.6\ncontact = \"others\"", "contact = \"obstacles\"") +
                    "[pair.slip]\nbodies = [\"b\", \"a\"]\nfriction = 0.1\n"
                    "[pair.apart]\nbodies = [\"a\", \"a\"]\ntouch = false\n"
                    "[pair.after_all]\nbodies = [\"a\", \"c\"]\n")
          .model;
  CHECK(may_touch(model, 0, 1));
  CHECK(may_touch(model, 0, 2));        // the pair
  CHECK_FALSE(may_touch(model, 1, 2));  // c does not allow it
  CHECK_FALSE(may_touch(model, 0, 0));  // the pair
  CHECK_FALSE(may_touch(model, 1, 1));  // others only
  CHECK(friction_between(model, 0, 1) == 0.1);
  CHECK(friction_between(model, 1, 2) == 0.6);
  CHECK(touches_obstacles(model, 2));
  CHECK_FALSE(touches_obstacles(simulation_of(three_boxes("", "contact = \"none\"", "")).model, 1));
}

TEST_CASE("what a body touches is part of what decides the states") {
  const Digest all = simulation_of(three_boxes("", "", "")).digest;
  const std::string pair = "[pair.p]\nbodies = [\"a\", \"b\"]\n";
  CHECK(simulation_of(three_boxes("contact = \"none\"", "", "")).digest != all);
  CHECK(simulation_of(three_boxes("", "", "") + pair).digest != all);
  CHECK(simulation_of(three_boxes("", "", "") + pair).digest !=
        simulation_of(three_boxes("", "", "") + pair + "friction = 0\n").digest);
}

TEST_CASE("bodies without an inside are named, so far as anything is to touch them") {
  const Model all = simulation_of(three_boxes("", "", "")).model;
  CHECK(warnings_of(all, 0).empty());
  CHECK(warnings_of(all, 1) ==
        std::vector<std::string>{
            "body.a is an open mesh: it touches other bodies by its vertices, and others pass through it",
            "body.a is an open mesh: its parts pass through each other; close it, or write contact = \"others\""});
  const std::vector<std::string> of_two = warnings_of(all, 2);
  REQUIRE(of_two.size() == 3);
  CHECK(of_two[0] ==
        "body.a and body.b are open meshes: they touch other bodies by their vertices, and others pass through them");
  CHECK(of_two[1] == "body.a and body.b are open meshes: they pass through each other");
  CHECK(warnings_of(all, 3)[0] == "body.a, body.b and body.c are open meshes: they pass through each other");

  const std::string others = "contact = \"others\"", obstacles = "contact = \"obstacles\"";
  CHECK(warnings_of(simulation_of(three_boxes(others, "", "")).model, 1).size() == 1);
  CHECK(warnings_of(simulation_of(three_boxes(obstacles, "", "")).model, 1).empty());
  CHECK(warnings_of(simulation_of(three_boxes("contact = \"none\"", "", "")).model, 1).empty());
  // the one other body that it could touch does not allow it
  CHECK(warnings_of(simulation_of(three_boxes(others, obstacles, obstacles)).model, 1).empty());
}

TEST_CASE("a run counts its contacts by what is touched") {
  const TemporaryFolder folder;
  const auto run = folder / "run";
  REQUIRE(exit_code_of({"simulate", write_scene(folder, block_scene()).string(), "-o", run.string(), "--quiet"}) == 0);
  std::string steps = file_text(run / "steps.csv");
  long long touching = 0;
  for (std::size_t line = steps.find('\n') + 1; line < steps.size(); line = steps.find('\n', line) + 1) {
    std::vector<std::string> values(1);
    for (std::size_t at = line; steps[at] != '\n'; ++at)
      if (steps[at] == ',')
        values.emplace_back();
      else
        values.back() += steps[at];
    REQUIRE(values.size() == 18 + 3 + 4);
    CHECK(values[21] == values[6]);  // all contacts are with the ground
    CHECK(values[22] == "0");
    CHECK(values[23] == "0");
    CHECK(values[24] == "1");
    touching += values[6] != "0";
  }
  CHECK(touching > 3);
}

TEST_CASE("umax inspect --picture marks where bodies are inside each other") {
  const TemporaryFolder folder;
  const auto boxes = [](double x) {
    return "[clip]\nframes = 2\n[body.a]\nshape = \"sphere\"\nradius = 0.2\nposition = [0, 1, 0]\ncage.cells = [4, 4, "
           "4]\n"
           "[body.b]\nshape = \"box\"\nsize = [0.3, 0.2, 0.2]\nposition = [" +
           std::to_string(x) + ", 1, 0]\ncage.cells = [6, 4, 4]\n";
  };
  // [px] of the whole scene's view that are coloured, where bodies are grey; left and right ends of them
  struct Coloured {
    int count = 0, left = 640, right = 0;
  };
  const auto coloured = [&](double x, const std::string& name) {
    const std::string scene = write_scene(folder, boxes(x), name + ".toml").string(),
                      png = (folder / name).string() + ".png";
    const ProcessResult result = umax_program({"inspect", scene, "--picture", "-o", png, "--json"});
    INFO(result.messages);
    REQUIRE(result.exit_code == 0);
    CHECK(nlohmann::json::parse(result.output)["overlap_picture"] == png);
    CHECK(exit_code_of({"inspect", scene, "--picture", "-o", png}) == 73);
    CHECK(exit_code_of({"inspect", scene, "--picture", "--map", "limit", "-o", png, "--overwrite"}) == 2);
    const Image8 picture = read_png8(png);
    Coloured found;
    for (int i = 0; i < 640 * 600; ++i) {
      const std::uint8_t* pixel = picture.pixel(i % 640, 80 + i / 640);
      const auto [low, high] = std::minmax({pixel[0], pixel[1], pixel[2]});
      if (high - low < 60) continue;
      ++found.count;
      found.left = std::min(found.left, i % 640);
      found.right = std::max(found.right, i % 640);
    }
    return found;
  };
  CHECK(coloured(0.5, "apart").count == 0);
  const Coloured overlapping = coloured(0.3, "overlapping");  // from x = 0.15 to 0.2, of -0.2 to 0.45
  CHECK(overlapping.count > 200);
  CHECK(overlapping.left > 250);
  CHECK(overlapping.right < 450);
}
