// The program as a script sees it: exit codes, messages, files.
#include <algorithm>
#include <string>

#include "core/files/write_file.h"
#include "scenes/scene_key_table.h"
#include "tests/support/catch.h"
#include "tests/tools/program.h"
#include "tests/tools/two_cubes.h"
#include "tools/system/version.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

/// One line, no trace of our insides.
void check_message(const ProcessResult& result) {
  INFO(result.messages);
  CHECK(result.messages.find("umax: error: ") != std::string::npos);
  CHECK(result.messages.find("terminate") == std::string::npos);
  CHECK(result.messages.find("internal") == std::string::npos);
}

}  // namespace

TEST_CASE("wrong usage exits with 2 and says what is meant") {
  const TemporaryFolder folder;
  const Words words = GENERATE(Words{}, Words{"simulat", "beam"}, Words{"run"}, Words{"run", "beam", "sphere"},
                               Words{"run", "beam", "--thread", "2"}, Words{"run", "beam", "--threads", "0"},
                               Words{"simulate", "beam", "--frames", "5-1"}, Words{"reproduce", "figure7"},
                               Words{"tune", "beam"}, Words{"fit"}, Words{"export", "x"}, Words{"compare", "one.png"},
                               Words{"scenes", "beam"}, Words{"run", "beam", "--set", "novalue"},
                               Words{"run", "beam", "--size", "wide"}, Words{"help", "nothing"});
  CAPTURE(words);
  const ProcessResult result = umax_program(words);
  CHECK(result.exit_code == 2);
  check_message(result);
}

TEST_CASE("help, version and scenes go to standard output and exit with 0") {
  for (const Words& words : {Words{"help"}, Words{"-h"}, Words{"help", "run"}, Words{"run", "--help"},
                             Words{"--version"}, Words{"scenes"}}) {
    CAPTURE(words);
    const ProcessResult result = umax_program(words);
    CHECK(result.exit_code == 0);
    CHECK(!result.output.empty());
    CHECK(result.messages.empty());
  }
}

TEST_CASE("version, commit, compiler, instruction set and libraries are told by --version, one a line") {
  const std::string text = umax_program({"--version"}).output;
  CHECK(text.starts_with("umax " + version_text() + "\n"));
  for (const char* line : {"\ncommit ", "\nbuilt by ", "\ninstruction set ", "\nlibraries Eigen 3."})
    CHECK(text.find(line) != std::string::npos);
  CHECK(std::count(text.begin(), text.end(), '\n') == 5);
  CHECK(text.find(" ,") == std::string::npos);  // a library without its version
}

TEST_CASE("the Blender add-on and the changes have the program's version") {
  const std::filesystem::path root = UMAX_SOURCE_DIR;
  std::string tuple = "(" + version_text() + ")";
  for (std::size_t dot; (dot = tuple.find('.')) != std::string::npos;) tuple.replace(dot, 1, ", ");
  CHECK(file_text(root / "tools/blender/umax/blender_manifest.toml").find("\nversion = \"" + version_text() + "\"\n") !=
        std::string::npos);
  CHECK(file_text(root / "tools/blender/umax/__init__.py").find("\"version\": " + tuple) != std::string::npos);
  CHECK(file_text(root / "CHANGELOG.md").find("\n## " + version_text() + "\n") != std::string::npos);
}

TEST_CASE("umax help scene tells every key that a scene may have") {
  const ProcessResult result = umax_program({"help", "scene"});
  CHECK(result.exit_code == 0);
  CHECK(result.output == scene_key_help());
  for (const char* key : {"drop_height", "limit.stretch", "solver", "camera"})
    CHECK(result.output.find(key) != std::string::npos);
}

TEST_CASE("the built-in scenes are listed one a line with what they are") {
  const std::string text = umax_program({"scenes"}).output;
  for (const char* name : {"armadillo", "beam", "collapse", "figure", "sphere", "turntable"})
    CHECK(("\n" + text).find(std::string("\n") + name + " ") != std::string::npos);
}

