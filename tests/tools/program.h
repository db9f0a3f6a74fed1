// Runs the built program and looks at what it leaves.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"
#include "tools/system/subprocess.h"

namespace umax {

using Words = std::vector<std::string>;

inline Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

inline ProcessResult umax_program(const Words& arguments) {
  return run_process(Words{UMAX_PROGRAM} + arguments);
}
inline int exit_code_of(const Words& arguments) {
  return umax_program(arguments).exit_code;
}

/// A small block of 8 hexes that falls on the ground within its 12 frames; source: keys that say where its surface is from.
inline std::string scene_of_block(const std::string& source, const std::string& more) {
  return "[body.block]\n" + source + R"(position = [0, 0.24, 0]
rotation = [10, 0, 20]
cage.cells = [2, 2, 2]
material.young = "20 kPa"
limit.stretch = "10 %"
[clip]
frames = 12
substeps = 2
[obstacle.ground]
shape = "plane"
[probe.middle]
body = "block"
point = [0, 0.24, 0]
[render]
size = [32, 18]
samples = 1
denoise = false
)" + more;
}

/// That of a file of few triangles, of which a run takes half as long as of the box.
inline std::string block_scene(const std::string& more = {}) {
  return scene_of_block("mesh = \"" UMAX_SOURCE_DIR "/tests/support/block.obj\"\n", more);
}

/// The box of scene files.
inline std::string box_scene(const std::string& more = {}) {
  return scene_of_block("shape = \"box\"\nsize = [0.4, 0.4, 0.4]\n", more);
}

inline std::filesystem::path write_scene(const TemporaryFolder& folder, const std::string& text,
                                         const std::string& name = "block.toml") {
  make_file(folder / name, text);
  return folder / name;
}

/// The bytes of a folder's files by name.
inline std::map<std::string, std::string> files_in(const std::filesystem::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files[entry.path().filename().string()] = file_text(entry.path());
  return files;
}

/// The states of a run, and its pictures.
inline std::map<std::string, std::string> states_of(const std::filesystem::path& run) {
  return files_in(run / "states");
}
inline std::map<std::string, std::string> pictures_of(const std::filesystem::path& run) {
  return files_in(run / "frames");
}

/// steps.csv without the column wall_ms.
inline std::string steps_without_time(const std::filesystem::path& run) {
  constexpr int time_column = 17;
  std::string text;
  int column = 0;
  for (const char character : file_text(run / "steps.csv")) {
    if (character == '\n')
      column = 0;
    else if (character == ',')
      ++column;
    if (column != time_column || character == '\n') text += character;
  }
  return text;
}

inline bool has_half_written_files(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
    if (entry.path().filename().string().find(".part-") != std::string::npos) return true;
  return false;
}

}  // namespace umax
