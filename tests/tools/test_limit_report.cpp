// What inspect and a run's scene.toml tell of limits.
#include "tools/setup/limit_report.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/files/write_file.h"
#include "scenes/resolved_scene.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/tools/program.h"

using namespace umax;

namespace {

// hexes of 0.3 x 0.2 x 0.1 m, 0.006 m^3
constexpr const char* block = R"([body.block]
shape = "box"
size = [0.9, 0.4, 0.2]
cage.cells = [3, 2, 2]
material.young = { keys = [[0, "70 kPa"], [2, "280 kPa"]] }
material.poisson = 0.3
limit.energy = "2.1 J"
limit.fibre.stretch = "10 %"
limit.fibre.measure = "peak"
limit.volumetric.density = "140 J/m^3"
limit.volumetric.kind = "soft"
)";

}  // namespace

TEST_CASE("every limit of a body in all units and as strains, at every key of the stiffness") {
  const Scene scene = parse_scene({.text = block}, {});
  const std::vector<LimitReport> reports = limit_reports(scene.bodies[0], 0.006);
  REQUIRE(reports.size() == 6);
  const LimitReport &whole = reports[0], &later = reports[1], &volumetric = reports[2], &fibre = reports[4],
                    &fibre_later = reports[5];
  CHECK(whole.energy == Approx(2.1));
  CHECK(whole.density == Approx(350));
  CHECK(whole.strains.stretch == Approx(0.1));
  CHECK(whole.strains.shear == Approx(0.1 * std::sqrt(2.6)));
  CHECK(whole.strains.volume_change == Approx(0.1 * std::sqrt(1.2)));
  // four times as stiff: half the stretch for the same energy, four times the energy for the same stretch
  CHECK(later.time == 2);
  CHECK(later.strains.stretch == Approx(0.05));
  CHECK(volumetric.part == EnergyPart::volumetric);
  CHECK(volumetric.kind == LimitKind::soft);
  CHECK(std::isinf(volumetric.strains.shear));
  CHECK(volumetric.strains.volume_change == Approx(std::sqrt(2 * 140 * 1.2 / 70e3)));
  CHECK(fibre.measure == LimitMeasure::peak);
  CHECK(fibre.density == Approx(350));
  CHECK(fibre_later.density == Approx(1400));
}

TEST_CASE("inspect --json tells limits under stable keys") {
  const TemporaryFolder folder;
  write_file(folder / "block.toml", block);
  const ProcessResult result = umax_program({"inspect", (folder / "block.toml").string(), "--json"});
  REQUIRE(result.exit_code == 0);
  const auto body = nlohmann::json::parse(result.output)["bodies"]["block"];
  CHECK(body["limit"]["energy_J"] == Approx(2.1));
  CHECK(body["limit"]["density_J_m3"] == Approx(350));
  CHECK(body["limit"]["stretch"] == Approx(0.1));
  CHECK(body["limit"]["shear"] == Approx(0.1 * std::sqrt(2.6)));
  CHECK(body["limit"]["volume_change"] == Approx(0.1 * std::sqrt(1.2)));
  CHECK(body["limit"]["measure"] == "mean");
  REQUIRE(body["limit"]["keys"].size() == 1);
  CHECK(body["limit"]["keys"][0]["time_s"] == 2);
  CHECK(body["limit"]["keys"][0]["stretch"] == Approx(0.05));
  CHECK(body["part_limits"]["volumetric"]["kind"] == "soft");
  CHECK(body["part_limits"]["volumetric"]["shear"].is_null());
  CHECK(body["part_limits"]["fibre"]["measure"] == "peak");
  CHECK_FALSE(body["part_limits"].contains("deviatoric"));
}

TEST_CASE("a run's scene.toml says beside each limit what it means, and is read as the same scene") {
  const Simulation simulation = set_up(parse_scene({.text = block}, {}));
  const std::string told = resolved_toml(simulation.scene, limit_comments(simulation));
  CHECK(told.find("limit.energy = 2.1  # at 0 s: 2.1 J per hex = 350 J/m^3 = 10 % stretch") != std::string::npos);
  CHECK(told.find("; at 2 s: 2.1 J per hex = 350 J/m^3 = 5 % stretch") != std::string::npos);
  CHECK(told.find("limit.fibre.stretch = 0.1  # at 0 s: 2.1 J per hex = 350 J/m^3 = 10 % stretch along the fibre") !=
        std::string::npos);
  const Simulation again = set_up(parse_scene({.text = told}, {}));
  CHECK(again.digest == simulation.digest);
}

TEST_CASE("keys that tighten a limit abruptly are warned of, slow ones and loosening ones are not") {
  const auto warnings = [](const std::string& limit) {
    const std::string text = "[body.ball]\nshape = \"sphere\"\ncage.cells = 27\n" + limit;
    return set_up(parse_scene({.text = text}, {})).warnings;
  };
  const std::vector<std::string> sudden =
      warnings("limit.stretch = { keys = [[2, \"20 %\"], [2.001, \"5 %\"], [3, \"4 %\"]] }\n");
  REQUIRE(sudden.size() == 1);
  CHECK(sudden[0] ==
        "body.ball.limit falls from 20 % to 5 % stretch between 2 s and 2.001 s: what is stretched that far by then is "
        "thrown; spread the keys over 0.3 s or more");
  CHECK(warnings("limit.fibre.stretch = { keys = [[0, \"20 %\"], [0.1, \"5 %\"]] }\n").size() == 1);
  CHECK(warnings("limit.stretch = { keys = [[2, \"20 %\"], [3, \"5 %\"]] }\n").empty());
  CHECK(warnings("limit.stretch = { keys = [[2, \"5 %\"], [2.001, \"20 %\"]] }\n").empty());
  // the same joules are less stretch once the material is stiffer
  CHECK(warnings("limit.density = 10000\nmaterial.young = { keys = [[1, \"100 kPa\"], [1.1, \"1 MPa\"]] }\n").size() ==
        1);
}