TEST_CASE("what is not there exits with 66") {
  const TemporaryFolder folder;
  const std::string nothing = (folder / "nothing").string();
  for (const Words& words :
       {Words{"run", nothing + ".toml"}, Words{"simulate", "no-such-scene"}, Words{"inspect", nothing + ".obj"},
        Words{"drop", nothing + ".obj"}, Words{"render", nothing}, Words{"compare", nothing + ".png", nothing + ".png"},
        Words{"turntable", folder.path().string()}}) {
    CAPTURE(words);
    const ProcessResult result = umax_program(words + Words{"--threads", "1"});
    CHECK(result.exit_code == 66);
    check_message(result);
  }
}

TEST_CASE("bad scenes exit with 65 before anything is written") {
  const TemporaryFolder folder;
  const std::string set =
      GENERATE(as<std::string>(), "body.block.material.poisson=0.5", "body.block.material.poisson=-1",
               "body.block.material.young=-5 kPa", "body.block.material.density=0", "body.block.limit.energy=-1 J",
               "body.block.cage.cell_size=-1 cm", "body.block.cage.cells=0", "body.block.cage.cells=[1000, 1000, 1000]",
               "body.block.material.young=5 kg", "body.block.colour=red", "clip.frames=0",
               "body.block.fixed=[{min = [5, 5, 5], max = [6, 6, 6]}]", "probe.middle.point=[0, 9, 0]",
               "probe.middle.body=blok");
  CAPTURE(set);
  const ProcessResult result = umax_program(
      {"simulate", write_scene(folder, block_scene()).string(), "-o", (folder / "run").string(), "--set", set});
  CHECK(result.exit_code == 65);
  check_message(result);
  CHECK(!fs::exists(folder / "run"));
}

TEST_CASE("bad meshes exit with 65") {
  const TemporaryFolder folder;
  const std::vector<std::pair<std::string, std::string>> meshes{
      {"empty.obj", ""},
      {"no_triangles.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"},
      {"nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
      {"infinite.obj", "v 0 0 inf\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
      {"index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"},
      {"unknown.xyz", "1 2 3"},
      {"truncated.ply",
       "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face "
       "1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n"},
      {"point.obj", "v 1 1 1\nv 1 1 1\nv 1 1 1\nf 1 2 3\n"}};
  for (const auto& [name, text] : meshes) {
    make_file(folder / name, text);
    for (const char* verb : {"inspect", "drop"}) {
      CAPTURE(name, verb);
      const ProcessResult result =
          umax_program(Words{verb, (folder / name).string()} +
                       (std::string(verb) == "drop" ? Words{"-o", (folder / "run").string()} : Words{}));
      CHECK(result.exit_code == 65);
      check_message(result);
    }
  }
  CHECK(!fs::exists(folder / "run"));
}

TEST_CASE("a mesh of absurd size is refused and the options that mend it are named") {
  const TemporaryFolder folder;
  make_file(folder / "tall.obj", "v 0 0 0\nv 90 0 0\nv 0 180 0\nv 0 0 90\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  const ProcessResult refused = umax_program({"drop", (folder / "tall.obj").string(), "-o", (folder / "run").string()});
  CHECK(refused.exit_code == 65);
  for (const char* option : {"--unit", "--up", "--height"}) CHECK(refused.messages.find(option) != std::string::npos);
  for (const Words& mended : {Words{"--unit", "cm"}, Words{"--height", "180 cm"}, Words{"--unit", "0.01"}}) {
    const ProcessResult result = umax_program(Words{"inspect", (folder / "tall.obj").string(), "--json"} + mended);
    CHECK(result.exit_code == 0);
    CHECK(result.output.find("1.8") != std::string::npos);
  }
}

TEST_CASE("a wrong unit or axis is wrong usage") {
  const TemporaryFolder folder;
  make_file(folder / "t.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  for (const Words& wrong : {Words{"--unit", "parsec"}, Words{"--unit", "-1"}, Words{"--up", "w"},
                             Words{"--height", "2 kg"}, Words{"--height", "0"}})
    CHECK(exit_code_of(Words{"inspect", (folder / "t.obj").string()} + wrong) == 2);
}

TEST_CASE("output that cannot be made exits with 73 and leaves what was there") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string();
  make_file(folder / "taken/thesis.txt", "x");
  make_file(folder / "file", "x");
  CHECK(exit_code_of({"simulate", scene, "-o", (folder / "taken").string()}) == 73);
  CHECK(exit_code_of({"simulate", scene, "-o", (folder / "taken").string(), "--overwrite"}) == 73);
  CHECK(exit_code_of({"simulate", scene, "-o", (folder / "file").string(), "--overwrite"}) == 73);
  CHECK(exit_code_of({"simulate", scene, "-o", "/dev/null/run"}) == 73);
  CHECK(file_text(folder / "taken/thesis.txt") == "x");
}

TEST_CASE("a full disk ends a run with 74, whole files and a run that can go on") {
  const TemporaryFolder folder;
  const std::string run = (folder / "run").string();
  const Words simulate{"simulate", write_scene(folder, block_scene()).string(), "--set", "clip.substeps=8"};
  REQUIRE(exit_code_of(simulate + Words{"-o", (folder / "whole").string()}) == 0);
  // steps.csv is the only file that grows: the limit lies between the sizes of a state and of the table
  const auto limit = fs::file_size(folder / "whole/steps.csv") / 1024;
  REQUIRE(fs::file_size(folder / "whole/states/0012.state") / 1024 + 1 < limit);
  const Words limited{"bash", "-c", "ulimit -f " + std::to_string(limit) + "; exec \"$0\" \"$@\"", UMAX_PROGRAM};
  const ProcessResult result = run_process(limited + simulate + Words{"-o", run});
  CHECK(result.exit_code == 74);
  check_message(result);
  CHECK(!has_half_written_files(run));
  REQUIRE(exit_code_of(simulate + Words{"-o", run, "--resume"}) == 0);
  CHECK(states_of(run) == states_of(folder / "whole"));
  CHECK(steps_without_time(run) == steps_without_time(folder / "whole"));
}

TEST_CASE("a missing ffmpeg is found out before the first step") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string();
  const ProcessResult result =
      run_process({"env", "PATH=/nowhere", UMAX_PROGRAM, "run", scene, "-o", (folder / "run").string()});
  CHECK(result.exit_code == 69);
  check_message(result);
  CHECK(!fs::exists(folder / "run"));
}

