// umax export: whole or not at all, and where it cannot be, it is said; what is replaced, and what lies there already.
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>

#include "tests/support/failure.h"
#include "tests/tools/exported_block.h"
#include "tools/exchange/export_list.h"

using namespace umax;
using namespace umax::exported_block;
using test::contains;
using test::failure_of;
namespace fs = std::filesystem;

TEST_CASE("files that are there are not replaced unasked") {
  const TemporaryFolder folder;
  export_block(folder.path(), {});
  const std::string before = read_file(folder / "block.pc2");
  const auto failure = failure_of([&] { export_block(folder.path(), {.scale = 2}); });
  CHECK(failure.code == 73);
  CHECK(contains(failure.message, "--overwrite"));
  CHECK(read_file(folder / "block.pc2") == before);
  // another cache shares the mesh at rest as long as it is the same one
  export_block(folder.path(), {.format = ExportFormat::mdd});
  CHECK(failure_of([&] { export_block(folder.path(), {.format = ExportFormat::obj, .scale = 2}); }).code == 73);
  export_block(folder.path(), {.scale = 2, .overwrite = true});
  CHECK(read_file(folder / "block.pc2") != before);
}

TEST_CASE("what cannot be exported says why, and leaves nothing half-written") {
  const TemporaryFolder folder;
  const std::string out = folder.path().string();
  const auto refused = [&](const Words& words) { return export_by_program(words + Words{"-o", out}); };
  CHECK(refused({}).exit_code == 2);
  CHECK(contains(refused({}).messages, "--format pc2|mdd"));
  CHECK(refused({"--format", "fbx"}).exit_code == 2);
  CHECK(contains(refused({"--format", "fbx"}).messages, "pc2"));
  CHECK(contains(refused({"--format", "pc2", "--bodies", "blck"}).messages, "did you mean block?"));
  CHECK(refused({"--format", "pc2", "--bodies", "block,"}).exit_code == 2);
  CHECK(refused({"--format", "pc2", "--up", "x"}).exit_code == 2);
  CHECK(refused({"--format", "pc2", "--scale", "0"}).exit_code == 2);
  CHECK(refused({"--format", "pc2", "--frames", "1,2,4"}).exit_code == 2);
  CHECK(refused({"--format", "pc2", "--frames", "13"}).exit_code == 2);
  CHECK(fs::is_empty(folder.path()));
  CHECK(export_by_program({"--format", "pc2", "-o", "/proc/none"}).exit_code == 73);
  CHECK(umax_program({"export", out, "--format", "pc2"}).exit_code == 66);
}

TEST_CASE("a missing or damaged state ends an export without its files") {
  const TemporaryFolder folder;
  fs::copy(block_run(), folder / "run", fs::copy_options::recursive);
  const fs::path state = state_path(folder / "run", 7);
  const Words words{"export", (folder / "run").string(), "--quiet", "--format", "pc2"};
  std::string bytes = file_text(state);
  bytes[bytes.size() / 2] ^= 1;
  make_file(state, bytes);
  const ProcessResult damaged = umax_program(words);
  CHECK(damaged.exit_code == 65);
  CHECK(contains(damaged.messages, "0007.state"));
  CHECK(!fs::exists(folder / "run/export/block.pc2"));
  CHECK(!has_half_written_files(folder / "run"));
  fs::remove(state);
  // without --frames, all that are there up to the gap
  CHECK(umax_program(words + Words{"--frames", "1-12"}).exit_code == 66);
  CHECK(umax_program(words).exit_code == 0);
  CHECK(fs::file_size(folder / "run/export/block.pc2") ==
        32 + 6 * 12 * std::size_t(block().bodies[0].shape.mesh.num_vertices()));
  for (int frame = 1; frame <= 12; ++frame) fs::remove(state_path(folder / "run", frame));
  CHECK(umax_program(words + Words{"--overwrite"}).exit_code == 66);
}

