// What pictures and their clip will take, told before the first is drawn: memory and time, from counts alone.
#pragma once

#include <string>
#include <vector>

#include "tools/setup/simulation_setup.h"

namespace umax {

struct PictureJob {
  double pixels = 0;     // of a picture
  double samples = 0;    // paths a pixel of the path tracer, at most; share of the rasteriser's shadow maps
  double triangles = 0;  // of all that is drawn
  double states = 1;     // of each at a time: more where the shutter is open
  int pictures = 0;      // to draw
  int shots = 0;         // these, and neighbours that the noise filter looks at and that others draw
  int window = 1;        // frames that the noise filter looks at
  int clip_frames = 0;   // to encode; 0: no clip
  int threads = 1;
  bool is_rasterised = false, is_filtered = false;
};

struct PictureEstimate {
  double memory = 0;           // [bytes] at the peak, ffmpeg apart
  double picture_seconds = 0;  // [s] each
  double render_seconds = 0;   // [s] all of them
  double encode_seconds = 0;   // [s]
  double encode_memory = 0;    // [bytes] of ffmpeg
};

/// drawn: the frames that are not there yet; clip_frames: how many the clip will have, 0 for none.
PictureJob picture_job(const Simulation& simulation, const std::vector<int>& drawn, int clip_frames, int threads);

PictureEstimate estimate(const PictureJob& job);

/// "pictures: about 1.2 GiB of memory and 0:12:00 (150 of about 4.8 s by embree on 2 threads), and 0:20 and 300 MiB for the
/// clip"; empty where that is little (up to 1 GiB and 10 minutes) and need not be said.
std::string announce(const PictureJob& job);

}  // namespace umax
