// OpenVDB files in the embedding tests' own folder.
#pragma once

#include "tests/support/vdb_files.h"

namespace umax::testing {

inline std::filesystem::path vdb_file(const std::string& name, const std::vector<test::VdbContent>& grids) {
  const auto path = std::filesystem::path(UMAX_TEST_OUTPUT) / "embedding" / name;
  test::write_vdb(path, grids);
  return path;
}

}  // namespace umax::testing
