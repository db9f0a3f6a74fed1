#include "tools/system/presence.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <random>

#include "core/base/error.h"
#include "core/files/disk_error.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* prefix = "worker-";

[[noreturn]] void fail(const fs::path& path, int reason) {
  if (reason == ENOENT) throw vanished(path.parent_path());
  throw Error(Fault::cannot_create, {.where = path.string(),
                                     .what = std::string("cannot be written (") + std::strerror(reason) + ")",
                                     .remedy = disk_remedy(reason)});
}

double seconds(const timespec& time) {
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

/// What time it is for the file system: times of its files are to be compared with nothing else.
double file_system_time(const fs::path& place) {
  struct stat status{};
  ::utimensat(AT_FDCWD, place.c_str(), nullptr, 0);
  return ::stat(place.c_str(), &status) == 0 ? seconds(status.st_mtim) : 0;
}

/// A file of the place: somebody, or a claim of somebody's.
struct Found {
  fs::path path;
  std::string name;  // of the claim; empty: it is a worker's own file
  int number = 0;    // of the claim
  std::optional<Worker> worker;
  double beat = 0;  // [s] by the file system's clock
  ino_t inode = 0;
};

/// Reads a file with its time; opened, so that a file server is asked and not what we remember of it.
bool read(Found& found) {
  const int file = ::open(found.path.c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return false;
  std::string text(1024, '\0');
  const ssize_t count = ::read(file, text.data(), text.size());
  struct stat status{};
  const bool is_known = ::fstat(file, &status) == 0;
  ::close(file);
  if (count < 0 || !is_known) return false;
  found.worker = parse_worker(text.substr(0, std::size_t(count)));
  found.beat = seconds(status.st_mtim);
  found.inode = status.st_ino;
  return true;
}

/// What is in the place; what vanishes meanwhile is left out.
std::vector<Found> look(const fs::path& place) {
  std::vector<Found> all;
  std::error_code error;
  for (fs::directory_iterator entry(place, error), end; !error && entry != end; entry.increment(error)) {
    Found found;
    found.path = entry->path();
    const std::string name = found.path.filename().string();
    const std::size_t dot = name.rfind('.');
    if (!name.starts_with(prefix)) {
      if (dot == std::string::npos) continue;
      found.name = name.substr(0, dot);
      found.number = std::atoi(name.c_str() + dot + 1);
    }
    if (read(found)) all.push_back(std::move(found));
  }
  return all;
}

/// Who has not said yet who it is has been here for a moment only, or is gone.
bool is_living(const Found& found, double now) {
  return is_alive(found.worker.value_or(Worker{}), now - found.beat);
}

int highest_number(const std::vector<Found>& all, const std::string& name) {
  int highest = 0;
  for (const Found& found : all)
    if (found.name == name) highest = std::max(highest, found.number);
  return highest;
}

/// Whether somebody alive, other than the one with this file, has the claim.
bool is_taken(const std::vector<Found>& all, const std::string& name, const fs::path& own, double now) {
  return std::any_of(all.begin(), all.end(), [&](const Found& found) {
    return found.name == name && found.path != own && is_living(found, now);
  });
}

fs::path claim_path(const fs::path& place, const std::string& name, int number) {
  return place / fmt::format("{}.{}", name, number);
}

/// Writes an open file and closes it; returns errno, 0 for success.
int write_and_close(int file, const std::string& text, const std::function<int()>& when_written) {
  const ssize_t written = ::write(file, text.data(), text.size());
  int reason = written < 0 ? errno : written < ssize_t(text.size()) ? ENOSPC : when_written();
  if (::close(file) != 0 && reason == 0) reason = errno;
  return reason;
}

/// Makes a file for us alone, which has its name when it is written and not before where the file system can do that;
/// elsewhere a process that is killed in between leaves one that says nothing. Returns errno, 0 for success.
int write_new(const fs::path& path, const std::string& text) {
  const int nameless = ::open(path.parent_path().c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0666);
  if (nameless >= 0) {
    const std::string itself = fmt::format("/proc/self/fd/{}", nameless);
    const int reason = write_and_close(nameless, text, [&] {
      return ::linkat(AT_FDCWD, itself.c_str(), AT_FDCWD, path.c_str(), AT_SYMLINK_FOLLOW) == 0 ? 0 : errno;
    });
    if (reason == 0 || reason == EEXIST || reason == ENOSPC || reason == EDQUOT) return reason;
  }
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file < 0) return errno;
  const int reason = write_and_close(file, text, [] { return 0; });
  if (reason != 0) ::unlink(path.c_str());
  return reason;
}

/// link(); an answer that was lost on the way from a server is looked for. Returns errno, 0 for success.
int link_to(const fs::path& own, const fs::path& path) {
  if (::link(own.c_str(), path.c_str()) == 0) return 0;
  const int reason = errno;
  struct stat a{}, b{};
  const bool is_ours = ::stat(own.c_str(), &a) == 0 && ::stat(path.c_str(), &b) == 0 && a.st_ino == b.st_ino;
  return is_ours ? 0 : reason;
}

bool has_no_links(int reason) {
  return reason == EPERM || reason == EOPNOTSUPP || reason == ENOSYS || reason == EMLINK;
}

/// A name that no other process on any machine has.
std::string own_name(const Worker& worker) {
  static std::atomic<int> count = 0;
  std::random_device random;
  return fmt::format("{}{}-{:08x}-{}", prefix, worker.process, random(), ++count);
}

/// The place may go between its making and our file, when another one leaves: once more then.
void write_first(const fs::path& path, const std::string& text) {
  for (int attempt = 1;; ++attempt) {
    const int made = ::mkdir(path.parent_path().c_str(), 0777) == 0 ? 0 : errno;
    const int reason = write_new(path, text);
    if (reason == 0) return;
    if (reason == ENOENT && attempt < 20) continue;
    ::rmdir(path.parent_path().c_str());  // which fails where others are
    fail(path, made != 0 && made != EEXIST ? made : reason);
  }
}

}  // namespace

