// The numbers behind the colours of heat maps, and the bars that the colours are read from.
#include "tools/pictures/heat.h"

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "core/element/rotation.h"
#include "render/annotation/annotate.h"
#include "render/image/colormap.h"
#include "render/image/image_io.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/value_colors.h"
#include "tests/tools/program.h"
#include "tools/run/render_frames.h"
#include "tools/setup/state_file.h"

using namespace umax;

namespace {

Simulation simulation_of(const std::string& text, const std::vector<std::string>& settings = {}) {
  std::vector<Override> overrides;
  for (const std::string& setting : settings) overrides.push_back(parse_override(setting));
  return set_up(parse_scene({.text = text}, overrides));
}

std::string map_is(const std::string& map) {
  return "render.heatmap=" + map;
}

/// A block without limit or with one: 3 x 2 x 2 hexes that are no cubes.
std::string long_block(const std::string& limit) {
  return R"([body.block]
shape = "box"
size = [0.9, 0.4, 0.2]
cage.cells = [3, 2, 2]
material.young = "70 kPa"
material.poisson = 0.3
)" + limit;
}

State deformed(const Model& model, const Matrix3d& gradient) {
  State state = rest_state(model);
  state.positions = model.rest_positions * gradient.transpose();
  return state;
}

/// Stretch along x by `strain` as a free block does it.
Matrix3d uniaxial(double strain) {
  return Vector3d(1 + strain, 1 - 0.3 * strain, 1 - 0.3 * strain).asDiagonal();
}

bool all_near(const VectorXd& values, double expected) {
  return values.size() > 0 && (values.array() - expected).abs().maxCoeff() <= 1e-9 * std::max(1.0, expected);
}

HeatRange range_of(const Simulation& simulation, const std::vector<State>& states) {
  HeatRange range;
  for (const State& state : states) extend(range, simulation, state);
  return range;
}

}  // namespace

TEST_CASE("a uniformly stretched block shows its stretch, turned or not, limited or not") {
  const std::string limit = GENERATE("", "limit.stretch = \"10 %\"\n");
  const Simulation simulation = simulation_of(long_block(limit), {map_is("stretch")});
  const Matrix3d rotation = rotation_from_degrees({20, -50, 130});
  const auto shown = [&](const Matrix3d& gradient) {
    return heat_values(simulation, deformed(simulation.model, rotation * gradient));
  };
  CHECK(all_near(shown(uniaxial(0)), 0));
  CHECK(all_near(shown(uniaxial(0.2)), 20));
  CHECK(all_near(shown(uniaxial(-0.2)), 20));

  // pure shear: 1/2 G g^2 = 1/2 Y s^2
  Matrix3d shear = Matrix3d::Identity();
  shear(0, 1) = shear(1, 0) = 0.05;
  CHECK(all_near(shown(shear), 100 * 0.1 / std::sqrt(2 * (1 + 0.3))));
  // equal in all directions: 9/2 K e^2 = 1/2 Y s^2
  CHECK(all_near(shown(1.04 * Matrix3d::Identity()), 100 * 0.04 * std::sqrt(3 / (1 - 2 * 0.3))));
}

TEST_CASE("stretch follows a stiffness that changes over time") {
  // the energy of the same shape doubles, its stretch stays
  const Simulation simulation = simulation_of(
      long_block(""), {map_is("stretch"), "body.block.material.young={keys=[[0, \"70 kPa\"], [1, \"140 kPa\"]]}"});
  State state = deformed(simulation.model, uniaxial(0.2));
  state.time = 1;
  CHECK(all_near(heat_values(simulation, state), 20));
}

TEST_CASE("the energy map shows U/U_max, and nothing where there is no limit") {
  const Simulation limited = simulation_of(long_block("limit.stretch = \"10 %\"\n"), {map_is("energy")});
  CHECK(all_near(heat_values(limited, deformed(limited.model, uniaxial(0.2))), 4));
  const Simulation free = simulation_of(long_block(""), {map_is("energy")});
  CHECK(all_near(heat_values(free, deformed(free.model, uniaxial(0.2))), 0));
  CHECK(heat_values(simulation_of(long_block("")), rest_state(free.model)).size() == 0);
}

