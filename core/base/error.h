// The one exception for faults that the user can mend: what kind it is, where, what, the value found, and the remedy.
// Programming faults are asserts; trouble of the numerics is StepReport::status.
#pragma once

#include <stdexcept>
#include <string>

namespace umax {

/// What went wrong, in kinds that call for different answers. A program ends with one of its exit codes for each:
/// tools/system/exit_code.h.
enum class Fault {
  usage,          // wrong usage of the command line
  bad_data,       // scene, mesh, state or data cannot be used
  not_found,      // an input does not exist
  unavailable,    // a helper program is missing
  internal,       // our own fault
  cannot_create,  // folder exists, read-only, disk full
  io_error,       // a read or write failed later
  try_again,      // temporary: locked, or --strict and a step did not converge
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
  Error(Fault fault, const ErrorText& text) : std::runtime_error(compose(text)), fault_(fault), text_(text) {}
  Fault fault() const { return fault_; }
  const ErrorText& text() const { return text_; }

 private:
  static std::string compose(const ErrorText& text) {
    std::string message = text.where.empty() ? text.what : text.where + ": " + text.what;
    if (!text.value.empty()) message += ", got " + text.value;
    if (!text.remedy.empty()) message += "; " + text.remedy;
    return message;
  }
  Fault fault_;
  ErrorText text_;
};

}  // namespace umax
