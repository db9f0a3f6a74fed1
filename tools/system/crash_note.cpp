#include "tools/system/crash_note.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <memory>
#include <mutex>

namespace umax {
namespace {

constexpr std::array<int, 5> crashes{SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

/// A file as the handler needs it, which may ask for no memory.
struct ReadyText {
  std::string path, temporary, text;
  bool appended = false;
};

struct Prepared {
  std::array<std::vector<ReadyText>, crashes.size()> of_signal;
};

std::atomic<const Prepared*> prepared = nullptr;
static_assert(std::atomic<const Prepared*>::is_always_lock_free, "a signal handler may not lock");
std::mutex mutex;                                // of what follows; the handler takes none
std::unique_ptr<const Prepared> latest, former;  // the former is kept for a handler that looks at it right now
int num_notes = 0;
std::array<struct sigaction, crashes.size()> found{};  // before the first note
alignas(16) std::array<char, 1 << 15> handler_stack;   // a crash may be that the stack is full
stack_t found_stack{};

void put_down(const ReadyText& ready) {
  const char* path = ready.appended ? ready.path.c_str() : ready.temporary.c_str();
  const int file = open(path, O_WRONLY | O_CREAT | O_CLOEXEC | (ready.appended ? O_APPEND : O_TRUNC), 0666);
  if (file < 0) return;
  const bool is_whole =
      write(file, ready.text.data(), ready.text.size()) == ssize_t(ready.text.size()) && fsync(file) == 0;
  close(file);
  if (ready.appended) return;
  if (is_whole)
    std::rename(path, ready.path.c_str());
  else
    unlink(path);
}

void note_crash(int signal) {
  for (std::size_t i = 0; i < crashes.size(); ++i) {
    if (crashes[i] != signal) continue;
    if (const Prepared* ready = prepared.exchange(nullptr))
      for (const ReadyText& text : ready->of_signal[i]) put_down(text);
    sigaction(signal, &found[i], nullptr);
    raise(signal);  // comes as soon as this handler is left, to whom it would have come without us
  }
}

ReadyText ready_text(const CrashText& text) {
  const auto temporary = text.path.parent_path() / ("." + text.path.filename().string() + ".part-crash");
  return {.path = text.path.string(), .temporary = temporary.string(), .text = text.text, .appended = text.appended};
}

}  // namespace

CrashNote::CrashNote() {
  const std::lock_guard<std::mutex> lock(mutex);
  if (num_notes++ > 0) return;
  stack_t stack{};
  stack.ss_sp = handler_stack.data();
  stack.ss_size = handler_stack.size();
  sigaltstack(&stack, &found_stack);
  struct sigaction action{};
  action.sa_handler = note_crash;
  action.sa_flags = SA_ONSTACK;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < crashes.size(); ++i) sigaction(crashes[i], &action, &found[i]);
}

CrashNote::~CrashNote() {
  const std::lock_guard<std::mutex> lock(mutex);
  if (--num_notes > 0) return;
  prepared = nullptr;
  for (std::size_t i = 0; i < crashes.size(); ++i) {
    struct sigaction now{};
    sigaction(crashes[i], nullptr, &now);
    if (now.sa_handler == note_crash) sigaction(crashes[i], &found[i], nullptr);
  }
  sigaltstack(&found_stack, nullptr);
}

void CrashNote::prepare(const std::function<std::vector<CrashText>(int)>& text_of) {
  auto next = std::make_unique<Prepared>();
  for (std::size_t i = 0; i < crashes.size(); ++i)
    for (const CrashText& text : text_of(crashes[i])) next->of_signal[i].push_back(ready_text(text));
  const std::lock_guard<std::mutex> lock(mutex);
  prepared = next.get();
  former = std::move(latest);
  latest = std::move(next);
}

std::string signal_name(int signal) {
  const char* name = sigabbrev_np(signal);
  return name ? fmt::format("SIG{}", name) : fmt::format("signal {}", signal);
}

}  // namespace umax
