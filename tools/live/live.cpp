#include "tools/live/live.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <memory>

#include "core/base/error.h"
#include "tools/live/server.h"
#include "tools/system/signals.h"
#include "tools/system/subprocess.h"

namespace umax {
namespace {

bool has_screen() {
  const char* x = std::getenv("DISPLAY");
  const char* wayland = std::getenv("WAYLAND_DISPLAY");
  return (x && *x) || (wayland && *wayland);
}

/// What opens the address in the user's browser; null: nothing does.
std::unique_ptr<RunningProcess> open_browser(const std::string& address) {
  if (!has_screen() || !find_program("xdg-open")) return nullptr;
  return std::make_unique<RunningProcess>(std::vector<std::string>{"xdg-open", address});
}

void keep_session(const Session& session, const Recording& recording, Progress& progress) {
  if (session.state.step == 0) return;
  progress.note(fmt::format("the session is kept: umax simulate {}", save_session(session, recording).string()));
}

}  // namespace

int run_live(const Scene& scene, const LiveOptions& options, Progress& progress) {
  check_live_folder(options.folder, options.existing);
  page_files();  // what is missing is found out before the cage is made
  Session session(scene);
  for (const std::string& warning : session.simulation.warnings) progress.warning(warning);
  Recording recording(options.folder, options.existing, options.keep);

  const SignalWatch watch;
  std::unique_ptr<RunningProcess> browser;
  const auto tell_address = [&](const std::string& address, bool is_first) {
    progress.note(fmt::format("{} {}", is_first ? "umax live is at" : "another browser:", address));
    if (is_first && options.browser) browser = open_browser(address);
  };
  try {
    serve(session, recording,
          {.port = options.port,
           .on_address = tell_address,
           .on_line = [&](const std::string& line) { progress.note(line); },
           .ends = [] { return stop_signal() != 0; },
           .keep = options.keep});
  } catch (const Error&) {
    keep_session(session, recording, progress);
    throw;
  }
  keep_session(session, recording, progress);
  return stop_signal() == 0 ? 0 : 128 + stop_signal();
}

}  // namespace umax