TEST_CASE("OSMesa is loaded by what draws with it alone, and where it is missing that is said before a run starts") {
  const ProcessResult libraries = run_process({"env", "LD_TRACE_LOADED_OBJECTS=1", UMAX_PROGRAM});
  CHECK(libraries.output.find("libopenvdb") != std::string::npos);  // the list is not empty
  for (const char* name : {"OSMesa", "LLVM"}) CHECK(libraries.output.find(name) == std::string::npos);

  const TemporaryFolder folder;
  write_file(folder / "libOSMesa.so.8", "");
  const std::string damaged = "LD_LIBRARY_PATH=" + folder.path().string(), run = (folder / "run").string();
  const std::string scene = write_scene(folder, block_scene()).string();
  const auto umax = [&](const Words& words) { return run_process(Words{"env", damaged, UMAX_PROGRAM} + words); };
  const ProcessResult rasterised = umax({"run", scene, "--engine", "osmesa", "-o", run});
  CHECK(rasterised.exit_code == 69);
  check_message(rasterised);
  CHECK(rasterised.messages.find("libosmesa6") != std::string::npos);
  CHECK(!fs::exists(run));
  CHECK(umax({"run", scene, "--engine", "embree", "--frames", "1-2", "--no-clip", "-o", run}).exit_code == 0);
  const ProcessResult doctor = umax({"doctor", "-o", folder.path().string()});
  CHECK(doctor.exit_code == 69);
  CHECK(doctor.output.find("install libosmesa6") != std::string::npos);
}

