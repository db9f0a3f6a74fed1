#include "tools/live/live_loop.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "tools/system/seconds_since.h"
#include "tools/system/threads.h"

namespace umax {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t most_wishes = 1000;   // that wait; more are dropped, the oldest first
constexpr double shortest_show = 0.9 / 90;  // [s] between two pictures while it plays

/// Thrown in the middle of a step.
struct Ended {};

Clock::duration seconds(double s) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

}  // namespace

LiveLoop::LiveLoop(Session& session, Recording& recording, LiveNews news, double slower)
    : session_(session), recording_(recording), news_(std::move(news)) {
  pace_.time_step = session.simulation.options.time_step;
  pace_.slower = slower;
  session.most_rows = std::size_t(recording.most_frames()) * std::size_t(session.substeps());
  session_.stepping.options.on_iteration = [this](const IterationReport&) {
    const std::lock_guard lock(mutex_);
    if (ends_) throw Ended{};
  };
  thread_ = std::thread([this] { run(); });
}

LiveLoop::~LiveLoop() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  news_for_loop_.notify_all();
  thread_.join();
  session_.stepping.options.on_iteration = {};
}

void LiveLoop::post(const Message& message) {
  {
    const std::lock_guard lock(mutex_);
    if (wishes_.size() >= most_wishes) wishes_.pop_front();
    wishes_.push_back(message);
  }
  news_for_loop_.notify_all();
}

void LiveLoop::show_again() {
  {
    const std::lock_guard lock(mutex_);
    again_ = true;
  }
  news_for_loop_.notify_all();
}

std::exception_ptr LiveLoop::failure() const {
  const std::lock_guard lock(mutex_);
  return failure_;
}

void LiveLoop::run() {
  use_standard_floating_point();
  try {
    keep_state();
    show();
    work();
  } catch (const Ended&) {  // NOLINT(bugprone-empty-catch): as it was told
  } catch (...) {
    const std::lock_guard lock(mutex_);
    failure_ = std::current_exception();
  }
}

void LiveLoop::work() {
  while (take_wishes()) {
    const bool steps = plays_ || steps_wanted_ > 0;
    if (!steps) continue;
    if (plays_ && Clock::now() < due_) continue;
    one_step();
  }
}

/// Waits until there is something to do, and does what is wished. False: the end.
bool LiveLoop::take_wishes() {
  std::deque<Message> wishes;
  bool again = false;
  {
    std::unique_lock lock(mutex_);
    const auto something = [&] { return ends_ || again_ || !wishes_.empty(); };
    if (plays_)
      news_for_loop_.wait_until(lock, due_, something);
    else if (steps_wanted_ == 0)
      news_for_loop_.wait(lock, something);
    if (ends_) return false;
    std::swap(wishes, wishes_);
    again = std::exchange(again_, false);
  }
  for (const Message& message : wishes) obey(message);
  if (again) told_values_.clear();
  if (again || (!wishes.empty() && !plays_ && steps_wanted_ == 0)) show();
  return true;
}

void LiveLoop::obey(const Message& message) {
  change_clock(message);
  change_session(message);
  if (message.wish == Wish::save || message.wish == Wish::render) save(message.wish == Wish::render);
  if (message.wish == Wish::lines) news_.told(told_text("lines", scene_lines(session_)));
}

void LiveLoop::change_clock(const Message& message) {
  switch (message.wish) {
    case Wish::play:
      past_.reset();
      plays_ = true;
      due_ = Clock::now();
      break;
    case Wish::pause:
      plays_ = false;
      steps_wanted_ = 0;
      break;
    case Wish::step:
      past_.reset();
      plays_ = false;
      steps_wanted_ = 1;
      break;
    case Wish::slower:
      pace_.slower = message.value;
      break;
    case Wish::show:
      show_frame(message.frame);
      break;
    default:
      break;
  }
}

