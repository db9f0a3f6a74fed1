// Several processes that draw one clip together: the bytes of one, nothing drawn twice, nothing lost.
#include <fmt/format.h>

#include <map>
#include <vector>

#include "tests/support/catch.h"
#include "tests/tools/program.h"
#include "tools/run/picture_record.h"
#include "tools/run/picture_work.h"
#include "tools/run/run_scene.h"
#include "tools/system/worker.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

constexpr int clip_frames = 16;

fs::path shared_scene(const TemporaryFolder& folder) {
  return write_scene(folder, block_scene("[camera]\nposition = [0, 0.6, 3]\n"));
}

const Words settings{"--set", fmt::format("clip.frames={}", clip_frames),
                     "--set", "render.denoise=temporal",
                     "--set", "render.samples=2",
                     "--set", "render.size=[96, 54]"};

/// The run that one process makes.
fs::path run_alone(const TemporaryFolder& folder, const Words& more = {}) {
  REQUIRE(exit_code_of(Words{"run", shared_scene(folder).string(), "-o", (folder / "one").string()} + settings +
                       more) == 0);
  return folder / "one";
}

fs::path simulate_alone(const TemporaryFolder& folder, const std::string& name = "many") {
  REQUIRE(exit_code_of(Words{"simulate", shared_scene(folder).string(), "-o", (folder / name).string()} + settings) ==
          0);
  return folder / name;
}

/// Runs a script of bash whose $0 is the program and $1 the folder.
ProcessResult run_script(const std::string& script, const fs::path& run) {
  return run_process({"bash", "-c", script, UMAX_PROGRAM, run.string()});
}

/// Says that a frame is drawn; its number follows.
const std::string frame_drawn = "\"stage\":\"render\",\"frame\":";

/// How often frames were said to be done, by all whose output lies in `folder` as *.log.
std::map<int, int> frames_done(const fs::path& folder) {
  std::map<int, int> counts;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".log") continue;
    const std::string text = file_text(entry.path());
    for (std::size_t at = text.find(frame_drawn); at != text.npos; at = text.find(frame_drawn, at + 1))
      ++counts[std::atoi(text.c_str() + at + frame_drawn.size())];
  }
  return counts;
}

void check_each_once(const fs::path& folder) {
  const std::map<int, int> counts = frames_done(folder);
  CHECK(counts.size() == clip_frames);
  for (const auto& [frame, count] : counts) {
    CAPTURE(frame);
    CHECK(count == 1);
  }
}

void check_same_pictures(const fs::path& one, const fs::path& many) {
  CHECK(pictures_of(one) == pictures_of(many));
  const bool is_same_clip = file_text(one / "clip.mp4") == file_text(many / "clip.mp4");
  CHECK(is_same_clip);
  CHECK(!has_half_written_files(many));
  CHECK(!fs::exists(many / ".umax"));
}

/// Waits in a script until something is so, for a minute at most.
std::string wait_until(const std::string& condition) {
  return "for i in $(seq 3000); do " + condition + " && break; sleep 0.02; done; ";
}
std::string wait_for_pictures(int count) {
  return wait_until(fmt::format("[ $(ls \"$1/frames\" 2>/dev/null | grep -c '^[0-9]') -ge {} ]", count));
}

/// Stops the script's last process in the middle of a frame: while it holds one of which there is no picture yet. It goes
/// on when the script ends, at the latest.
const std::string stop_in_a_frame =
    "trap \"kill -CONT $! 2> /dev/null\" EXIT; draws() { for held in \"$1\"/.umax/frame-*; do n=${held##*/frame-}; "
    "[ -e \"$held\" ] && [ ! -e \"$1/frames/${n:0:4}.png\" ] && return; done; return 1; }; "
    "stop() { kill -STOP $!; sleep 0.05; draws \"$1\" || { kill -CONT $!; return 1; }; }; " +
    wait_until("stop \"$1\"");
const std::string kill_in_a_frame = stop_in_a_frame + "kill -KILL $!; wait; ";

/// Waits in a script until so many are at work in the folder.
std::string wait_for_workers(int count) {
  return wait_until(fmt::format("[ $(ls \"$1/.umax\" | grep -c '^worker-') = {} ]", count));
}

/// Lets nobody begin to draw in the folder before a script removes "$1/.umax/door.1".
void hold_door(const fs::path& run) {
  fs::create_directory(run / ".umax");
  make_file(run / ".umax/door.1", worker_text(this_worker("holds the door until all are there")));
}

