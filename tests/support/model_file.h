// Meshes that the repository does not hold, for tests tagged [models].
#pragma once

#include <cstdlib>
#include <filesystem>
#include <string>

#include "tests/support/catch.h"

namespace umax::test {

/// The file in the folder that the environment's UMAX_MODELS names; the test fails where it names none.
inline std::filesystem::path model_file(const std::string& name) {
  const char* folder = std::getenv("UMAX_MODELS");
  if (folder == nullptr || *folder == '\0') FAIL("UMAX_MODELS names no folder with " << name);
  return std::filesystem::path(folder) / name;
}

}  // namespace umax::test
