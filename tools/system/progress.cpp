#include "tools/system/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "tools/system/seconds_since.h"

namespace umax {
namespace {

int terminal_width(std::FILE* stream) {
  winsize size{};
  return ioctl(fileno(stream), TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

std::string json_text(const std::string& text) {
  std::string quoted = "\"";
  for (const char character : text) {
    if (character == '"' || character == '\\') quoted += '\\';
    if (static_cast<unsigned char>(character) < 0x20)
      quoted += fmt::format("\\u{:04x}", int(character));
    else
      quoted += character;
  }
  return quoted + '"';
}

std::string format_rate(double rate) {
  if (rate <= 0) return "-";
  return rate >= 0.95 ? fmt::format("{:.1f} frames/s", rate) : fmt::format("{:.1f} s/frame", 1 / rate);
}

}  // namespace

std::string format_duration(double seconds) {
  if (!(seconds >= 0) || seconds > 1e8) return "?";
  const long long whole = std::llround(seconds);
  const long long hours = whole / 3600, minutes = whole / 60 % 60;
  if (hours > 0) return fmt::format("{}:{:02}:{:02}", hours, minutes, whole % 60);
  return fmt::format("{}:{:02}", minutes, whole % 60);
}

std::string format_bar(const ProgressLine& line, int width) {
  const std::string left = fmt::format("{:<8} ", line.stage);
  std::string right = fmt::format(" {}/{}  {}  {} left", line.done, line.total, format_rate(line.rate),
                                  format_duration(line.remaining()));
  if (!line.detail.empty() && int(left.size() + right.size() + line.detail.size()) + 14 <= width)
    right += "  " + line.detail;

  const int cells = std::min(40, width - int(left.size() + right.size()) - 2);
  std::string text = left;
  if (cells >= 5) {
    const int filled = line.total > 0 ? cells * std::clamp(line.done, 0, line.total) / line.total : 0;
    text += '[' + std::string(std::size_t(filled), '#') + std::string(std::size_t(cells - filled), '.') + ']';
  }
  text += right;
  return text.substr(0, std::size_t(std::max(width, 0)));
}

std::string format_plain(const ProgressLine& line) {
  std::string text = fmt::format("{} frame {} ({}/{})  {}  {} left", line.stage, line.frame, line.done, line.total,
                                 format_rate(line.rate), format_duration(line.remaining()));
  return line.detail.empty() ? text : text + "  " + line.detail;
}

std::string format_json(const ProgressLine& line) {
  return fmt::format(
      R"({{"event":"frame","stage":{},"frame":{},"done":{},"total":{},"elapsed_s":{:.3f},"rate":{:.4f},"left_s":{},"detail":{}}})",
      json_text(line.stage), line.frame, line.done, line.total, line.elapsed, line.rate,
      line.remaining() < 0 ? "null" : fmt::format("{:.1f}", line.remaining()), json_text(line.detail));
}

Progress::Progress(std::FILE* stream, ProgressMode mode, bool quiet) : stream_(stream), style_(Style::plain) {
  if (mode == ProgressMode::json)
    style_ = Style::json;
  else if (quiet)
    style_ = Style::none;
  else if (mode == ProgressMode::automatic && isatty(fileno(stream)) == 1)
    style_ = Style::bar;
}

Progress::Progress(ProgressListener listener) : listener_(std::move(listener)), style_(Style::listener) {}

Progress::~Progress() {
  clear_bar();
}

void Progress::begin(const std::string& stage, int total, int done) {
  clear_bar();
  line_ = {.stage = stage, .frame = 0, .done = done, .total = total, .elapsed = 0, .rate = 0, .detail = {}};
  done_before_ = done;
  start_ = std::chrono::steady_clock::now();
  last_shown_ = {};
  if (style_ == Style::json) {
    fmt::print(stream_,
               R"({{"event":"begin","stage":{},"total":{},"done":{}}})"
               "\n",
               json_text(stage), total, done);
    std::fflush(stream_);
  }
}

void Progress::frame_done(int frame, const std::string& detail) {
  line_.frame = frame;
  line_.detail = detail;
  ++line_.done;
  line_.elapsed = seconds_since(start_);
  line_.rate = line_.elapsed > 0 ? (line_.done - done_before_) / line_.elapsed : 0;
  if (style_ == Style::none) return;
  if (style_ == Style::listener) {
    if (listener_.frame_done) listener_.frame_done(line_);
    return;
  }
  if (style_ == Style::bar) {
    // more than 20 bars a second only burn time
    if (line_.done < line_.total && seconds_since(last_shown_) < 0.05) return;
    show_bar();
  } else {
    fmt::print(stream_, "{}\n", style_ == Style::json ? format_json(line_) : format_plain(line_));
    std::fflush(stream_);
  }
}

void Progress::frames_done_elsewhere(int count) {
  line_.done += count;
  if (style_ == Style::bar && count > 0) show_bar();
}

void Progress::within_frame(const std::string& detail) {
  if (style_ != Style::bar || seconds_since(last_shown_) < 0.5) return;
  line_.detail = detail;
  show_bar();
}

void Progress::end() {
  if (style_ == Style::listener) return;
  if (bar_shown_) std::fputs("\n", stream_);
  bar_shown_ = false;
  if (style_ == Style::json)
    fmt::print(stream_,
               R"({{"event":"end","stage":{},"done":{},"elapsed_s":{:.3f}}})"
               "\n",
               json_text(line_.stage), line_.done, seconds_since(start_));
  std::fflush(stream_);
}

void Progress::show_bar() {
  last_shown_ = std::chrono::steady_clock::now();
  fmt::print(stream_, "\r\x1b[2K{}", format_bar(line_, terminal_width(stream_) - 1));
  bar_shown_ = true;
  std::fflush(stream_);
}

void Progress::clear_bar() {
  if (!bar_shown_) return;
  std::fputs("\r\x1b[2K", stream_);
  std::fflush(stream_);
  bar_shown_ = false;
}

void Progress::note(const std::string& text) {
  if (witness_.note) witness_.note(text);
  if (style_ == Style::none) return;
  if (style_ == Style::listener) {
    if (listener_.note) listener_.note(text);
    return;
  }
  clear_bar();
  if (style_ == Style::json)
    fmt::print(stream_,
               R"({{"event":"note","text":{}}})"
               "\n",
               json_text(text));
  else
    fmt::print(stream_, "{}\n", text);
  std::fflush(stream_);
}

void Progress::warning(const std::string& text) {
  if (witness_.warning) witness_.warning(text);
  if (style_ == Style::listener) {
    if (listener_.warning) listener_.warning(text);
    return;
  }
  clear_bar();
  fmt::print(stderr, "umax: warning: {}\n", text);
}

}  // namespace umax
