// Pictures to an H.264 clip by ffmpeg, with the sequence checked before and the number of frames after.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace umax {

struct ClipOptions {
  double fps = 60;                // [1/s]
  int width = 0, height = 0;      // [px] that every picture must have; both even
  int constant_rate_factor = 16;  // [-] H.264 quality; more: smaller files, coarser pictures
  bool transparent = false;       // the pictures have alpha: the clip shows them over black
};

/// Throws Error (unavailable, 69) unless ffmpeg and ffprobe are there and ffmpeg has libx264.
void require_clip_encoder();

/// Throws Error (usage, 2) for odd sizes, which H.264 in yuv420p does not have.
void require_even_size(int width, int height);

/// Throws Error (bad_data, io_error) unless the file is a whole PNG of this size.
void check_png(const std::filesystem::path& path, int width, int height);

/// Gives the bytes of a clip's picture, a PNG; index from 0.
using PictureSource = std::function<std::string(std::size_t index)>;

/// Encodes `count` pictures as they come into `clip`, which is put in place only when it is whole and has as many
/// frames. The same pictures give the same bytes. Throws Error.
void encode_clip(const std::filesystem::path& clip, std::size_t count, const PictureSource& picture,
                 const ClipOptions& options);

/// Encodes the PNGs in their order, each checked. Throws Error.
void encode_clip(const std::filesystem::path& clip, const std::vector<std::filesystem::path>& pictures,
                 const ClipOptions& options);

/// Writes the frames of a clip of any kind that ffmpeg reads as 0001.png, 0002.png … into a folder that is there. Throws
/// Error: unavailable (69) without ffmpeg, bad_data for what is no clip.
void decode_clip(const std::filesystem::path& clip, const std::filesystem::path& folder);

}  // namespace umax
