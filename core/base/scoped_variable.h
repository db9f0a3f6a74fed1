// A variable of the process's environment that is another one for a while.
#pragma once

#include <optional>
#include <string>

namespace umax {

/// While one lives, the environment's variable has this value; none: it is not set. Afterwards it is as it was. Not for
/// several threads at once, as the environment is not.
class ScopedVariable {
 public:
  ScopedVariable(std::string name, const std::optional<std::string>& value);
  ~ScopedVariable();
  ScopedVariable(const ScopedVariable&) = delete;
  ScopedVariable& operator=(const ScopedVariable&) = delete;

 private:
  std::string name_;
  std::optional<std::string> found_;
};

}  // namespace umax