TEST_CASE("umax doctor tells what is there, what is missing, and how to mend it") {
  const TemporaryFolder folder;
  const auto doctor = [&](const Words& environment) {
    return run_process(Words{"env"} + environment + Words{UMAX_PROGRAM, "doctor", "-o", folder.path().string()});
  };
  const ProcessResult whole = doctor({});
  CAPTURE(whole.output, whole.messages);
  CHECK(whole.exit_code == 0);
  for (const std::string name :
       {"processor", "threads", "memory", "files", "file system", "encoder", "rasteriser", "importer", "font", "plots"})
    CHECK(whole.output.find(name) != std::string::npos);
  CHECK(whole.output.find("MISSING") == std::string::npos);
  CHECK(fs::is_empty(folder.path()));  // it leaves nothing
  for (const auto& [environment, word] :
       std::vector<std::pair<std::string, std::string>>{{"PATH=/nowhere", "apt-get install ffmpeg"},
                                                        {"UMAX_JAVASCRIPT=/nowhere", "libjs-chart.js"},
                                                        {"UMAX_THREE=/nowhere", "libjs-three"}}) {
    const ProcessResult result = run_process({"/usr/bin/env", environment, UMAX_PROGRAM, "doctor"});
    CAPTURE(environment, result.output);
    CHECK(result.exit_code == 69);
    CHECK(result.output.find("MISSING") != std::string::npos);
    CHECK(result.output.find(word) != std::string::npos);
  }
  CHECK(exit_code_of({"doctor", "-o", "/nowhere"}) == 69);
  const ProcessResult narrow = run_process({"bash", "-c", "ulimit -f 1000000; taskset -c 0 \"$@\"", "bash",
                                            UMAX_PROGRAM, "doctor", "-o", folder.path().string()});
  CAPTURE(narrow.output);
  CHECK(narrow.exit_code == 0);
  CHECK(narrow.output.find("1 unless --threads says otherwise, on 1 of ") != std::string::npos);
  CHECK(narrow.output.find("files may have no more than") != std::string::npos);
}

TEST_CASE("odd sizes are refused before simulating when a clip is to be encoded") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string();
  CHECK(exit_code_of({"run", scene, "-o", (folder / "run").string(), "--size", "33x18"}) == 2);
  CHECK(!fs::exists(folder / "run"));
  CHECK(exit_code_of({"simulate", scene, "-o", (folder / "run").string(), "--set", "render.size=[33, 18]"}) == 0);
}

TEST_CASE("standard output that cannot be written is an error") {
  if (!fs::exists("/dev/full")) return;
  CHECK(run_process({"bash", "-c", "\"$0\" scenes > /dev/full", UMAX_PROGRAM}).exit_code == 74);
}

TEST_CASE("a start in penetration is warned of with body and depth, and ends well") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string();
  const ProcessResult result =
      umax_program({"simulate", scene, "-o", (folder / "run").string(), "--set", "body.block.position=[0, 0.15, 0]",
                    "--set", "probe.middle.point=[0, 0.15, 0]"});
  CHECK(result.exit_code == 0);
  CHECK(result.messages.find("warning: body.block starts 0.1") != std::string::npos);
}

TEST_CASE("inspect gives the numbers that scripts rely on") {
  const TemporaryFolder folder;
  const std::string scene = write_scene(folder, block_scene()).string();
  const ProcessResult result = umax_program({"inspect", scene, "--json"});
  REQUIRE(result.exit_code == 0);
  for (const char* key : {"vertices", "triangles", "cells", "nodes", "cell_size_m", "mesh_volume_m3",
                          "lattice_volume_m3", "mesh_mass_kg", "lattice_mass_kg", "watertight", "problems"})
    CHECK(result.output.find("\"" + std::string(key) + "\"") != std::string::npos);
  CHECK(result.output.find("\"cells\": 8") != std::string::npos);
  CHECK(result.output.find("\"nodes\": 27") != std::string::npos);
  CHECK(result.output.find("\"bodies\"") != std::string::npos);
}

TEST_CASE("inspect says once that a cage is in several pieces") {
  const TemporaryFolder folder;
  write_two_cubes(folder / "two.obj", 0.5);
  const std::string text = umax_program({"inspect", (folder / "two.obj").string(), "--cells", "16"}).output;
  const std::size_t first = text.find("2 pieces that share no node");
  REQUIRE(first != std::string::npos);
  CHECK(text.find("share no node", first + 27) == std::string::npos);
}
