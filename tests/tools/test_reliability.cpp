// What tools/reliability does not see: that files outlive a power cut.
#include <sstream>
#include <vector>

#include "tests/support/catch.h"
#include "tests/tools/program.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

bool can_trace() {
  return run_process({"bash", "-c", "strace true"}).exit_code == 0;
}

/// What stands between two marks of a line.
std::string between(const std::string& line, const std::string& first, const std::string& last) {
  const std::size_t begin = line.find(first);
  if (begin == line.npos) return {};
  const std::size_t start = begin + first.size(), end = line.find(last, start);
  return line.substr(start, end - start);
}

/// Successful calls of umax itself, in order: "sync PATH" and "rename FROM TO".
struct Traced {
  std::string call, path, target;
};
std::vector<Traced> traced(const fs::path& log) {
  std::vector<Traced> calls;
  std::istringstream lines(file_text(log));
  for (std::string line; std::getline(lines, line);) {
    if (line.find(" = 0") == line.npos) continue;
    if (line.find("fsync(") != line.npos || line.find("fdatasync(") != line.npos)
      calls.push_back({"sync", between(line, "<", ">"), {}});
    else if (line.find("rename(") != line.npos)
      calls.push_back({"rename", between(line, "(\"", "\""), between(line, ", \"", "\"")});
  }
  return calls;
}

}  // namespace

TEST_CASE("files are flushed before they get their names, and their folders after that") {
  if (!can_trace()) {
    WARN("left out: strace is not there, or may not trace");
    return;
  }
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string(), run = (folder / "run").string();
  REQUIRE(run_process({"strace", "-f", "-y", "-e", "trace=fsync,fdatasync,rename", "-o", (folder / "log").string(),
                       UMAX_PROGRAM, "run", scene, "-o", run, "--export", "obj"})
              .exit_code == 0);
  const std::vector<Traced> calls = traced(folder / "log");
  int states = 0, pictures = 0, clips = 0;
  for (std::size_t i = 0; i < calls.size(); ++i) {
    if (calls[i].call != "rename" || !calls[i].target.starts_with(run)) continue;
    CAPTURE(calls[i].target);
    bool was_flushed = false, has_folder = false;
    for (std::size_t k = 0; k < i; ++k) was_flushed |= calls[k].call == "sync" && calls[k].path == calls[i].path;
    for (std::size_t k = i + 1; k < calls.size(); ++k)
      has_folder |= calls[k].call == "sync" && calls[k].path == fs::path(calls[i].target).parent_path().string();
    CHECK(was_flushed);
    CHECK(has_folder);
    states += calls[i].target.ends_with(".state");
    pictures += calls[i].target.ends_with(".png");
    clips += calls[i].target.ends_with("clip.mp4");
  }
  CHECK(states == 12);
  CHECK(pictures == 12);
  CHECK(clips == 1);
}
