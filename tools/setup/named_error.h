// Errors that say of which of the scene's things they are.
#pragma once

#include <string>

#include "core/base/error.h"

namespace umax {

/// Calls `work` and puts the thing's name in front of an error that it throws.
template <class Work>
auto named(const std::string& thing, Work work) {
  try {
    return work();
  } catch (const Error& error) {
    ErrorText text = error.text();
    if (!text.where.starts_with(thing)) text.where = text.where.empty() ? thing : thing + ": " + text.where;
    throw Error(error.fault(), text);
  }
}

}  // namespace umax
