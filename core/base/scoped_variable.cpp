#include "core/base/scoped_variable.h"

#include <cstdlib>
#include <utility>

namespace umax {
namespace {

void put(const std::string& name, const std::optional<std::string>& value) {
  if (value)
    ::setenv(name.c_str(), value->c_str(), 1);
  else
    ::unsetenv(name.c_str());
}

}  // namespace

ScopedVariable::ScopedVariable(std::string name, const std::optional<std::string>& value) : name_(std::move(name)) {
  if (const char* found = std::getenv(name_.c_str())) found_ = found;
  put(name_, value);
}

ScopedVariable::~ScopedVariable() {
  put(name_, found_);
}

}  // namespace umax
