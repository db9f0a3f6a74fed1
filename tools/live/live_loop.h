// The thread that a live session runs on: takes wishes between steps, keeps the clock, shows what comes of it.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "tools/live/messages.h"
#include "tools/live/pace.h"
#include "tools/live/recording.h"
#include "tools/live/wire.h"

namespace umax {

/// Where the loop's news go; called on its thread.
struct LiveNews {
  std::function<void(std::shared_ptr<const std::string> frame)> picture;  // bytes of encode_frame()
  std::function<void(std::string text)> told;                             // JSON, for all
  std::function<void()> rebuilt;               // the session has other meshes: pages begin anew
  std::function<void(std::string line)> said;  // for the terminal
};

/// Owns the thread.
class LiveLoop {
 public:
  /// Session and recording belong to the loop until it is destroyed.
  LiveLoop(Session& session, Recording& recording, LiveNews news, double slower = 1);
  ~LiveLoop();
  LiveLoop(const LiveLoop&) = delete;
  LiveLoop& operator=(const LiveLoop&) = delete;

  /// What is to be done before the next step.
  void post(const Message& message);

  /// Shows the picture and the values again: somebody has come.
  void show_again();

  /// What ended the loop by itself; null: nothing has.
  std::exception_ptr failure() const;

 private:
  void run();
  void work();
  bool take_wishes();
  void obey(const Message& message);
  void change_clock(const Message& message);
  void change_session(const Message& message);
  void show_frame(int frame);
  void go_on_from(int frame);
  bool change_cage(int body, int cells);
  void save(bool with_run);
  void one_step();
  void keep_state();
  void show();
  void tell_values();

  Session& session_;
  Recording& recording_;
  LiveNews news_;
  Pace pace_;
  bool plays_ = false;
  int steps_wanted_ = 0;       // while it does not play
  std::optional<State> past_;  // that is shown in place of the session's
  std::uint32_t pictures_ = 0;
  std::vector<double> told_values_;
  std::chrono::steady_clock::time_point due_{}, shown_{};

  mutable std::mutex mutex_;
  std::condition_variable news_for_loop_;
  std::deque<Message> wishes_;
  bool again_ = false, ends_ = false;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace umax