TEST_CASE("a hex that hangs on its limit is as many times stiffer as the multiplier map says") {
  const Simulation simulation = simulation_of(R"([clip]
fps = 100
[body.block]
shape = "box"
size = [0.1, 0.2, 0.1]
cage.cells = [1, 1, 1]
material.young = "2 kPa"
material.poisson = 0
material.density = 1000
material.mass = "lattice"
material.damping_mass = 5
limit.stretch = "10 %"
fixed = [{ min = [-1, 0.09, -1], max = [1, 0.11, 1] }]
)",
                                              {map_is("multiplier")});
  State state = rest_state(simulation.model);
  Workspace workspace(simulation.model);
  for (int i = 0; i < 60; ++i) step(simulation.model, simulation.options, workspace, state);
  const VectorXd shown = heat_values(simulation, state);
  // half its weight hangs on the lower nodes: (1 + lambda/U_max) Y A s = m g / 2
  const double weight = 1000 * 0.1 * 0.2 * 0.1 * 9.81, spring = 2e3 * 0.1 * 0.1 * 0.1;
  REQUIRE(shown.size() == 1);
  CHECK(shown[0] == Approx(weight / 2 / spring - 1).epsilon(5e-3));
}

TEST_CASE("the multiplier map shows the multipliers of the step") {
  const Simulation simulation = simulation_of(block_scene(), {map_is("multiplier")});
  State state = rest_state(simulation.model);
  Workspace workspace(simulation.model);
  int most_active = 0;
  for (int i = 0; i < 24; ++i) {
    const StepReport report = step(simulation.model, simulation.options, workspace, state);
    most_active = std::max(most_active, report.limits_active);
    const VectorXd shown = heat_values(simulation, state);
    CHECK((shown.array() > 0).count() == report.limits_active);
    for (Eigen::Index e = 0; e < shown.size(); ++e)
      CHECK(shown[e] * energy_limit_at(simulation.model, e, state.time) == Approx(state.limit_multipliers[e]));
  }
  CHECK(most_active > 0);
  const Simulation free = simulation_of(long_block(""), {map_is("multiplier")});
  CHECK(all_near(heat_values(free, deformed(free.model, uniaxial(0.2))), 0));
}

TEST_CASE("with limits on parts and peaks the energy map shows the one nearest to being reached") {
  const Simulation simulation = simulation_of(
      long_block("limit.stretch = \"10 %\"\nlimit.volumetric.stretch = \"40 %\"\nlimit.fibre.stretch = \"5 %\"\n"
                 "limit.fibre.direction = [0, 1, 0]\n"),
      {map_is("energy")});
  const auto shown = [&](const Matrix3d& gradient) {
    return heat_values(simulation, deformed(simulation.model, gradient));
  };
  CHECK(all_near(shown(uniaxial(0.2)), 4));                     // the whole
  CHECK(all_near(shown(Vector3d(1, 1.1, 1).asDiagonal()), 4));  // the fibre
  CHECK(all_near(
      heat_values(simulation_of(long_block("limit.stretch = \"10 %\"\nlimit.measure = \"peak\"\n"), {map_is("energy")}),
                  deformed(simulation.model, uniaxial(0.2))),
      4));
}

