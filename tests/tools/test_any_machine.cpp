// The same bytes however many threads there are, wherever and at whatever priority they run, and with one instruction set.
#include <nlohmann/json.hpp>

#include "tests/support/catch.h"
#include "tests/tools/program.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

/// A body of many hexes that hits the ground in its first step, at its limits.
std::string landing_scene(const std::string& solver) {
  return R"([clip]
frames = 4
[solver]
linear = ")" +
         solver + R"("
[body.block]
shape = "box"
size = [0.4, 0.4, 0.4]
position = [0, 0.3, 0]
rotation = [10, 0, 20]
velocity = [0, -3, 0]
cage.cells = [8, 8, 8]
material.young = "20 kPa"
limit.stretch = "10 %"
[obstacle.ground]
shape = "plane"
[render]
size = [48, 27]
samples = 2
)";
}

struct Bytes {
  std::map<std::string, std::string> states, pictures;
  bool operator==(const Bytes&) const = default;
};

/// What `umax run` leaves of the scene when it is called that way, with these further options.
Bytes bytes_of(const TemporaryFolder& folder, const fs::path& scene, const Words& way, const Words& options) {
  const fs::path run = folder / "run";
  fs::remove_all(run);
  const ProcessResult result = run_process(
      way + Words{UMAX_PROGRAM, "run", scene.string(), "-o", run.string(), "--no-clip", "--quiet"} + options);
  INFO(result.messages);
  REQUIRE(result.exit_code == 0);
  return {states_of(run), pictures_of(run)};
}

std::string instruction_set_of(const fs::path& run) {
  return nlohmann::json::parse(file_text(run / "run.json")).at("instruction_set");
}

}  // namespace

TEST_CASE("states and pictures are the same bytes for any threads, under taskset and nice") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, landing_scene("multigrid"));
  const Bytes one = bytes_of(folder, scene, {}, {"--threads", "1"});
  CHECK(one.states.size() == 4);
  CHECK(one.pictures.size() == 4);
  for (const char* threads : {"2", "3", "8"}) {
    CAPTURE(threads);
    CHECK(bytes_of(folder, scene, {}, {"--threads", threads}) == one);
  }
  CHECK(bytes_of(folder, scene, {"taskset", "-c", "0"}, {}) == one);
  CHECK(bytes_of(folder, scene, {"taskset", "-c", "0", "nice", "-n", "19"}, {"--threads", "3"}) == one);
}

TEST_CASE("the option --isa avx2 pins kernels and OpenBLAS, and a run that goes on with others says so") {
  const TemporaryFolder folder;
  const fs::path scene = write_scene(folder, landing_scene("direct"));
  const Bytes best = bytes_of(folder, scene, {}, {});
  const std::string best_set = instruction_set_of(folder / "run");
  const Bytes pinned = bytes_of(folder, scene, {}, {"--isa", "avx2"});
  CHECK(instruction_set_of(folder / "run").starts_with("avx2 with "));
  CHECK(bytes_of(folder, scene, {"env", "UMAX_ISA=avx2"}, {"--threads", "3"}) == pinned);
  CHECK(exit_code_of({"run", scene.string(), "--isa", "sse"}) == 2);
  CHECK(run_process({"env", "UMAX_ISA=sse", UMAX_PROGRAM, "scenes"}).exit_code == 2);

  const bool differs = best_set != instruction_set_of(folder / "run");
  // OpenBLAS's kernels for Zen are those for Haswell; this program's differ where AVX-512 is taken
  const bool is_alike = !differs || (best_set.starts_with("avx2") && best_set.find("(Zen)") != std::string::npos);
  CHECK((best == pinned) == is_alike);  // otherwise nothing was pinned, or nothing depends on it
  const Words call{"simulate", scene.string(), "-o", (folder / "mixed").string(), "--set", "clip.frames=12"};
  REQUIRE(exit_code_of(call + Words{"--frames", "1-2"}) == 0);
  const ProcessResult resumed = umax_program(call + Words{"--resume", "--isa", "avx2"});
  CHECK(resumed.exit_code == 0);
  CHECK((resumed.messages.find("this call goes on by avx2 with ") != std::string::npos) == differs);
  CHECK((instruction_set_of(folder / "mixed").find(", then avx2 with ") != std::string::npos) == differs);
}
