// Disks that are full, read-only or gone, and limits on the size of files: said plainly, nothing half-written, gone on with.
#include <fmt/format.h>

#include "tests/support/catch.h"
#include "tests/tools/program.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

/// Whether we may mount a small file system of our own, as root may.
bool can_mount() {
  const TemporaryFolder folder;
  return run_process({"bash", "-c", "unshare -m mount -t tmpfs none \"$0\"", folder.path().string()}).exit_code == 0;
}

bool leave_out() {
  if (can_mount()) return false;
  WARN("left out: only root may mount a small disk");
  return true;
}

Words run_words(const TemporaryFolder& folder) {
  return {"run", write_scene(folder, block_scene()).string(), "--set", "clip.substeps=4"};
}

/// Runs a script in which $0 is the program, $1 a folder that only the script sees a small disk in, $2 one outside, and "${@:3}"
/// the words of a run.
ProcessResult on_small_disk(const TemporaryFolder& folder, const std::string& script) {
  fs::create_directories(folder / "disk");
  return run_process(
      Words{"unshare", "-m", "bash", "-c", script, UMAX_PROGRAM, (folder / "disk").string(), folder.path().string()} +
      run_words(folder));
}

void check_same_run(const fs::path& a, const fs::path& b) {
  const bool same_clip = file_text(a / "clip.mp4") == file_text(b / "clip.mp4");
  CHECK(states_of(a) == states_of(b));
  CHECK(steps_without_time(a) == steps_without_time(b));
  CHECK(pictures_of(a) == pictures_of(b));
  CHECK(same_clip);
  CHECK(!has_half_written_files(b));
}

void check_words(const ProcessResult& result, const std::string& reason, const std::string& remedy) {
  CAPTURE(result.messages);
  CHECK(result.messages.find("umax: error: ") != std::string::npos);
  CHECK(result.messages.find(reason) != std::string::npos);
  CHECK(result.messages.find(remedy) != std::string::npos);
  CHECK(result.messages.find("internal") == std::string::npos);
}

}  // namespace

TEST_CASE("on a disk that is full at any point a run ends with 73 or 74, and goes on when there is room") {
  if (leave_out()) return;
  const TemporaryFolder folder;
  REQUIRE(exit_code_of(run_words(folder) + Words{"-o", (folder / "whole").string()}) == 0);
  long long size = 0;
  for (const auto& entry : fs::recursive_directory_iterator(folder / "whole"))
    if (entry.is_regular_file()) size += (long long)(entry.file_size() + 4095) / 4096 * 4096;
  int full = 0;
  for (const int percent : {5, 15, 40, 60, 75, 90}) {
    CAPTURE(percent);
    fs::remove_all(folder / "out");
    const ProcessResult result = on_small_disk(
        folder,
        fmt::format(
            "mount -t tmpfs -o size={} none \"$1\" || exit 99; \"$0\" \"${{@:3}}\" -o \"$1/run\"; code=$?; "
            "ls -R -a \"$1\" | grep part-; "
            "mount -o remount,size=100m \"$1\"; \"$0\" \"${{@:3}}\" -o \"$1/run\" --resume > \"$2/log\" 2>&1 || "
            "{{ cat \"$2/log\" >&2; exit 98; }}; cp -r \"$1/run\" \"$2/out\"; exit $code",
            size * percent / 100));
    CAPTURE(result.messages, result.output);
    CHECK((result.exit_code == 73 || result.exit_code == 74));
    full += result.exit_code == 73 || result.exit_code == 74;
    CHECK(result.messages.find("umax: error: ") != std::string::npos);
    CHECK(result.messages.find("space") != std::string::npos);
    CHECK(result.output.find(".part-") == std::string::npos);
    if (fs::exists(folder / "out")) check_same_run(folder / "whole", folder / "out");
  }
  CHECK(full == 6);
}

