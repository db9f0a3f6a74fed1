// Pictures that many processes draw together in one folder: they agree on the settings, claim frame by frame, and one makes
// the clip. What each draws has the bytes that it would have alone.
#pragma once

#include "tools/run/picture_record.h"
#include "tools/run/render_frames.h"
#include "tools/run/run_folder.h"
#include "tools/system/progress.h"

namespace umax {

struct RenderResult {
  int pictures = 0;  // that are there
  int signal = 0;    // that stopped it early; 0: none
};

/// What those who draw are in the folder for: their Worker::role.
inline constexpr const char* draws = "draw";
inline constexpr const char* draws_for_clip = "draw, clip";

/// Those who draw in a folder.
std::vector<Worker> drawing_in(const std::filesystem::path& run_folder);

/// What to do with pictures of other settings that nobody is drawing any more.
enum class OtherPictures { refuse, replace };

/// Puts down the settings of the pictures that will be drawn. Pictures that no longer fit (others of replaceable settings,
/// of other states, of a clip with other neighbours) are removed first. Returns the signal that stopped it, or 0. Throws
/// Error: cannot_create that names the setting when others draw with another one, or have done so.
int agree_on_pictures(const RunFolder& folder, const PictureRecord& wanted, const RenderDescription& render,
                      OtherPictures others, Progress& progress);

/// Draws the pictures of the list that are not in the folder yet, of which others may draw some. All are there when it
/// returns without signal.
RenderResult draw_pictures(const PictureList& list, const RenderDescription& render, int threads,
                           const RunFolder& folder, Progress& progress);

/// Makes the clip, of all frames or, when these are not all and nobody shares the work, of these; unless others are still
/// drawing frames of it, who then make it, or it is there already. Returns the signal that stopped it, or 0.
int finish_clip(const RunFolder& folder, const std::vector<int>& frames, const Scene& scene, Progress& progress);

/// Makes the clip of these frames, whatever is there. Returns the signal that stopped it, or 0.
int make_clip(const RunFolder& folder, const std::vector<int>& frames, const Scene& scene, Progress& progress);

}  // namespace umax
