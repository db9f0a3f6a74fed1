// The pictures of a run or a turntable: what is drawn as which frame, and the clip that they make.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/pictures/painter.h"
#include "tools/pictures/shot.h"
#include "tools/run/picture_record.h"
#include "tools/run/run_folder.h"
#include "tools/system/progress.h"

namespace umax {

/// The pictures of a run: states are read from `run`, the camera frames all of them unless the scene has one.
struct RunPictures {
  PictureList list;
  PictureRecord record;                 // what decides the pictures
  std::vector<std::string> notes = {};  // for the user
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
