#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>

#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/tools/program.h"
#include "tools/run/job_estimate.h"
#include "tools/run/picture_estimate.h"
#include "tools/system/machine_memory.h"

using namespace umax;
using umax::test::contains;
using umax::test::failure_of;

namespace {

constexpr double gib = 1 << 30;

JobSize cube(double edge_cells, bool multigrid) {
  const double hexes = edge_cells * edge_cells * edge_cells, edge_nodes = edge_cells + 1;
  const double nodes = edge_nodes * edge_nodes * edge_nodes;
  return {.bodies = {{.name = "block", .hexes = hexes, .nodes = nodes, .slots = 1.2 * nodes}},
          .multigrid = multigrid,
          .may_multigrid = true};
}

Scene block_with(const std::vector<Override>& overrides) {
  std::vector<Override> all{{"body.block.rotation", "[0, 0, 0]"}};
  all.insert(all.end(), overrides.begin(), overrides.end());
  return parse_scene({.text = box_scene()}, all);
}

}  // namespace

TEST_CASE("sizes of memory are read with their units, and nonsense is refused") {
  CHECK(parse_memory("8G") == 8LL << 30);
  CHECK(parse_memory("8g") == 8LL << 30);
  CHECK(parse_memory("8 GiB") == 8LL << 30);
  CHECK(parse_memory("500M") == 500LL << 20);
  CHECK(parse_memory("1.5K") == 1536);
  CHECK(parse_memory("2TB") == 2LL << 40);
  CHECK(parse_memory("1000000") == 1000000);
  CHECK(parse_memory("12 B") == 12);
  for (const char* bad : {"", "G", "0", "0.1", "-8G", "8X", "8GG", "8 G B", "nan", "inf", "1e30", "8Gi"}) {
    CAPTURE(bad);
    CHECK(!parse_memory(bad));
  }
  CHECK(format_memory(1.25 * gib) == "1.2 GiB");
  CHECK(format_memory(250 * gib) == "250 GiB");
  CHECK(format_memory(350.2 * 1048576) == "350 MiB");
}

TEST_CASE("a machine gives what is free, and no more than any cgroup leaves") {
  const TemporaryFolder root;
  const auto write = [&](const std::string& path, const std::string& text) {
    std::filesystem::create_directories((root / path).parent_path());
    make_file(root / path, text);
  };
  CHECK(available_memory(root.path()) == 4LL << 30);
  write("proc/meminfo", "MemTotal:  9000000 kB\nMemAvailable:    8000000 kB\nSwapFree: 5 kB\n");
  CHECK(available_memory(root.path()) == 8000000LL * 1024);
  write("proc/self/cgroup", "4:memory:/old\n0::/farm/job\n");
  write("sys/fs/cgroup/farm/job/memory.max", "max\n");
  CHECK(available_memory(root.path()) == 8000000LL * 1024);
  write("sys/fs/cgroup/farm/memory.max", "5000000000\n");
  CHECK(available_memory(root.path()) == 5000000000);
  write("sys/fs/cgroup/farm/memory.current", "2000000000\n");
  write("sys/fs/cgroup/farm/memory.stat", "anon 1500000000\ninactive_file 500000000\n");
  CHECK(available_memory(root.path()) == 3500000000);
  write("sys/fs/cgroup/memory.max", "1000000000\n");
  CHECK(available_memory(root.path()) == 1000000000);
  CHECK(available_memory() > 1 << 20);

  CHECK(allowed_processors(root.path()) == std::floor(allowed_processors(root.path())));
  write("sys/fs/cgroup/farm/cpu.max", "max 100000\n");
  const double all = allowed_processors(root.path());
  write("sys/fs/cgroup/farm/cpu.max", "25000 100000\n");
  CHECK(all >= 1);
  CHECK(allowed_processors(root.path()) == 0.25);
}

TEST_CASE("what pictures take grows with pixels, paths and frames, and is told where it is much") {
  const PictureJob small{
      .pixels = 640 * 360, .samples = 16, .triangles = 232000, .pictures = 10, .shots = 10, .threads = 2};
  const PictureEstimate cost = estimate(small);
  CHECK(announce(small).empty());
  PictureJob large = small;
  large.pixels *= 4, large.samples *= 4, large.pictures = large.shots = 500, large.clip_frames = 500;
  CHECK(estimate(large).render_seconds > 4 * 50 * cost.render_seconds);
  CHECK(estimate(large).render_seconds < 16 * 50 * cost.render_seconds);
  CHECK(estimate(large).memory > cost.memory);
  CHECK(estimate(large).encode_seconds > 0);
  CHECK(contains(announce(large), "500 of about "));
  CHECK(contains(announce(large), " s by embree on 2 threads), and "));
  PictureJob filtered = small;
  filtered.is_filtered = true, filtered.window = 5, filtered.shots = 14;
  CHECK(estimate(filtered).render_seconds > 1.4 * cost.render_seconds);
  PictureJob one_thread = small;
  one_thread.threads = 1;
  CHECK(estimate(one_thread).render_seconds == Approx(2 * cost.render_seconds));
}

