// OpenVDB files in the embedding tests' own folder.
#pragma once

#include "tests/support/temporary_folder.h"
#include "tests/support/vdb_files.h"

namespace umax::testing {

inline std::filesystem::path vdb_file(const std::string& name, const std::vector<test::VdbContent>& grids,
                                      test::VdbCompression compression = test::VdbCompression::blosc) {
  const auto path = output_folder() / name;
  test::write_vdb(path, grids, compression);
  return path;
}

}  // namespace umax::testing