/// Whether a process may have another host's name, as root may.
bool has_other_hosts() {
  return run_process({"bash", "-c", "unshare --uts hostname another-host"}).exit_code == 0;
}
constexpr const char* as_other_host = "unshare --uts bash -c 'hostname another-host; exec \"$0\" \"$@\"' ";

}  // namespace

TEST_CASE("the setting in which two scenes differ is named") {
  const std::string there = "name = \"x\"\n[render]\nsamples = 4\nsize = [1, 2]\n[body.a]\nlook.color = 1\n";
  CHECK(first_difference(there, there).empty());
  std::string here = there;
  here.replace(here.find("= 4"), 3, "= 8");
  CHECK(first_difference(there, here) == "render.samples is 4 there, 8 here");
  CHECK(first_difference(there, there + "[camera]\nfov = 3\n") == "camera.fov is not set there, 3 here");
}

/// What renders with these options make of one simulated clip, begun at the same moment, is what one run makes, each frame
/// drawn once.
void check_drawn_together(const TemporaryFolder& folder, const std::vector<std::string>& renders) {
  const fs::path one = run_alone(folder), many = simulate_alone(folder);
  hold_door(many);  // else the first may have ended before the last has come
  std::string script;
  for (std::size_t i = 0; i < renders.size(); ++i)
    script += fmt::format("\"$0\" render \"$1\" {} --progress json > \"${{1%/*}}/{}.log\" 2>&1 & all=\"$all $!\"; ",
                          renders[i], i + 1);
  script += wait_for_workers(int(renders.size())) + "rm \"$1/.umax/door.1\"; ";
  const ProcessResult result =
      run_script(script + "code=0; for one in $all; do wait $one || code=$?; done; exit $code", many);
  CAPTURE(result.messages);
  CHECK(result.exit_code == 0);
  check_each_once(folder.path());
  check_same_pictures(one, many);
}

TEST_CASE("several renders at once draw each frame once, and the pictures and clip of one") {
  const TemporaryFolder folder;
  check_drawn_together(folder, std::vector<std::string>(4, "--threads 1"));
  // one of them alone made the clip
  int clips = 0;
  for (int i = 1; i <= 4; ++i)
    clips += file_text(folder / (std::to_string(i) + ".log")).find("\"clip: ") != std::string::npos;
  CHECK(clips == 1);
}

TEST_CASE("two renders of parts at once make the clip of all frames") {
  const TemporaryFolder folder;
  check_drawn_together(folder, {"--frames 1-8", "--frames 9-16"});
}

TEST_CASE("who comes last of those who share a clip leaves it as it is") {
  const TemporaryFolder folder;
  const fs::path run = run_alone(folder);
  PictureRecord record = *read_picture_record(run / "pictures.json");
  record.frames.clear();  // all is drawn and there is no clip yet
  write_picture_record(run / "pictures.json", record);
  const std::string clip = file_text(run / "clip.mp4");
  fs::remove(run / "clip.mp4");

  const Scene scene = scene_of_run(run, {});
  Progress progress(stderr, ProgressMode::plain, true);
  const RunFolder last(run, ExistingFolder::keep, FolderUse::shared, draws_for_clip);
  {
    const RunFolder first(run, ExistingFolder::keep, FolderUse::shared, draws_for_clip);
    REQUIRE(finish_clip(first, {9, 10, 11, 12, 13, 14, 15, 16}, scene, progress) == 0);
  }
  const bool is_of_all = file_text(run / "clip.mp4") == clip;
  CHECK(is_of_all);
  const auto made = fs::last_write_time(run / "clip.mp4");
  REQUIRE(finish_clip(last, {1, 2, 3, 4, 5, 6, 7, 8}, scene, progress) == 0);
  CHECK(fs::last_write_time(run / "clip.mp4") == made);
  CHECK(read_picture_record(run / "pictures.json")->frames.size() == clip_frames);
  // from now on who draws a part is alone again
  REQUIRE(finish_clip(last, {1, 2, 3, 4, 5, 6, 7, 8}, scene, progress) == 0);
  CHECK(read_picture_record(run / "pictures.json")->frames.size() == 8);
}

TEST_CASE("a render of a part alone makes the clip of that part, and says so") {
  const TemporaryFolder folder;
  const fs::path run = simulate_alone(folder);
  const ProcessResult result = umax_program({"render", run.string(), "--frames", "3-6"});
  REQUIRE(result.exit_code == 0);
  CHECK(result.output.find("frames 3-6 alone") != std::string::npos);
  REQUIRE(exit_code_of({"render", run.string(), "--resume"}) == 0);
  const fs::path one = run_alone(folder);
  check_same_pictures(one, run);
}

