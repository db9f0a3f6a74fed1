// What a refused call says.
#pragma once

#include <string>

#include "core/base/error.h"
#include "tools/system/exit_code.h"

namespace umax::test {

/// The error that a call throws; code is 0 if it throws none.
struct Failure {
  int code = 0;
  std::string message, where, what, value, remedy;
};

template <class Function>
Failure failure_of(const Function& function) {
  try {
    function();
  } catch (const Error& error) {
    const ErrorText& text = error.text();
    return {exit_code_of(error.fault()), error.what(), text.where, text.what, text.value, text.remedy};
  }
  return {};
}

inline bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace umax::test
