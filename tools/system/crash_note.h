// What a program that crashes still puts down.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace umax {

/// What becomes of a file when the program crashes.
struct CrashText {
  std::filesystem::path path;
  std::string text;
  bool appended = false;  // behind what stands there; otherwise the file is replaced as a whole
};

/// While one lives, a crash (a memory fault, an abort) puts down what was prepared for it, and then takes its course. For
/// one job at a time: of two, the later counts. Handlers of signals are afterwards what they were before.
class CrashNote {
 public:
  CrashNote();
  ~CrashNote();
  CrashNote(const CrashNote&) = delete;
  CrashNote& operator=(const CrashNote&) = delete;

  /// From now on that: text_of(signal) is called here, once for each signal that a crash may have.
  void prepare(const std::function<std::vector<CrashText>(int signal)>& text_of);
};

/// "SIGSEGV"; "signal 40".
std::string signal_name(int signal);

}  // namespace umax
