// The render loop: pictures of stored states, and the clip that they make.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/pictures/painter.h"
#include "tools/pictures/shot.h"
#include "tools/run/run_folder.h"
#include "tools/system/progress.h"

namespace umax {

struct RenderResult {
  int pictures = 0;  // that are there
  int signal = 0;    // that stopped it early; 0: none
};

/// Renders the pictures that are not in the folder yet.
RenderResult render_pictures(const PictureList& list, const RenderDescription& render, int threads,
                             const RunFolder& folder, Progress& progress);

/// The pictures of a run: states are read from `run`, the camera frames all of them unless the scene has one.
struct RunPictures {
  PictureList list;
  std::string digest;  // of all that decides the pictures
};
RunPictures pictures_of_run(const Simulation& simulation, const std::filesystem::path& run,
                            const std::vector<int>& frames);

/// The camera of those pictures.
Camera camera_of_run(const Simulation& simulation, const std::filesystem::path& run);

/// A circle around one state in clip.frames pictures, of which `frames` are wanted.
RunPictures turntable_of(const Simulation& simulation, const State& state, const std::vector<int>& frames);

/// Encodes the pictures of these frames.
void encode_pictures(const RunFolder& folder, const std::vector<int>& frames, const Scene& scene, Progress& progress);

}  // namespace umax