TEST_CASE("pictures to draw are counted with the neighbours that their filter looks at") {
  const Simulation simulation = set_up(block_with({{"render.denoise", "temporal"}, {"clip.frames", "40"}}));
  const PictureJob job = picture_job(simulation, {10, 11, 30}, 3, 2);
  CHECK(job.pictures == 3);
  CHECK(job.window == 5);
  CHECK(job.shots == 6 + 5);
  CHECK(job.pixels == 32 * 18);
  CHECK(job.triangles >= 12);
  CHECK(picture_job(simulation, {1, 40}, 0, 2).shots == 6);  // the clip's ends
}

TEST_CASE("direct solvers take memory like n^(4/3) and time like n^2, multigrid both like n") {
  const JobEstimate direct = estimate(cube(40, false)), direct_8 = estimate(cube(80, false));
  CHECK(direct_8.memory / direct.memory > 10);
  CHECK(direct_8.memory / direct.memory < 16);
  CHECK(direct_8.step_seconds / direct.step_seconds > 45);
  const JobEstimate grid = estimate(cube(40, true)), grid_8 = estimate(cube(80, true));
  CHECK(grid_8.memory / grid.memory < 8);
  CHECK(grid_8.step_seconds / grid.step_seconds == Approx(8));
  CHECK(grid.memory < direct.memory);
  CHECK(grid.step_seconds < direct.step_seconds);
  JobSize irregular = cube(40, false);
  irregular.bodies.front().irregular = true;
  CHECK(estimate(irregular).memory - direct.memory == Approx(12e3 * 64000));
  JobSize two = cube(40, false);
  two.bodies.push_back(two.bodies.front());
  CHECK(lattice_memory(two) == Approx(2 * lattice_memory(cube(40, false))));
}

TEST_CASE("on multigrids a thin cage takes the memory of the bricks that it does not fill") {
  const auto told = [](const std::string& cells, const std::string& size) {
    const Scene scene =
        block_with({{"body.block.cage.cells", cells}, {"body.block.size", size}, {"solver.linear", "multigrid"}});
    const Simulation simulation = set_up(scene);
    const double memory = lattice_memory(size_of(simulation));
    CHECK(memory == Approx(lattice_memory(size_of(scene, simulation.bodies))));
    return memory;
  };
  const double compact = told("[16, 16, 16]", "[1, 1, 1]"), sheet = told("[64, 64, 1]", "[4, 4, 0.0625]"),
               rod = told("[1, 1, 4096]", "[0.01, 0.01, 40.96]");
  CHECK(sheet > 2.5 * compact);
  CHECK(sheet < 6 * compact);
  CHECK(rod > 2 * sheet);
  CHECK(told("[64, 64, 2]", "[4, 4, 0.125]") < 1.5 * sheet);  // two fill the bricks better
}

TEST_CASE("only a large job is announced") {
  CHECK(announce(cube(5, false), 1000).empty());
  CHECK(announce(cube(20, true), 1).empty());
  const std::string text = announce(cube(100, true), 150);
  CAPTURE(text);
  CHECK(contains(text, " GiB of memory and "));
  CHECK(contains(text, "(150 steps of about "));
  CHECK(contains(text, "with solver.linear = multigrid"));
  CHECK(!announce(cube(5, false), 100'000'000).empty());  // long
}

