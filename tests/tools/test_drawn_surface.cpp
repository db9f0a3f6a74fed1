// render.surface: the smooth surface in pictures alone, and how far it leaves the one that contact feels.
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/tools/program.h"
#include "tools/pictures/drawn_surface.h"

using namespace umax;
namespace fs = std::filesystem;

TEST_CASE("a smooth surface changes pictures, not states, and a run says how far it leaves the trilinear one") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, block_scene()), plain = folder / "plain", smooth = folder / "smooth";
  REQUIRE(exit_code_of({"run", scene.string(), "-o", plain.string(), "--no-clip"}) == 0);
  const ProcessResult result =
      umax_program({"run", scene.string(), "-o", smooth.string(), "--no-clip", "--set", "render.surface=smooth"});
  REQUIRE(result.exit_code == 0);
  CHECK(files_in(plain / "states") == files_in(smooth / "states"));
  CHECK(file_text(plain / "frames/0012.png") != file_text(smooth / "frames/0012.png"));
  CHECK((result.messages + result.output).find("render.surface is smooth: at most") != std::string::npos);
  CHECK(file_text(smooth / "motion.json").find("smooth_departure_m") != std::string::npos);
  CHECK(file_text(plain / "motion.json").find("smooth_departure_m") == std::string::npos);
}

TEST_CASE("a body at rest or moved as a whole is drawn where it is") {
  const Simulation simulation = set_up(parse_scene({.text = block_scene("surface = \"smooth\"\n")}, {}));
  const Points rest = simulation.model.rest_positions;
  CHECK(departure_of_surface(simulation, rest) < 1e-14);
  CHECK(departure_of_surface(simulation, Points(2 * rest)) < 1e-14);
  Points bent = rest;
  for (auto node : bent.rowwise()) node[1] += 0.5 * node[0] * node[0];
  CHECK(departure_of_surface(simulation, bent) > 1e-4);
}
