// The set-up of a simulation as another program calls it: alone, without the command line, renderers and fits.
#include <link.h>
#include <oneapi/tbb/global_control.h>
#include <xmmintrin.h>

#include <clocale>
#include <csignal>
#include <cstdlib>
#include <set>

#include "core/base/error.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tools/setup/simulation_setup.h"

using namespace umax;

namespace {

/// The shared libraries of this program, by file name.
std::set<std::string> loaded_libraries() {
  std::set<std::string> names;
  const auto add = [](dl_phdr_info* library, std::size_t, void* list) {
    static_cast<std::set<std::string>*>(list)->insert(std::filesystem::path(library->dlpi_name).filename().string());
    return 0;
  };
  ::dl_iterate_phdr(add, &names);
  return names;
}

bool has_library(const std::set<std::string>& libraries, const std::string& name) {
  const auto found = libraries.lower_bound("lib" + name);
  return found != libraries.end() && found->starts_with("lib" + name);
}

/// What a process has only once.
struct ProcessState {
  std::vector<void (*)(int)> handlers;  // of signals
  unsigned floating_point = 0;          // modes of rounding, of denormal numbers and of exceptions
  std::string locale, environment;
  std::size_t threads = 0;
  bool operator==(const ProcessState&) const = default;
};

ProcessState process_state() {
  constexpr unsigned sticky_flags = 0x3f;  // exceptions that have been, which any sum may raise
  ProcessState state;
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGFPE, SIGXFSZ, SIGCHLD}) {
    struct sigaction action{};
    ::sigaction(signal, nullptr, &action);
    state.handlers.push_back(action.sa_handler);
  }
  state.floating_point = _mm_getcsr() & ~sticky_flags;
  state.locale = std::setlocale(LC_ALL, nullptr);
  for (char** variable = environ; *variable != nullptr; ++variable) state.environment += *variable + std::string("\n");
  using oneapi::tbb::global_control;
  state.threads = global_control::active_value(global_control::max_allowed_parallelism);
  return state;
}

/// The state files of the first frames, by this program's own loop.
std::vector<std::string> first_states(const Simulation& simulation, int frames) {
  Workspace workspace(simulation.model);
  State state = rest_state(simulation.model);
  std::vector<std::string> files{encode_state(state, simulation.digest)};
  while (int(files.size()) < frames) {
    for (int i = 0; i < simulation.scene.clip.substeps; ++i)
      step(simulation.model, simulation.options, workspace, state);
    files.push_back(encode_state(state, simulation.digest));
  }
  return files;
}

}  // namespace

TEST_CASE("a set-up links no library of the command line, the renderers and the fits") {
  const std::set<std::string> libraries = loaded_libraries();
  CHECK(has_library(libraries, "cholmod"));  // of the solver: the list is not empty
  for (const char* name : {"cairo", "ceres", "glog", "embree", "OSMesa", "fontconfig", "X11"}) {
    CAPTURE(name);
    CHECK(!has_library(libraries, name));
  }
}

TEST_CASE("a scene is set up and stepped to the very states of the program") {
  const std::string scene = GENERATE("sphere", "collapse", "beam");
  CAPTURE(scene);
  const TemporaryFolder folder;
  const std::string run = (folder / "run").string();
  const std::string command =
      std::string(UMAX_PROGRAM) + " simulate " + scene + " --frames 1-4 --quiet --threads 1 -o " + run;
  REQUIRE(std::system(command.c_str()) == 0);
  const std::vector<std::string> states = first_states(set_up(load_scene(scene)), 4);
  for (std::size_t i = 0; i < states.size(); ++i) {
    CAPTURE(i);
    const bool same = states[i] == file_text(run + "/states/000" + std::to_string(i + 1) + ".state");
    CHECK(same);
  }
}

TEST_CASE("a set-up and its steps leave the process as they found it") {
  const ProcessState before = process_state();
  const Simulation simulation = set_up(load_scene("figure", {{"body.figure.cage.cells", "60"}}));
  first_states(simulation, 2);
  CHECK(process_state() == before);
}

TEST_CASE("faults of a scene are exceptions that name the thing, not messages and not an end") {
  try {
    set_up(load_scene("beam", {{"body.beam.fixed", "[{min = [5, 5, 5], max = [6, 6, 6]}]"}}));
    FAIL("nothing was thrown");
  } catch (const Error& error) {
    CHECK(error.fault() == Fault::bad_data);
    CHECK(std::string(error.what()).find("body.beam") != std::string::npos);
  }
}
