#include "tools/run/frame_list.h"

#include <algorithm>
#include <charconv>
#include <numeric>
#include <set>
#include <string_view>

#include "core/base/error.h"

namespace umax {
namespace {

constexpr int largest_frame = 10'000'000;

[[noreturn]] void fail(const std::string& what, std::string_view value) {
  throw Error(Fault::usage, {"--frames", what, "\"" + std::string(value) + "\"", "write frames as in 1-40,50,60-90x2"});
}

/// Takes a positive number off the front of `text`; `item` is quoted when there is none.
int take_number(std::string_view& text, std::string_view item) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || number < 1 || number > largest_frame || !(text[0] >= '0' && text[0] <= '9'))
    fail("frames are whole numbers from 1", item);
  text.remove_prefix(std::size_t(end - text.data()));
  return number;
}

bool take_character(std::string_view& text, char character) {
  if (text.empty() || text.front() != character) return false;
  text.remove_prefix(1);
  return true;
}

void add_item(std::string_view item, int last_frame, std::set<int>& frames) {
  std::string_view rest = item;
  const int first = take_number(rest, item);
  const int last = take_character(rest, '-') ? take_number(rest, item) : first;
  const int stride = take_character(rest, 'x') ? take_number(rest, item) : 1;
  if (!rest.empty()) fail("cannot be read", item);
  if (last < first) fail("a range runs upwards", item);
  const int end = last_frame > 0 ? std::min(last, last_frame) : last;
  for (int frame = first; frame <= end; frame += stride) frames.insert(frame);
}

}  // namespace

std::vector<int> parse_frame_list(const std::string& text, int last_frame) {
  std::set<int> frames;
  std::string_view rest = text;
  while (true) {
    const std::size_t comma = rest.find(',');
    const std::string_view item = rest.substr(0, comma);
    if (item.empty()) fail("a part is empty", text);
    add_item(item, last_frame, frames);
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  if (frames.empty())
    throw Error(Fault::usage, {"--frames", "the clip has " + std::to_string(last_frame) + " frames", "\"" + text + "\"",
                               "name frames up to that, or raise clip.frames with --set"});
  return {frames.begin(), frames.end()};
}

std::string frame_list_text(const std::vector<int>& frames) {
  std::string text;
  for (std::size_t first = 0, last = 0; first < frames.size(); first = ++last) {
    for (last = first; last + 1 < frames.size() && frames[last + 1] == frames[last] + 1;) ++last;
    if (!text.empty()) text += ",";
    text += std::to_string(frames[first]);
    if (last > first) text += "-" + std::to_string(frames[last]);
  }
  return text;
}

std::vector<int> all_frames(int last_frame) {
  std::vector<int> frames(std::size_t(std::max(last_frame, 0)));
  std::iota(frames.begin(), frames.end(), 1);
  return frames;
}

std::string frame_name(int frame) {
  const std::string digits = std::to_string(frame);
  return digits.size() < 4 ? std::string(4 - digits.size(), '0') + digits : digits;
}

}  // namespace umax
