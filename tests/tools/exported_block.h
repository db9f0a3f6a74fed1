// A small run that the tests of exports share, and what they read of its exports.
#pragma once

#include <cstring>

#include "core/files/read_file.h"
#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/tools/program.h"
#include "tools/exchange/export_clip.h"
#include "tools/run/render_frames.h"

namespace umax::exported_block {

inline const std::string plate = R"([obstacle.plate]
shape = "box"
size = [0.3, 0.05, 0.3]
position = { keys = [[0, [0, 0.9, 0]], [0.5, [0, 0.7, 0]]] }
rotation = { keys = [[0, [0, 0, 0]], [0.5, [0, 90, 0]]] }
)";

/// The block's run, simulated once for all tests of the process.
inline const std::filesystem::path& block_run() {
  static const std::filesystem::path run = [] {
    const std::filesystem::path scene = output_folder() / "block.toml";
    make_file(scene, block_scene(plate));
    REQUIRE(exit_code_of({"simulate", scene.string(), "-o", (output_folder() / "block").string(), "--quiet"}) == 0);
    return output_folder() / "block";
  }();
  return run;
}

inline const Simulation& block() {
  static const Simulation simulation = set_up(load_scene((block_run() / "scene.toml").string(), {}));
  return simulation;
}

inline State state_of(int frame) {
  return read_state(state_path(block_run(), frame), block().model, block().digest);
}

/// Where the body's vertices are in a frame.
inline FloatPoints positions_of(int frame) {
  TriangleMesh mesh;
  deform(*block().bodies[0].embedding, block().bodies[0].lattice.hexes, state_of(frame).positions, mesh);
  return mesh.positions.cast<float>();
}

/// A frame's points of a PC2 file.
inline FloatPoints read_pc2(const std::filesystem::path& path, int index) {
  const std::string bytes = read_file(path);
  int num_vertices = 0, num_frames = 0;
  std::memcpy(&num_vertices, bytes.data() + 16, 4);
  std::memcpy(&num_frames, bytes.data() + 28, 4);
  REQUIRE(bytes.size() == 32 + std::size_t(num_frames) * num_vertices * 12);
  REQUIRE(index < num_frames);
  FloatPoints points(num_vertices, 3);
  std::memcpy(points.data(), bytes.data() + 32 + std::size_t(index) * num_vertices * 12,
              std::size_t(num_vertices) * 12);
  return points;
}

inline ExportResult export_block(const std::filesystem::path& folder, const ExportOptions& options,
                                 const std::vector<int>& frames = {1, 6, 11}) {
  Progress quiet(stdout, ProgressMode::plain, true);
  const ClipSource source{.state = state_of, .camera = [] { return camera_of_run(block(), block_run()); }};
  return export_clip(block(), source, frames, folder, options, quiet);
}

inline double largest_difference(const FloatPoints& a, const FloatPoints& b) {
  REQUIRE(a.rows() == b.rows());
  return double((a - b).cwiseAbs().maxCoeff());
}

inline ProcessResult export_by_program(const Words& more) {
  return umax_program(Words{"export", block_run().string(), "--quiet"} + more);
}

}  // namespace umax::exported_block
