// How far a run is: a bar on a terminal, plain lines elsewhere, or one JSON object per line.
#pragma once

#include <chrono>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>

namespace umax {

enum class ProgressMode { automatic, plain, json };  // automatic: a bar if the output is a terminal, else plain

/// What one line of progress says.
struct ProgressLine {
  std::string stage;        // "simulate", "render", "encode"
  int frame = 0;            // the frame just finished
  int done = 0, total = 0;  // frames of the stage, those of an earlier call included
  double elapsed = 0;       // [s] of this call
  double rate = 0;          // [frames/s] of this call; 0: not known yet
  std::string detail;       // "12 limits, 8 contacts"
  double remaining() const { return rate > 0 ? (total - done) / rate : -1; }  // [s]; negative: not known
};

/// "0:07", "12:34", "1:02:03"; "?" for negative.
std::string format_duration(double seconds);

/// One line without line end, at most `width` characters: bar, frame, rate, time left.
std::string format_bar(const ProgressLine& line, int width);
std::string format_plain(const ProgressLine& line);
std::string format_json(const ProgressLine& line);

/// Who is told in place of a stream. Each may throw, which ends the work.
struct ProgressListener {
  std::function<void(const ProgressLine&)> frame_done{};
  std::function<void(const std::string&)> note{}, warning{};
};

/// Writes progress to one stream, or tells a listener. Notes and warnings that come in between do not tear the bar.
class Progress {
 public:
  Progress(std::FILE* stream, ProgressMode mode, bool quiet);
  explicit Progress(ProgressListener listener);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Starts a stage of `total` frames, of which `done` were there before.
  void begin(const std::string& stage, int total, int done = 0);
  void frame_done(int frame, const std::string& detail = {});
  /// Frames that other processes have finished: they count, and have no line.
  void frames_done_elsewhere(int count);
  /// Shows on a terminal how far the next frame is, now and then.
  void within_frame(const std::string& detail);
  void end();

  /// A line of information on the stream (nothing with --quiet).
  void note(const std::string& text);
  /// "umax: warning: …" on stderr, whatever the mode.
  void warning(const std::string& text);

  /// Who is told notes and warnings beside, whatever the mode; an empty one: nobody any more.
  void set_witness(ProgressListener witness) { witness_ = std::move(witness); }

 private:
  enum class Style { none, bar, plain, json, listener };
  void show_bar();
  void clear_bar();

  std::FILE* stream_ = nullptr;
  ProgressListener listener_, witness_;
  Style style_;
  bool bar_shown_ = false;
  ProgressLine line_;
  int done_before_ = 0;
  std::chrono::steady_clock::time_point start_, last_shown_;
};

}  // namespace umax