TEST_CASE("a full disk ends an export without its files") {
  block();
  for (const char* format : {"pc2", "mdd", "abc", "usd", "gltf", "ply", "vtu"}) {
    CAPTURE(format);
    const TemporaryFolder folder;
    rlimit before{};
    ::getrlimit(RLIMIT_FSIZE, &before);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{.rlim_cur = 3000, .rlim_max = before.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
    const auto failure =
        failure_of([&] { export_block(folder.path(), {.format = parse_export_format(format), .things = {"block"}}); });
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    CHECK(failure.code == 73);
    CHECK(contains(failure.remedy, "ulimit -f"));
    CHECK(!has_half_written_files(folder.path()));
    for (const char* file : {"block.pc2", "block.mdd", "block.abc", "block.usda", "block.gltf", "block.bin"})
      CHECK(!fs::exists(folder / file));
  }
}

TEST_CASE("what a full disk ended is called again, by --resume where there is such") {
  const TemporaryFolder folder;
  fs::copy(block_run(), folder / "run", fs::copy_options::recursive);
  const auto limited = [&](const std::string& words) {
    return run_process(
        {"bash", "-c", "ulimit -f 1; cd " + folder.path().string() + "; exec " UMAX_PROGRAM " " + words});
  };
  const ProcessResult exported = limited("export run --format ply"), rendered = limited("render run --no-clip");
  CHECK(exported.exit_code == 73);
  CHECK(contains(exported.messages, "(ulimit -f), then call it again"));
  CHECK(rendered.exit_code == 74);
  CHECK(contains(rendered.messages, "(ulimit -f), then go on with --resume"));
}

TEST_CASE("an export that is asked to stop leaves no file half-written") {
  const TemporaryFolder folder;
  fs::copy(block_run(), folder / "run", fs::copy_options::recursive);
  const fs::path state = state_path(folder / "run", 7);
  fs::rename(state, folder / "state");
  REQUIRE(::mkfifo(state.c_str(), 0600) == 0);  // the program waits here
  const std::string command =
      std::string(UMAX_PROGRAM) + " export run --format pc2 --quiet & program=$!; sleep 0.5; " +
      "kill -TERM $program; cat state > run/states/0007.state & feeder=$!; wait $program; code=$?; " +
      "kill $feeder 2>/dev/null; exit $code";  // which waits where nobody reads
  CHECK(run_process({"bash", "-c", "cd " + folder.path().string() + "; " + command}).exit_code == 128 + SIGTERM);
  CHECK(!fs::exists(folder / "run/export/block.pc2"));
  CHECK(!has_half_written_files(folder / "run"));
}

TEST_CASE("a run that is replaced takes its exports along, and nothing else") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string(), run = (folder / "run").string();
  const Words words{"simulate", scene, "-o", run, "--frames", "1-3", "--quiet"};
  CHECK(exit_code_of(words + Words{"--export", "pc2", "--export", "ply"}) == 0);
  CHECK(fs::exists(folder / "run/export/block.pc2"));
  CHECK(fs::exists(folder / "run/export/block/0003.ply"));
  make_file(folder / "run/export/mine.blend", "mine");
  make_file(folder / "run/export/.block.pc2.part-999999999", "left by a killed export");
  CHECK(exit_code_of(words + Words{"--overwrite"}) == 0);
  const auto left = fs::directory_iterator(folder / "run/export");
  CHECK(std::distance(begin(left), end(left)) == 1);
  CHECK(fs::exists(folder / "run/export/mine.blend"));
  // what is asked for cannot be had: before the first step
  CHECK(exit_code_of({"simulate", scene, "-o", run + "2", "--frames", "1,2,4", "--export", "pc2"}) == 2);
  CHECK(!fs::exists(run + "2"));
}

TEST_CASE("a longer run is exported anew when it goes on") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string(), run = (folder / "run").string();
  for (const Words& more : {Words{"--frames", "1-3"}, Words{"--frames", "1-5", "--resume"}})
    CHECK(exit_code_of(Words{"simulate", scene, "-o", run, "--quiet", "--export", "pc2"} + more) == 0);
  CHECK(read_pc2(folder / "run/export/block.pc2", 4).rows() > 0);
}

TEST_CASE("what lies there in other axes or another unit is not left among new files unsaid") {
  const TemporaryFolder folder;
  export_block(folder.path(), {.format = ExportFormat::pc2, .things = {"block"}});
  export_block(folder.path(), {.format = ExportFormat::gltf, .things = {"block"}});
  // another cache, and more frames of a sequence, in another space than what is beside them
  const auto failure = failure_of(
      [&] { export_block(folder.path(), {.format = ExportFormat::mdd, .things = {"block"}, .z_up = true}); });
  CHECK(failure.code == 73);
  CHECK(contains(failure.what, "--up y --scale 1"));
  CHECK(contains(failure.what, "--up z --scale 1"));
  export_block(folder.path(), {.format = ExportFormat::ply, .things = {"block"}}, {2, 3});
  CHECK(failure_of([&] {
          export_block(folder.path(), {.format = ExportFormat::ply, .things = {"block"}, .scale = 10}, {4});
        }).code == 73);
  // asked for, it goes: what stays fits, or says its axes itself
  export_block(folder.path(), {.format = ExportFormat::mdd, .things = {"block"}, .z_up = true, .overwrite = true});
  CHECK(fs::exists(folder / "block.mdd"));
  CHECK(!fs::exists(folder / "block.pc2"));
  CHECK(fs::exists(folder / "block.gltf"));
  export_block(folder.path(), {.format = ExportFormat::ply, .things = {"block"}, .scale = 10, .overwrite = true}, {4});
  CHECK(fs::exists(folder / "block/0004.ply"));
  CHECK(!fs::exists(folder / "block/0002.ply"));
}

TEST_CASE(
    "a run that goes on refuses to put caches beside those of other axes, and tells of those that are too short") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string(), run = (folder / "run").string();
  const Words start{"simulate", scene, "-o", run, "--progress", "plain", "--frames"};
  CHECK(exit_code_of(start + Words{"1-3", "--export", "pc2"}) == 0);
  const ProcessResult longer = umax_program(start + Words{"1-5", "--resume"});
  CHECK(longer.exit_code == 0);
  CHECK(contains(longer.messages, "block.pc2 (1-3)"));
  CHECK(exit_code_of({"export", run, "--format", "mdd", "--up", "z", "--overwrite", "--quiet"}) == 0);
  const ProcessResult other = umax_program(start + Words{"1-5", "--resume", "--export", "pc2"});
  CHECK(other.exit_code == 73);
  CHECK(contains(other.messages, "--up z"));
  CHECK(!fs::exists(folder / "run/export/block.pc2"));
}

TEST_CASE("USD: value clips of a longer clip do not outlive it") {
  const TemporaryFolder folder;
  export_block(folder.path(), {.format = ExportFormat::usd, .things = {"block"}});
  ExportList list = read_export_list(folder.path());
  make_file(folder / "block.clips/0001.usda", "of an earlier export");
  list["block.clips/0001.usda"] = list.at("block.usda");
  write_export_list(folder.path(), list);
  export_block(folder.path(), {.format = ExportFormat::usd, .things = {"block"}, .overwrite = true});
  CHECK(!fs::exists(folder / "block.clips"));
  CHECK(fs::exists(folder / "block.usda"));
}