TEST_CASE("a scene tells its size before there is a cage, the same as after where it can") {
  const auto told = [](const std::vector<Override>& overrides) { return size_of(block_with(overrides)); };
  CHECK(told({}).bodies.front().hexes == 8);
  CHECK(told({{"body.block.cage.cells", "1000"}}).bodies.front().hexes == 1000);
  CHECK(told({{"body.block.cage.cells", "[3, 4, 5]"}}).bodies.front().hexes == 60);
  CHECK(told({{"body.block.cage.cells", "[3, 4, 5]"}, {"body.block.rotation", "[0, 0, 45]"}}).bodies.front().hexes ==
        0);
  CHECK(told({{"body.block.cage.cell_size", "0.1"}}).bodies.front().hexes == 0);
  CHECK(told({{"solver.linear", "direct"}}).multigrid == false);
  CHECK(told({{"solver.linear", "multigrid"}}).multigrid == true);
  CHECK(told({{"solver.method", "paper"}}).may_multigrid == false);
  for (const char* linear : {"direct", "multigrid"}) {
    const Scene scene = block_with({{"solver.linear", linear}});
    const JobSize before = size_of(scene), after = size_of(set_up(scene));
    CHECK(before.multigrid == after.multigrid);
    CHECK(before.may_multigrid == after.may_multigrid);
    CHECK(before.bodies.front().hexes == after.bodies.front().hexes);
    CHECK(before.bodies.front().nodes == Approx(after.bodies.front().nodes));
  }
}

TEST_CASE("a cage of unknown size is counted as soon as it is made, before anything is made of it") {
  const Scene scene = block_with({{"body.block.cage.cell_size", "0.1"}, {"solver.linear", "direct"}});
  int calls = 0;
  const Simulation simulation = set_up(scene, [&](const std::vector<BodySetup>& caged) {
    ++calls;
    const JobSize size = size_of(scene, caged);
    CHECK(size.bodies.size() == 1);
    CHECK(size.bodies.front().hexes == 64);
    CHECK(size.bodies.front().nodes == 125);
    CHECK(!size.bodies.front().irregular);
  });
  CHECK(calls == 1);
  const JobSize before = size_of(scene, simulation.bodies), after = size_of(simulation);
  CHECK(estimate(before).memory == Approx(estimate(after).memory));
  const auto refuse = [&](const std::vector<BodySetup>& caged) { require_memory(size_of(scene, caged), scene, 1e6); };
  CHECK(failure_of([&] { set_up(scene, refuse); }).code == 65);
}

TEST_CASE("what does not fit is refused with numbers, and the advice holds") {
  const Scene scene = block_with({{"body.block.cage.cells", "1000000"}, {"solver.linear", "direct"}});
  const auto failure = failure_of([&] { require_memory(size_of(scene), scene, 8 * gib); });
  INFO(failure.message);
  CHECK(failure.code == 65);
  CHECK(failure.where == "body.block.cage");
  CHECK(contains(failure.what, "1000000 hexes with solver.linear = direct need about "));
  CHECK(contains(failure.what, "and there are 8.0 GiB"));
  CHECK(contains(failure.remedy, "solver.linear = multigrid (about "));
  CHECK(contains(failure.remedy, "--memory "));

  const std::string asked = "set cage.cells to at most ";
  REQUIRE(failure.remedy.starts_with(asked));
  const std::string cells = std::to_string(std::stoll(failure.remedy.substr(asked.size())));
  const auto fits = [&](const std::vector<Override>& more) {
    std::vector<Override> overrides{{"body.block.cage.cells", "1000000"}, {"solver.linear", "direct"}};
    overrides.insert(overrides.end(), more.begin(), more.end());
    const Scene other = block_with(overrides);
    return failure_of([&] { require_memory(size_of(other), other, 8 * gib); }).code == 0;
  };
  CHECK(fits({{"body.block.cage.cells", cells}}));
  CHECK(!fits({{"body.block.cage.cells", std::to_string(std::stoll(cells) * 12 / 10)}}));
  CHECK(fits({{"solver.linear", "multigrid"}}));
  CHECK(fits({{"solver.linear", "auto"}}));  // the solver is chosen for the model
}

TEST_CASE("advice is given in the words of the cage, and only where it helps") {
  const Scene scene = block_with({{"body.block.cage.cell_size", "4 cm"}, {"solver.linear", "direct"}});
  const JobSize size = size_of(set_up(scene));
  const auto remedy = [&](double memory) { return failure_of([&] { require_memory(size, scene, memory); }).remedy; };
  const std::string asked = "set cage.cell_size to at least ";
  const std::string text = remedy(estimate(size).memory - 0.8 * lattice_memory(size));
  INFO(text);
  REQUIRE(text.starts_with(asked));
  const double edge = std::stod(text.substr(asked.size()));
  CHECK(edge > 0.05);
  CHECK(edge < 0.12);
  CHECK(remedy(1e6).starts_with("--memory 1G"));  // not even one hex would fit
}