TEST_CASE("the multiplier map shows the part that a hex is stiffened most in, a peak by all of its points") {
  const Simulation parts =
      simulation_of(long_block("limit.stretch = \"10 %\"\nlimit.fibre.stretch = \"5 %\"\n"), {map_is("multiplier")});
  State state = rest_state(parts.model);
  state.limit_multipliers[0] = 2 * energy_limit_at(parts.model, 0, 0);
  state.limit_multipliers[1] = 3 * energy_limit_at(parts.model, 0, 0, EnergyPart::fibre);
  CHECK(heat_values(parts, state)[0] == Approx(3));
  CHECK(heat_values(parts, state)[1] == 0);
  const Simulation peak =
      simulation_of(long_block("limit.stretch = \"10 %\"\nlimit.measure = \"peak\"\n"), {map_is("multiplier")});
  state = rest_state(peak.model);
  state.limit_multipliers.segment(8, 8).setConstant(0.5 * energy_limit_at(peak.model, 1, 0));
  CHECK(heat_values(peak, state)[0] == 0);
  CHECK(heat_values(peak, state)[1] == Approx(4));
}

TEST_CASE("every hex whose limit acts is as red as a reached limit") {
  const std::string map = GENERATE("energy", "stretch");
  const Simulation simulation = simulation_of(block_scene(), {map_is(map)});
  State state = rest_state(simulation.model);
  const Legend legend = *heat_legend(simulation, range_of(simulation, {state}));
  Workspace workspace(simulation.model);
  int num_red = 0;
  for (int i = 0; i < 24; ++i) {
    step(simulation.model, simulation.options, workspace, state);
    const VectorXd shown = heat_values(simulation, state);
    for (Eigen::Index e = 0; e < shown.size(); ++e) {
      const bool red = color_on(legend, shown[e]) == color_of_value(1);
      if (state.limit_multipliers[e] > 0) CHECK(red);
      num_red += red;
    }
  }
  CHECK(num_red > 0);
  CHECK(num_red < 24 * 8);
}

TEST_CASE("the bar of stretches ends at the limit that all hexes share, otherwise at a round number") {
  const auto bar = [](const std::string& text, const std::vector<std::string>& settings = {}) {
    const Simulation simulation = simulation_of(text, Words{map_is("stretch")} + settings);
    State later = deformed(simulation.model, uniaxial(0.137));
    later.time = 1;
    return *heat_legend(simulation, range_of(simulation, {rest_state(simulation.model), later}));
  };
  const std::string
      limited = long_block("limit.stretch = \"15 %\"\n"),
      other = "[body.other]\nshape = \"box\"\nsize = [1, 1, 1]\nposition = [3, 0, 0]\ncage.cells = [1, 1, 1]\n";
  CHECK(bar(limited).high == Approx(15));
  CHECK(bar(limited).ends_at_limit);
  CHECK(bar(limited).title == "stretch [%]");
  CHECK(bar(limited + other + "limit.stretch = \"15 %\"\n").ends_at_limit);
  // 1/2 Y s^2 of 70 kPa
  CHECK(bar(long_block("limit.density = 350\n")).high == Approx(10));

  for (const Legend& round :
       {bar(long_block("")), bar(limited + other), bar(limited, {"solver.energy=paper"}),
        bar(limited + other + "limit.stretch = \"5 %\"\n"), bar(long_block("limit.fibre.stretch = \"15 %\"\n")),
        bar(limited, {"body.block.limit.measure=peak"}),
        bar(long_block("limit.stretch = { keys = [[0, \"20 %\"], [1, \"15 %\"]] }\n"))}) {
    CHECK_FALSE(round.ends_at_limit);
    CHECK(round.low == 0);
  }
  CHECK(bar(long_block("")).high == Approx(15));
}

TEST_CASE("render.heatmap_top ends the bar, whatever the range and the limit") {
  for (const std::string map : {"stretch", "multiplier"}) {
    const Simulation simulation =
        simulation_of(long_block("limit.stretch = 0.2\n"), {map_is(map), "render.heatmap_top=40"});
    HeatRange range;
    extend(range, simulation, deformed(simulation.model, uniaxial(0.7)));
    const Legend legend = heat_legend(simulation, range).value();
    CHECK(legend.high == 40);
    CHECK_FALSE(legend.ends_at_limit);
    CHECK(color_on(legend, 80) == color_on(legend, 40));
  }
}