TEST_CASE("a run is helped once it has simulated, and both make what one makes") {
  const TemporaryFolder folder;
  const Words more{"--set", "render.samples=150"};  // so that help comes in time
  const fs::path one = run_alone(folder, more), many = folder / "many";
  std::string run = "\"$0\" run \"${1%/*}/block.toml\" -o \"$1\" --progress json";
  for (const std::string& word : settings + more) run += " '" + word + "'";
  const ProcessResult result =
      run_script(run + " > \"${1%/*}/1.log\" & first=$!; " + wait_for_pictures(1) + stop_in_a_frame +
                     "\"$0\" render \"$1\" --progress json > \"${1%/*}/2.log\" & " +
                     wait_until("grep -q '" + frame_drawn + "' \"${1%/*}/2.log\"") +
                     "kill -CONT $first; wait $first || exit; wait $!",
                 many);
  CAPTURE(result.messages);
  CHECK(result.exit_code == 0);
  check_each_once(folder.path());
  check_same_pictures(one, many);
  CHECK(file_text(folder / "2.log").find(frame_drawn) != std::string::npos);
}

TEST_CASE("frames of renders that are killed are drawn by the others") {
  const TemporaryFolder folder;
  const fs::path one = run_alone(folder), many = simulate_alone(folder);
  // three are killed one after the other, and the last one does the rest
  std::string script = "\"$0\" render \"$1\" --threads 1 --progress json > \"${1%/*}/0.log\" 2>&1 & last=$!; ";
  for (int i = 1; i <= 3; ++i)
    script +=
        fmt::format(
            "\"$0\" render \"$1\" --threads 1 --resume --progress json > \"${{1%/*}}/{}.log\" 2>&1 & victim=$!; ", i) +
        wait_for_pictures(3 * i) + "kill -KILL $victim; ";
  const ProcessResult result = run_script(script + "wait $last", many);
  INFO(result.messages);
  CHECK(result.exit_code == 0);
  for (const auto& [frame, count] : frames_done(folder.path())) CHECK(count == 1);
  check_same_pictures(one, many);
}

TEST_CASE("a clip that the killed have left is gone on with") {
  const TemporaryFolder folder;
  const fs::path one = run_alone(folder), many = simulate_alone(folder);
  run_script("for i in 1 2; do \"$0\" render \"$1\" --progress json > \"${1%/*}/$i.log\" 2>&1 & done; " +
                 wait_for_pictures(5) + "kill -KILL $(jobs -p); wait",
             many);
  CHECK(fs::exists(many / ".umax"));  // what they have claimed
  REQUIRE(run_script("\"$0\" render \"$1\" --resume --progress json > \"${1%/*}/3.log\"", many).exit_code == 0);
  for (const auto& [frame, count] : frames_done(folder.path())) CHECK(count == 1);
  check_same_pictures(one, many);
}

TEST_CASE("renders with different settings do not mix: the second is told which one differs") {
  const TemporaryFolder folder;
  const fs::path many = simulate_alone(folder);
  const ProcessResult beside =
      run_script("\"$0\" render \"$1\" --set render.samples=64 > /dev/null & first=$!; " + stop_in_a_frame +
                     "\"$0\" render \"$1\" --samples 3; code=$?; kill -CONT $first; wait $first || exit; exit $code",
                 many);
  CAPTURE(beside.messages);
  CHECK(beside.exit_code == 73);
  CHECK(beside.messages.find("render.samples is 64 there, 3 here") != std::string::npos);
  const auto before = pictures_of(many);
  const std::string record = file_text(many / "pictures.json"), scene = file_text(many / "scene.toml");
  CHECK(before.size() == clip_frames);

  const ProcessResult later = umax_program({"render", many.string(), "--resume", "--samples", "3"});
  CHECK(later.exit_code == 73);
  CHECK(later.messages.find("render.samples is 64 there, 3 here") != std::string::npos);
  CHECK(pictures_of(many) == before);
  CHECK(file_text(many / "pictures.json") == record);
  CHECK(file_text(many / "scene.toml") == scene);
  REQUIRE(exit_code_of({"render", many.string(), "--overwrite", "--samples", "3"}) == 0);
  CHECK(pictures_of(many) != before);
}