TEST_CASE("whichever of its first files a full disk takes from a run, it goes on when there is room") {
  if (leave_out()) return;
  int full = 0;
  for (int pages = 1; pages <= 9; ++pages) {
    CAPTURE(pages);
    const TemporaryFolder folder;
    const ProcessResult result = on_small_disk(
        folder,
        fmt::format("mount -t tmpfs -o size={}k none \"$1\" || exit 99; "
                    "\"$0\" simulate \"$4\" --frames 1 --quiet -o \"$1/run\"; code=$?; "
                    "mount -o remount,size=100m \"$1\"; \"$0\" simulate \"$4\" --frames 1 --quiet -o \"$1/run\" "
                    "--resume || exit 98; exit $code",
                    4 * pages));
    CAPTURE(result.messages);
    CHECK((result.exit_code == 73 || result.exit_code == 74 || result.exit_code == 0));
    full += result.exit_code != 0;
  }
  CHECK(full >= 5);
}

TEST_CASE("a file system for reading alone is told, and what is on it stays") {
  if (leave_out()) return;
  const TemporaryFolder folder;
  const std::string script =
      "mount -t tmpfs none \"$1\" || exit 99; \"$0\" \"${@:3}\" -o \"$1/run\" --frames 1-3 || exit 98; "
      "mount -o remount,ro \"$1\"; ";
  for (const char* call : {"\"$0\" \"${@:3}\" -o \"$1/run\" --resume", "\"$0\" \"${@:3}\" -o \"$1/new\"",
                           "\"$0\" render \"$1/run\" --overwrite", "\"$0\" encode \"$1/run\""}) {
    CAPTURE(call);
    const ProcessResult result = on_small_disk(folder, script + call);
    CHECK(result.exit_code == 73);
    check_words(result, "Read-only file system", "mount it for writing");
  }
}

TEST_CASE("a disk that vanishes ends a run with 73 or 74") {
  if (leave_out()) return;
  const TemporaryFolder folder;
  const std::string appear = "for i in $(seq 3000); do [ -e \"$1/run/{}\" ] && break; sleep 0.01; done; ";
  for (const char* file : {"states/0003.state", "frames/0003.png"}) {
    CAPTURE(file);
    const ProcessResult result = on_small_disk(
        folder,
        "mount -t tmpfs none \"$1\" || exit 99; \"$0\" \"${@:3}\" --set clip.frames=4000 --set render.samples=64 -o "
        "\"$1/run\" " +
            std::string(fs::path(file).extension() == ".png" ? "--frames 1-200" : "") + " & " +
            fmt::format(fmt::runtime(appear), file) + "umount -l \"$1\"; wait $!");
    CHECK((result.exit_code == 73 || result.exit_code == 74));
    check_words(result, "vanished", "--resume");
  }
  CHECK(fs::is_empty(folder / "disk"));
}

TEST_CASE("a limit on the size of files ends a run with 73 or 74, whatever file it hits, and it goes on without") {
  const TemporaryFolder folder;
  REQUIRE(exit_code_of(run_words(folder) + Words{"-o", (folder / "whole").string()}) == 0);
  int hit = 0;
  for (const int kilobytes : {1, 3, 5, 8}) {
    CAPTURE(kilobytes);
    const fs::path run = folder / ("run" + std::to_string(kilobytes));
    const Words limited{"bash", "-c", fmt::format("ulimit -f {}; exec \"$0\" \"$@\"", kilobytes), UMAX_PROGRAM};
    const ProcessResult result = run_process(limited + run_words(folder) + Words{"-o", run.string()});
    if (result.exit_code != 0) {
      ++hit;
      CHECK((result.exit_code == 73 || result.exit_code == 74));
      check_words(result, "arge", "ulimit -f");
      if (fs::exists(run)) CHECK(!has_half_written_files(run));
    }
    REQUIRE(exit_code_of(run_words(folder) + Words{"-o", run.string(), "--resume"}) == 0);
    check_same_run(folder / "whole", run);
  }
  CHECK(hit >= 3);
}
