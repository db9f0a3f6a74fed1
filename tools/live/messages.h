// What a browser may say to a live session, and what it is told in words. No message carries a path.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "tools/live/session.h"

namespace umax {

enum class Wish {
  play,
  pause,
  step,
  restart,
  slower,
  set,
  grab,
  move,
  release,
  show,
  rewind,
  save,
  render,
  lines,
  steer,
  seen,
  invite,
  place,
  cells
};

struct Message {
  Wish wish = Wish::pause;
  int key = 0, body = 0, vertex = 0, obstacle = 0;
  int frame = 0;            // show, rewind; seen: the number of the picture
  int cells = 0;            // cells
  double value = 0;         // set, slower
  Vector3d place{0, 0, 0};  // grab, move
};

inline constexpr std::size_t longest_message = 512;  // [bytes]

/// The message in `text`; none where it is anything else, in which case the connection is to be closed.
std::optional<Message> decode_message(std::string_view text);

/// Whether a wish changes what all see, so that only who steers may have it.
bool needs_steering(Wish wish);

/// The scene: bodies, obstacles, keys, values. JSON.
std::string hello_text(const Session& session, int keep);

/// What keys have and where they are heading. JSON.
std::string values_text(const Session& session);

/// A line for the reader. kind: "note", "error", "lines" or "invite". JSON.
std::string told_text(const std::string& kind, const std::string& text);

/// Who steers, and how many watch. JSON.
std::string role_text(bool steers, int watchers);

}  // namespace umax