TEST_CASE("renders that come at once with the same new setting draw together") {
  const TemporaryFolder folder;
  const fs::path many = simulate_alone(folder);
  hold_door(many);
  const std::string render = "\"$0\" render \"$1\" --set render.samples=3 --frames 1-4 > /dev/null & ";
  const ProcessResult result = run_script(
      render + "first=$!; " + render + wait_for_workers(2) + "rm \"$1/.umax/door.1\"; wait $first || exit; wait $!",
      many);
  CAPTURE(result.messages);
  CHECK(result.exit_code == 0);
  CHECK(pictures_of(many).size() == 4);
}

TEST_CASE("a folder in which pictures are drawn is neither simulated nor overwritten") {
  const TemporaryFolder folder;
  const fs::path many = simulate_alone(folder);
  std::string simulate = "\"$0\" simulate \"${1%/*}/block.toml\" --resume -o \"$1\"";
  for (const std::string& word : settings) simulate += " '" + word + "'";
  const ProcessResult result =
      run_script("\"$0\" render \"$1\" --set render.samples=64 > /dev/null & first=$!; " + stop_in_a_frame +
                     "\"$0\" render \"$1\" --overwrite; [ $? = 75 ] || exit 1; " + simulate +
                     "; [ $? = 75 ] || exit 2; kill -CONT $first; wait $first",
                 many);
  CAPTURE(result.messages);
  CHECK(result.exit_code == 0);
}

TEST_CASE("work is shared with another host, and what it leaves when it dies is free after its lease") {
  if (!has_other_hosts()) {
    WARN("left out: only root may give a process another host's name");
    return;
  }
  const TemporaryFolder folder;
  const fs::path one = run_alone(folder), both = simulate_alone(folder, "both"), lost = simulate_alone(folder, "lost");
  const std::string there = std::string(as_other_host) + "\"$0\" render \"$1\" --threads 1 --progress json ";
  const std::string here = "\"$0\" render \"$1\" --threads 1 --resume --progress json ";
  CHECK(run_script(
            there + "> \"${1%/*}/1.log\" & " + here + "> \"${1%/*}/2.log\"; code=$?; wait $! || code=$?; exit $code",
            both)
            .exit_code == 0);
  check_each_once(folder.path());
  check_same_pictures(one, both);
  CHECK(file_text(both / "run.json").find("\"exit_status\": 0") != std::string::npos);

  // it dies in the middle of a frame: here the file of a process that is gone looks like that of a living one elsewhere
  for (const char* log : {"1.log", "2.log"}) fs::remove(folder / log);
  run_script(
      "export UMAX_LEASE=3; " + there + "> \"${1%/*}/1.log\" & sleep 0.1; " + wait_for_pictures(3) + kill_in_a_frame,
      lost);
  const std::size_t drawn = frames_done(folder.path()).size();
  CHECK(drawn < clip_frames);
  // however slow the machine is, its lease ends only when nothing else is left to draw
  const ProcessResult rest =
      run_script(here +
                     "> \"${1%/*}/2.log\" & while kill -0 $! 2> /dev/null && ! grep -qs 'waiting for frames' "
                     "\"${1%/*}/2.log\"; do touch -c \"$1\"/.umax/*; sleep 0.1; done; wait $!",
                 lost);
  CHECK(rest.exit_code == 0);
  CHECK(file_text(folder / "2.log").find("waiting for frames") != std::string::npos);
  check_same_pictures(one, lost);
  for (const auto& [frame, count] : frames_done(folder.path())) CHECK(count == 1);
}

TEST_CASE("a simulation on another host keeps the folder until its heart has stopped") {
  if (!has_other_hosts()) {
    WARN("left out: only root may give a process another host's name");
    return;
  }
  const TemporaryFolder folder;
  const fs::path run = folder / "run";
  const std::string scene = shared_scene(folder).string();
  const std::string simulate = "\"$0\" simulate '" + scene + "' -o \"$1\" --resume --set clip.frames=100000";
  const ProcessResult result = run_script(
      "export UMAX_LEASE=2; " + std::string(as_other_host) + simulate + " > /dev/null 2>&1 & " +
          wait_until("[ -e \"$1/states/0003.state\" ]") + simulate + "; [ $? = 75 ] || exit 1; kill -KILL $!; wait; " +
          simulate + "; [ $? = 75 ] || exit 2; sleep 2.2; \"$0\" simulate '" + scene + "' -o \"$1\" --resume",
      run);
  CAPTURE(result.messages);
  CHECK(result.exit_code == 0);
  CHECK(result.messages.find("on another-host") != std::string::npos);
}