TEST_CASE("the bar of multipliers is logarithmic and holds the largest of all states") {
  const Simulation simulation = simulation_of(long_block("limit.stretch = \"10 %\"\n"), {map_is("multiplier")});
  State calm = rest_state(simulation.model), busy = calm;
  const auto high = [&](double largest) {
    busy.limit_multipliers[5] = largest * energy_limit_at(simulation.model, 5, 0);
    const Legend legend = *heat_legend(simulation, range_of(simulation, {calm, busy, calm}));
    CHECK(legend.logarithmic);
    CHECK_FALSE(legend.ends_at_limit);
    return legend.high;
  };
  CHECK(high(0) == 1);
  CHECK(high(0.3) == 1);
  CHECK(high(1.9) == 2);
  CHECK(high(37) == 50);
  CHECK(high(51) == 100);
  CHECK(high(830) == 1000);
}

TEST_CASE("a colour means the same in all pictures of a clip, and what its legend says") {
  const TemporaryFolder folder;
  const std::string map = GENERATE("energy", "multiplier", "stretch");
  const std::filesystem::path run = folder / "run";
  const std::filesystem::path scene = write_scene(folder, block_scene());
  REQUIRE(exit_code_of({"simulate", scene.string(), "-o", run.string()}) == 0);
  const Simulation simulation = set_up(load_scene(scene.string(), {parse_override(map_is(map))}));
  std::vector<int> frames;
  for (int frame = 1; frame <= 12; ++frame) frames.push_back(frame);
  const RunPictures pictures = pictures_of_run(simulation, run, frames);
  double largest = 0;
  for (const int frame : frames) {
    const State state = read_state(state_path(run, frame), simulation.model, simulation.digest);
    const VectorXd heat = heat_values(simulation, state);
    const RenderScene shot = pictures.list.shot(frame), first = pictures.list.shot(1);
    REQUIRE(shot.legend);
    CHECK(shot.legend->title == first.legend->title);
    CHECK(shot.legend->high == first.legend->high);
    largest = std::max(largest, heat.maxCoeff());
    const VectorXi& hex = simulation.bodies[0].embedding->hex;
    const Points& colors = shot.objects[0].mesh->colors;
    for (Eigen::Index p = 0; p < hex.size(); ++p)
      CHECK(colors.row(p) == color_on(*shot.legend, heat[hex[p]]).cast<double>().transpose());

    const RenderScene around = turntable_of(simulation, state, {1, 2}).list.shot(2);
    REQUIRE(around.legend);
    CHECK(around.legend->title == first.legend->title);
  }
  CHECK(largest > 0);
  CHECK(largest <= pictures.list.shot(1).legend->high * (1 + simulation.options.solver.tolerance));
}

TEST_CASE("every heat map is drawn with its legend by both engines, and turntables draw it too") {
  const TemporaryFolder folder;
  const std::string map = GENERATE("energy", "multiplier", "stretch"), engine = GENERATE("embree", "osmesa");
  const std::filesystem::path scene = write_scene(folder, block_scene()), run = folder / "run";
  const Words look{"--set", map_is(map), "--set", "render.size=[384, 216]", "--engine", engine};
  REQUIRE(exit_code_of(Words{"run", scene.string(), "-o", run.string(), "--set", "clip.frames=9"} + look) == 0);
  REQUIRE(exit_code_of(
              Words{"turntable", run.string(), "--still", "9", "-o", (folder / "around").string(), "--frames", "2"} +
              look) == 0);
  for (const auto& picture : {run / "frames/0009.png", folder / "around/frames/0002.png"}) {
    const Image8 image = read_png8(picture);
    REQUIRE(image.width == 384);
    CHECK(num_of_color(image, 0.5, 270) >= 8);
    CHECK((num_of_color(image, 1, 270) > 0) == (map != "multiplier"));
  }
}
