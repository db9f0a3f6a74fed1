#include "tools/system/subprocess.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "core/base/error.h"
#include "core/files/disk_error.h"

namespace umax {
namespace {

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int number = -1) : number_(number) {}
  ~Descriptor() { close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return number_; }
  void reset(int number) {
    close();
    number_ = number;
  }
  void close() {
    if (number_ >= 0) ::close(number_);
    number_ = -1;
  }
  /// Gives it up to the caller.
  int release() {
    const int number = number_;
    number_ = -1;
    return number;
  }

 private:
  int number_;
};

/// While it lives, writing to a closed pipe is an error code instead of our end.
class IgnoreBrokenPipe {
 public:
  IgnoreBrokenPipe() : before_(std::signal(SIGPIPE, SIG_IGN)) {}
  ~IgnoreBrokenPipe() { std::signal(SIGPIPE, before_); }
  IgnoreBrokenPipe(const IgnoreBrokenPipe&) = delete;
  IgnoreBrokenPipe& operator=(const IgnoreBrokenPipe&) = delete;

 private:
  void (*before_)(int);
};

bool write_whole(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes.remove_prefix(std::size_t(written));
  }
  return true;
}

std::string read_from_start(int file) {
  std::string text;
  std::array<char, 4096> block;
  ::lseek(file, 0, SEEK_SET);
  for (ssize_t count; (count = ::read(file, block.data(), block.size())) > 0;)
    text.append(block.data(), std::size_t(count));
  return text;
}

/// Starts the command with the given standard streams; the child gets default signal handling.
pid_t start(const std::vector<std::string>& command, int input, int output, int messages) {
  std::vector<char*> arguments;
  for (const std::string& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);

  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_adddup2(&files, input, 0);
  posix_spawn_file_actions_adddup2(&files, output, 1);
  posix_spawn_file_actions_adddup2(&files, messages, 2);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults);
  for (const int number : {SIGPIPE, SIGXFSZ, SIGTERM, SIGINT, SIGHUP}) sigaddset(&defaults, number);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  // a group of its own: Ctrl-C on the terminal is ours to handle
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);

  pid_t child = -1;
  const int error = posix_spawnp(&child, command.front().c_str(), &files, &attributes, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&files);
  posix_spawnattr_destroy(&attributes);
  if (error != 0)
    throw Error(Fault::unavailable,
                {command.front(), std::string("cannot be started (") + std::strerror(error) + ")", "", "install it"});
  return child;
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace

std::optional<std::filesystem::path> find_program(const std::string& name) {
  const char* variable = std::getenv("PATH");
  std::string_view folders = variable != nullptr ? variable : "/usr/local/bin:/usr/bin:/bin";
  while (!folders.empty()) {
    const std::size_t end = std::min(folders.find(':'), folders.size());
    auto candidate = std::filesystem::path(folders.substr(0, end)) / name;
    if (::access(candidate.c_str(), X_OK) == 0 && std::filesystem::is_regular_file(candidate)) return candidate;
    folders.remove_prefix(std::min(end + 1, folders.size()));
  }
  return std::nullopt;
}

ProcessResult run_process(const std::vector<std::string>& command, const InputSource& input) {
  const IgnoreBrokenPipe ignore;
  // what it says goes into memory files, so that no pipe can fill up and block both sides
  const Descriptor output(::memfd_create("output", MFD_CLOEXEC)), messages(::memfd_create("messages", MFD_CLOEXEC));
  Descriptor child_input(::open("/dev/null", O_RDONLY | O_CLOEXEC)), feed;
  if (input) {
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw Error(Fault::io_error, {command.front(), "no pipe can be made", "", ""});
    child_input.reset(ends[0]);
    feed.reset(ends[1]);
  }
  const pid_t child = start(command, child_input.get(), output.get(), messages.get());
  child_input.close();

  try {
    if (input)
      for (std::string piece = input(); !piece.empty() && write_whole(feed.get(), piece);) piece = input();
  } catch (...) {
    feed.close();
    ::kill(child, SIGTERM);
    wait_for(child);
    throw;
  }
  feed.close();
  ProcessResult result;
  result.exit_code = wait_for(child);
  if (result.exit_code == 128 + SIGXFSZ)
    throw Error(Fault::io_error,
                {command.front(), "was to write a file that is larger than files may be", "", disk_remedy(EFBIG)});
  result.output = read_from_start(output.get());
  result.messages = read_from_start(messages.get());
  return result;
}

RunningProcess::RunningProcess(const std::vector<std::string>& command) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw Error(Fault::io_error, {command.front(), "no pipe can be made", "", ""});
  Descriptor read_end(ends[0]), write_end(ends[1]), messages(::memfd_create("messages", MFD_CLOEXEC));
  const Descriptor nothing(::open("/dev/null", O_RDONLY | O_CLOEXEC));
  child_ = start(command, nothing.get(), write_end.get(), messages.get());
  ::fcntl(read_end.get(), F_SETFL, O_NONBLOCK);
  output_ = read_end.release();
  messages_ = messages.release();
}

RunningProcess::~RunningProcess() {
  if (!exit_code_) {
    send(SIGTERM);
    wait();
  }
  if (output_ >= 0) ::close(output_);
  ::close(messages_);
}

std::vector<std::string> RunningProcess::new_lines() {
  std::array<char, 4096> block;
  while (output_ >= 0) {
    const ssize_t count = ::read(output_, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) break;
    if (count <= 0) {
      ::close(output_);
      output_ = -1;
      break;
    }
    unfinished_.append(block.data(), std::size_t(count));
  }
  std::vector<std::string> lines;
  for (std::size_t end; (end = unfinished_.find('\n')) != std::string::npos; unfinished_.erase(0, end + 1))
    lines.push_back(unfinished_.substr(0, end));
  return lines;
}

void RunningProcess::send(int signal) const {
  if (!exit_code_) ::kill(child_, signal);
}

int RunningProcess::wait() {
  if (!exit_code_) exit_code_ = wait_for(child_);
  return *exit_code_;
}

std::string RunningProcess::messages() const {
  return read_from_start(messages_);
}

}  // namespace umax
