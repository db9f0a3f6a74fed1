// The one exception for faults that the user can mend: what kind it is, where, what, the value found, and the remedy.
// Programming faults are asserts; trouble of the numerics is StepReport::status.
#pragma once

#include <stdexcept>
#include <string>

namespace umax {

/// The program's exit codes (sysexits.h where it has one). 0 is success, 1 is `compare`: past the threshold.
enum class ExitCode : int {
  usage = 2,           // wrong usage of the command line
  bad_data = 65,       // scene, mesh, state or data cannot be used
  not_found = 66,      // an input does not exist
  unavailable = 69,    // a helper program is missing
  internal = 70,       // our own fault
  cannot_create = 73,  // folder exists, read-only, disk full
  io_error = 74,       // a read or write failed later
  try_again = 75,      // temporary: locked, or --strict and a step did not converge
};

/// What a message must say. Empty parts are left out: "WHERE: WHAT, got VALUE; REMEDY".
struct ErrorText {
  std::string where = {};   // "scene.toml:12: body.beam.limit.energy" or "mesh.obj"
  std::string what = {};    // "must be positive"
  std::string value = {};   // "-1 J", as the user wrote it
  std::string remedy = {};  // "give an energy such as \"100 J\""
};

class Error : public std::runtime_error {
 public:
  Error(ExitCode exit_code, const ErrorText& text) : std::runtime_error(compose(text)), code_(exit_code), text_(text) {}
  ExitCode exit_code() const { return code_; }
  const ErrorText& text() const { return text_; }

 private:
  static std::string compose(const ErrorText& text) {
    std::string message = text.where.empty() ? text.what : text.where + ": " + text.what;
    if (!text.value.empty()) message += ", got " + text.value;
    if (!text.remedy.empty()) message += "; " + text.remedy;
    return message;
  }
  ExitCode code_;
  ErrorText text_;
};

}  // namespace umax