void LiveLoop::change_session(const Message& message) {
  bool is_done = true;
  switch (message.wish) {
    case Wish::set:
      is_done = set_key(session_, std::size_t(message.key), message.value);
      break;
    case Wish::grab:
      is_done = grab(session_, {message.body, message.vertex, message.place});
      break;
    case Wish::move:
      if (session_.grab) is_done = grab(session_, {session_.grab->body, session_.grab->vertex, message.place});
      break;
    case Wish::release:
      release(session_);
      break;
    case Wish::place:
      is_done = place_handle(session_, std::size_t(message.obstacle), message.place);
      break;
    case Wish::restart:
      past_.reset();
      release(session_);
      restart(session_);
      keep_state();
      break;
    case Wish::rewind:
      go_on_from(message.frame);
      break;
    case Wish::cells:
      is_done = change_cage(message.body, message.cells);
      break;
    default:
      break;
  }
  if (!is_done)
    news_.told(told_text("error", "that value, body, vertex, obstacle or cage is not there, or cannot be changed"));
}

void LiveLoop::show_frame(int frame) {
  plays_ = false;
  steps_wanted_ = 0;
  past_.reset();
  if (frame >= recording_.last_frame()) return;
  past_ = recording_.state(std::max(frame, recording_.first_frame()));
}

void LiveLoop::go_on_from(int frame) {
  const std::optional<State> state = recording_.state(frame);
  if (!state) {
    news_.told(told_text("error", fmt::format("frame {} is not kept any more: raise --keep", frame)));
    return;
  }
  past_.reset();
  plays_ = false;
  release(session_);
  rewind(session_, *state);
  recording_.cut(frame);
}

bool LiveLoop::change_cage(int body, int cells) {
  if (!can_set_cells(session_, body)) return false;
  const std::string& name = session_.original.bodies[std::size_t(body)].name;
  try {
    news_.told(told_text("note", fmt::format("makes a cage of about {} hexes for {}", cells, name)));
    if (!set_cells(session_, body, cells)) return false;
  } catch (const Error& error) {
    news_.told(told_text("error", error.what()));
    return true;
  }
  past_.reset();
  told_values_.clear();
  due_ = Clock::now();
  keep_state();
  news_.rebuilt();
  const std::string text = fmt::format("{} has a cage of {} hexes now, and everything starts again", name,
                                       session_.simulation.model.bodies[std::size_t(body)].num_hexes);
  news_.said(text);
  news_.told(told_text("note", text));
  return true;
}

void LiveLoop::save(bool with_run) {
  try {
    std::string text;
    if (with_run) {
      const SessionRun saved = save_run(session_, recording_);
      text = saved.run.empty() ? fmt::format("saved; its first states are not kept any more (--keep): umax run {}",
                                             saved.scene.string())
                               : fmt::format("{} frames: umax render {}", saved.frames, saved.run.string());
    } else {
      text = fmt::format("saved: umax simulate {}", save_session(session_, recording_).string());
    }
    news_.said(text);
    news_.told(told_text("note", text));
  } catch (const Error& error) {
    news_.told(told_text("error", error.what()));
  }
}

void LiveLoop::one_step() {
  const auto begin = Clock::now();
  step(session_);
  if (session_.at_frame()) keep_state();
  const bool is_late = seconds_since(shown_) >= shortest_show;
  if (session_.at_frame() && (is_late || !plays_)) show();
  if (steps_wanted_ > 0) --steps_wanted_;
  if (!plays_) {
    show();
    return;
  }
  add_step(pace_, seconds_since(begin));
  due_ = std::max(due_ + seconds(pace_.period), Clock::now() - seconds(pace_.period));
}

void LiveLoop::keep_state() {
  recording_.keep(session_.frame(), session_.state, session_.simulation.digest);
}

void LiveLoop::show() {
  const FrameInfo info{.number = ++pictures_,
                       .first_kept = std::uint32_t(recording_.first_frame()),
                       .last_kept = std::uint32_t(recording_.last_frame()),
                       .plays = plays_,
                       .is_past = past_.has_value(),
                       .is_behind = plays_ && pace_.is_behind(),
                       .rate = pace_.rate(),
                       .step_ms = 1000 * pace_.cost};
  const StepReport report =
      past_ ? measure(session_.simulation.model, session_.simulation.options, *past_) : session_.last;
  news_.picture(
      std::make_shared<const std::string>(encode_frame(session_, past_ ? *past_ : session_.state, report, info)));
  shown_ = Clock::now();
  tell_values();
}

void LiveLoop::tell_values() {
  std::vector<double> values = session_.goals;
  for (std::size_t i = 0; i < session_.keys.size(); ++i) values.push_back(value_now(session_, i));
  if (values == told_values_) return;
  told_values_ = std::move(values);
  news_.told(values_text(session_));
}

}  // namespace umax
