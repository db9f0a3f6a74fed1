// What tests of mesh files share: files spoilt on purpose, and what is said of them.
#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "embedding/mesh_files/mesh_io.h"
#include "tests/embedding/raw_bytes.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/support/replaced.h"

namespace umax::testing {

/// The file is refused with exit code 65, its name and these parts.
inline void check_refused(const std::filesystem::path& path, const std::vector<std::string>& parts) {
  const auto failure = test::failure_of([&] { load_mesh(path); });
  CAPTURE(path, failure.message);
  CHECK(failure.code == 65);
  CHECK(test::contains(failure.message, path.filename().string()));
  for (const std::string& part : parts) {
    CAPTURE(part);
    CHECK(test::contains(failure.message, part));
  }
}

/// Is that said of the file?
inline bool notes_say(const MeshFile& file, const std::string& part) {
  return std::any_of(file.notes.begin(), file.notes.end(),
                     [&](const std::string& note) { return test::contains(note, part); });
}

}  // namespace umax::testing
