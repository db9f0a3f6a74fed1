// Many processes on one or many machines share the work in a folder: who is there, and who has claimed what.
//
// Each process has a file in a common folder, which it touches as its heartbeat, and one file more for everything that it
// has claimed. Relied on, of local disks and of NFS alike:
//   - link() and open(O_EXCL) make a file for one caller only. A claim is a hard link to the process's own file, so that
//     it is whole at once and beats with it; where a file system has no hard links it is a copy, touched as well.
//   - A folder that is opened anew lists what was there before (close-to-open): everybody creates first and looks then, so
//     that of two who come at the same time at least one sees the other, and who sees another one gives way.
//   - Times of files are given by one clock, that of the file system: it alone is asked how old a heartbeat is.
// Not relied on: flock() and fcntl() locks, which some servers grant to everybody; equal clocks; process numbers of others.
//
// A claim whose owner is gone is free. It is not removed for that, which two could do at once and remove each other's:
// the next owner makes NAME.2 after NAME.1, and the highest number counts. A process that only seemed gone (it was
// suspended, or cut off from the server) may thus come back and finish what another one has taken up: claims are for
// work that may be done twice with the same result, and who must not asks holds() first.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "core/base/error.h"
#include "tools/system/worker.h"

namespace umax {

/// What is told (io_error) of a folder that was there before.
Error vanished(const std::filesystem::path& folder);

/// This process's presence in a folder, as long as it lives.
class Presence {
 public:
  /// place: the folder that all use, made when it is not there. Throws Error: cannot_create when nothing can be written
  /// there, io_error.
  Presence(const std::filesystem::path& place, const std::string& role);
  ~Presence();
  Presence(const Presence&) = delete;
  Presence& operator=(const Presence&) = delete;

  /// Takes what nobody alive has: true, and it is ours until release(). Throws Error (cannot_create, io_error).
  bool claim(const std::string& name);
  /// Takes it as soon as it is free; false when give_up() says so before.
  bool claim_when_free(const std::string& name, const std::function<bool()>& give_up);
  void release(const std::string& name);
  /// Whether a claim is ours still: nobody has taken it over since, and the folder is there.
  bool holds(const std::string& name) const;

  /// Of this presence alone, for claims that each makes for itself.
  std::string name() const { return own_.filename().string(); }

  /// The others who are alive.
  std::vector<Worker> others() const;
  /// What those have claimed.
  std::set<std::string> claimed_by_others() const;

  /// Removes what processes that are gone have left, of claims that nobody has.
  void sweep();

 private:
  void beat();
  bool claim_as(const std::string& name, int number);
  void withdraw(const std::string& name);  // our file, and nothing else

  std::filesystem::path place_, own_;
  Worker worker_;
  std::map<std::string, std::filesystem::path> claims_;  // by name
  std::set<std::filesystem::path> copies_;               // claims that are no links
  mutable std::mutex mutex_;                             // of the two above, and of is_ending_
  std::condition_variable wake_;
  bool is_ending_ = false;
  std::thread heart_;
};

/// Those who are alive in a place, without being there. Creates nothing.
std::vector<Worker> workers_in(const std::filesystem::path& place);

/// Who of them has a claim; none: it is free.
std::optional<Worker> holder_of(const std::filesystem::path& place, const std::string& name);

}  // namespace umax