TEST_CASE("of several bodies every one that is too large is named a size") {
  Scene scene = block_with({{"body.block.cage.cells", "1000000"}, {"solver.linear", "direct"}});
  scene.bodies.push_back(scene.bodies.front());
  scene.bodies.back().name = "other";
  const auto failure = failure_of([&] { require_memory(size_of(scene), scene, 8 * gib); });
  INFO(failure.message);
  CHECK(contains(failure.what, "2000000 hexes"));
  const std::string asked = "set cage.cells to at most ";
  REQUIRE(failure.remedy.starts_with(asked));
  CHECK(contains(failure.remedy, ", of every body, or "));
  for (BodyDescription& body : scene.bodies) body.cage.size = std::stoi(failure.remedy.substr(asked.size()));
  CHECK(failure_of([&] { require_memory(size_of(scene), scene, 8 * gib); }).code == 0);
}

TEST_CASE("a job that does not fit is refused before anything is made, and --memory overrides") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, box_scene()).string(), run = (folder / "run").string();
  const Words huge{
      "simulate", scene, "-o", run, "--set", "body.block.cage.cells=5000000", "--set", "solver.linear=direct",
      "--frames", "1-2"};
  const ProcessResult refused = umax_program(huge + Words{"--memory", "20G"});
  INFO(refused.messages);
  CHECK(refused.exit_code == 65);
  CHECK(contains(refused.messages, "and there are 20.0 GiB; set cage.cells to at most "));
  CHECK(!std::filesystem::exists(run));
  // 50 MiB are less than the program itself
  for (const char* verb : {"run", "simulate"})
    CHECK(exit_code_of({verb, scene, "-o", run, "--memory", "50M", "--frames", "1-2"}) == 65);
  CHECK(!std::filesystem::exists(run));

  CHECK(exit_code_of({"simulate", scene, "-o", run, "--memory", "1T", "--frames", "1-2"}) == 0);
  CHECK(exit_code_of({"simulate", scene, "-o", run, "--resume", "--memory", "50M", "--frames", "1-2"}) == 0);
  CHECK(exit_code_of({"simulate", scene, "-o", run, "--resume", "--memory", "50M", "--frames", "1-3"}) == 65);
  CHECK(states_of(run).size() == 2);
}

TEST_CASE("a value of --memory that is no size is wrong usage") {
  for (const char* bad : {"8X", "-1G", "0", "much"}) {
    const ProcessResult result = umax_program({"simulate", "beam", "--memory", bad});
    INFO(result.messages);
    CHECK(result.exit_code == 2);
    CHECK(contains(result.messages, std::string("\"") + bad + "\" is no size of memory"));
  }
  CHECK(exit_code_of({"render", "run", "--memory", "8G"}) == 2);
}

#ifndef __SANITIZE_ADDRESS__  // whose own memory would be measured
namespace {

/// [bytes] peak of a run of the program, from the system's accounts.
double measured_peak(const Words& arguments) {
  const Words words = Words{UMAX_PROGRAM} + arguments;
  std::vector<char*> pointers;
  for (const std::string& word : words) pointers.push_back(const_cast<char*>(word.c_str()));
  pointers.push_back(nullptr);
  const pid_t child = fork();
  if (child == 0) {
    execv(pointers[0], pointers.data());
    _exit(127);
  }
  int status = 0;
  rusage usage{};
  REQUIRE(wait4(child, &status, 0, &usage) == child);
  REQUIRE(status == 0);
  return 1024.0 * double(usage.ru_maxrss);
}

void check_estimate_of(const std::string& scene, const std::vector<std::string>& settings) {
  const TemporaryFolder folder;
  Words words{"simulate", scene, "--frames", "1-2", "--quiet", "-o", (folder / "run").string()};
  std::vector<Override> overrides;
  for (const std::string& setting : settings) {
    words = words + Words{"--set", setting};
    overrides.push_back(parse_override(setting));
  }
  const double peak = measured_peak(words), told = estimate(size_of(set_up(load_scene(scene, overrides)))).memory;
  CAPTURE(scene, settings, peak, told);
  CHECK(told < 2 * peak);
  CHECK(told > 0.5 * peak);
}

}  // namespace

TEST_CASE("estimates of memory are within a factor of 2 of what is measured", "[slow]") {
  check_estimate_of("beam", {"solver.linear=direct"});
  check_estimate_of("beam", {"body.beam.cage.cells=[60,10,10]", "solver.linear=direct"});
  for (const std::string linear : {"direct", "multigrid"})  // on the ground, as a step in flight has nothing to solve
    check_estimate_of("figure",
                      {"body.figure.cage.cells=5000", "body.figure.drop_height=0 m", "solver.linear=" + linear});
}
#endif