Error vanished(const fs::path& folder) {
  return Error(
      Fault::io_error,
      {.where = folder.string(), .what = "has vanished", .remedy = "look for its disk, then go on with --resume"});
}

Presence::Presence(const fs::path& place, const std::string& role) : place_(place), worker_(this_worker(role)) {
  own_ = place_ / own_name(worker_);
  write_first(own_, worker_text(worker_));
  heart_ = std::thread([this] { beat(); });
}

Presence::~Presence() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  wake_.notify_all();
  heart_.join();
  while (!claims_.empty()) release(std::string(claims_.begin()->first));
  ::unlink(own_.c_str());
  ::rmdir(place_.c_str());
}

void Presence::beat() {
  const auto interval = std::chrono::duration<double>(std::min(10.0, worker_.lease / 6));
  std::unique_lock lock(mutex_);
  while (!wake_.wait_for(lock, interval, [this] { return is_ending_; })) {
    ::utimensat(AT_FDCWD, own_.c_str(), nullptr, 0);
    for (const fs::path& copy : copies_) ::utimensat(AT_FDCWD, copy.c_str(), nullptr, 0);
  }
}

bool Presence::claim_as(const std::string& name, int number) {
  const fs::path path = claim_path(place_, name, number);
  int reason = link_to(own_, path);
  const bool is_copy = has_no_links(reason);
  if (is_copy) reason = write_new(path, worker_text(worker_));
  if (reason == EEXIST) return false;
  if (reason != 0) fail(path, reason);
  const std::lock_guard lock(mutex_);
  claims_[name] = path;
  if (is_copy) copies_.insert(path);
  return true;
}

bool Presence::claim(const std::string& name) {
  const std::vector<Found> before = look(place_);
  if (is_taken(before, name, {}, file_system_time(place_))) return false;
  if (!claim_as(name, highest_number(before, name) + 1)) return false;
  // who has come at the same moment by another number is seen now, or sees us
  const std::vector<Found> after = look(place_);
  const fs::path own = claims_.at(name);
  const bool is_there = std::any_of(after.begin(), after.end(), [&](const Found& found) { return found.path == own; });
  if (is_there && !is_taken(after, name, own, file_system_time(place_))) return true;
  withdraw(name);
  return false;
}

bool Presence::claim_when_free(const std::string& name, const std::function<bool()>& give_up) {
  for (auto pause = std::chrono::milliseconds(5); !claim(name);
       pause = std::min(2 * pause, std::chrono::milliseconds(500))) {
    if (give_up()) return false;
    std::this_thread::sleep_for(pause);
  }
  return true;
}

// Ours goes last: as long as it is there nobody else has the claim, and what the gone left is nobody's. Who has just
// come and is about to see us keeps his file: it may be the next claim.
void Presence::release(const std::string& name) {
  if (claims_.count(name) == 0) return;
  const double now = file_system_time(place_);
  for (const Found& left : look(place_))
    if (left.name == name && left.path != claims_.at(name) && !is_living(left, now)) ::unlink(left.path.c_str());
  withdraw(name);
}

void Presence::withdraw(const std::string& name) {
  const std::lock_guard lock(mutex_);
  const auto found = claims_.find(name);
  if (found == claims_.end()) return;
  ::unlink(found->second.c_str());
  copies_.erase(found->second);
  claims_.erase(found);
}

bool Presence::holds(const std::string& name) const {
  const auto claim = claims_.find(name);
  std::error_code error;
  return claim != claims_.end() && fs::exists(claim->second, error) &&
         !is_taken(look(place_), name, claim->second, file_system_time(place_));
}

std::vector<Worker> Presence::others() const {
  std::vector<Worker> others;
  const double now = file_system_time(place_);
  for (const Found& found : look(place_))
    if (found.name.empty() && found.path != own_ && is_living(found, now))
      others.push_back(found.worker.value_or(Worker{}));
  return others;
}

std::set<std::string> Presence::claimed_by_others() const {
  std::set<std::string> names;
  const double now = file_system_time(place_);
  for (const Found& found : look(place_)) {
    const auto own = claims_.find(found.name);
    const bool is_own = own != claims_.end() && own->second == found.path;
    if (!found.name.empty() && !is_own && is_living(found, now)) names.insert(found.name);
  }
  return names;
}

void Presence::sweep() {
  const double now = file_system_time(place_);
  for (const Found& found : look(place_)) {
    if (found.path == own_ || is_living(found, now)) continue;
    if (found.name.empty()) {
      ::unlink(found.path.c_str());
      continue;
    }
    if (claims_.count(found.name) == 0 && claim(found.name)) release(found.name);
  }
}

std::vector<Worker> workers_in(const fs::path& place) {
  std::vector<Worker> workers;
  const std::vector<Found> all = look(place);
  const double now = all.empty() ? 0 : file_system_time(place);
  for (const Found& found : all)
    if (found.name.empty() && is_living(found, now)) workers.push_back(found.worker.value_or(Worker{}));
  return workers;
}

std::optional<Worker> holder_of(const fs::path& place, const std::string& name) {
  const std::vector<Found> all = look(place);
  const double now = all.empty() ? 0 : file_system_time(place);
  for (const Found& found : all)
    if (found.name == name && is_living(found, now)) return found.worker.value_or(Worker{});
  return std::nullopt;
}

}  // namespace umax
