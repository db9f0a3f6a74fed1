#include "embedding/mesh_files/import_process.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <thread>

#include "core/base/error.h"

namespace umax {
namespace {

using Clock = std::chrono::steady_clock;

/// A file descriptor that closes itself.
struct Descriptor {
  int number = -1;
  explicit Descriptor(int number_) : number(number_) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  void close() {
    if (number >= 0) ::close(number);
    number = -1;
  }
};

[[noreturn]] void fail(Fault fault, const std::string& program, const char* what, int error) {
  throw Error(fault, {program, std::string(what) + " (" + std::strerror(error) + ")", "", "install it beside umax"});
}

/// Ours, and that its heap is of large pages where the system has them: half of what a million triangles cost it are
/// small ones that are touched for the first time. The C library reads this, and only as a program starts.
std::vector<std::string> environment_of_helper() {
  constexpr std::string_view tuning = "GLIBC_TUNABLES=";
  std::vector<std::string> values;
  bool tuned = false;
  for (char** value = environ; *value; ++value) {
    values.emplace_back(*value);
    tuned |= values.back().starts_with(tuning);
  }
  if (!tuned) values.push_back(std::string(tuning) + "glibc.malloc.hugetlb=1");
  return values;
}

std::vector<char*> pointers_to(const std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (const std::string& text : texts) pointers.push_back(const_cast<char*>(text.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

/// Its messages go to a pipe that nobody reads for its words: its end tells when the program is gone.
pid_t start(const std::vector<std::string>& command, int output, int messages) {
  const std::vector<std::string> environment = environment_of_helper();
  const std::vector<char*> arguments = pointers_to(command), variables = pointers_to(environment);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, output, 1);
  posix_spawn_file_actions_adddup2(&files, messages, 2);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t all;
  sigfillset(&all);
  posix_spawnattr_setsigdefault(&attributes, &all);
  // a group of its own: Ctrl-C on the terminal is ours to handle
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  pid_t child = -1;
  const int error = ::posix_spawn(&child, arguments[0], &files, &attributes, arguments.data(), variables.data());
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) fail(Fault::unavailable, command.front(), "cannot be started", error);
  return child;
}

/// Whether the other end of the pipe was closed before the deadline.
bool wait_for_close(int pipe, Clock::time_point deadline) {
  std::array<char, 4096> words;
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return false;
    pollfd waiting{.fd = pipe, .events = POLLIN, .revents = 0};
    const int ready = ::poll(&waiting, 1, int(std::min<long long>(left, 1000000)));
    if (ready <= 0) continue;
    const ssize_t count = ::read(pipe, words.data(), words.size());
    if (count == 0 || (count < 0 && errno != EINTR)) return true;
  }
}

ImportEnd end_of(int status) {
  if (!WIFSIGNALED(status)) return {ImportEnd::Kind::exited, WEXITSTATUS(status)};
  if (WTERMSIG(status) == SIGXCPU) return {ImportEnd::Kind::timed_out, 0};
  return {ImportEnd::Kind::signalled, WTERMSIG(status)};
}

void kill_and_wait(pid_t child) {
  ::kill(-child, SIGKILL);
  while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
}

}  // namespace

ImportProcess::ImportProcess(const std::vector<std::string>& command, long long seconds, long long likely_bytes)
    : deadline_(Clock::now() + std::chrono::seconds(seconds)) {
  const Descriptor output(::memfd_create("umax-import", MFD_CLOEXEC));
  int ends[2];
  if (output.number < 0 || ::pipe2(ends, O_CLOEXEC) != 0)
    fail(Fault::io_error, command.front(), "cannot be given files to write to", errno);
  const Descriptor words(ends[0]);
  Descriptor messages(ends[1]);
  child_ = start(command, output.number, messages.number);
  messages.close();
  // pages that it need not wait for when it writes; where there are none it gets them one by one, or not
  if (likely_bytes > 0) ::fallocate(output.number, FALLOC_FL_KEEP_SIZE, 0, likely_bytes);
  if (!wait_for_close(words.number, deadline_)) return;

  struct stat status{};
  if (::fstat(output.number, &status) != 0 || status.st_size == 0) return;
  void* bytes = ::mmap(nullptr, std::size_t(status.st_size), PROT_READ, MAP_PRIVATE | MAP_POPULATE, output.number, 0);
  if (bytes != MAP_FAILED) output_ = {static_cast<const char*>(bytes), std::size_t(status.st_size)};
}

ImportProcess::~ImportProcess() {
  if (child_ >= 0) kill_and_wait(child_);
  if (!output_.empty()) ::munmap(const_cast<char*>(output_.data()), output_.size());
}

ImportEnd ImportProcess::end() {
  int status = 0;
  pid_t ended = 0;
  while ((ended = ::waitpid(child_, &status, WNOHANG)) == 0 && Clock::now() < deadline_)
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  if (ended == 0) kill_and_wait(child_);
  child_ = -1;
  if (ended == 0) return {ImportEnd::Kind::timed_out, 0};
  return ended < 0 ? ImportEnd{} : end_of(status);  // less than 0: a host that does not want to hear of its children
}

}  // namespace umax
