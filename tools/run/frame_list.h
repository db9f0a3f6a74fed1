// Which frames of a clip: "1-40,50,60-90x2".
#pragma once

#include <string>
#include <vector>

namespace umax {

/// Frames that `text` names, in increasing order, each once: numbers and ranges "a-b" or "a-bxSTEP", separated by
/// commas. Frames past last_frame are left out (a farm's last chunk may reach past the clip; 0: no upper bound). Throws
/// Error (usage) for anything else, and when no frame is left.
std::vector<int> parse_frame_list(const std::string& text, int last_frame = 0);

/// The list that names these frames, increasing: "1-40,50".
std::string frame_list_text(const std::vector<int>& frames);

/// 1 .. last_frame.
std::vector<int> all_frames(int last_frame);

/// "0001": four digits or more.
std::string frame_name(int frame);

}  // namespace umax
