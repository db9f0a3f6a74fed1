// Helpers of the scene tests: small scenes as text, and what an error says.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "scenes/scene_file.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/support/temporary_folder.h"

namespace umax::test {

inline Scene read_text(const std::string& text, const std::vector<std::string>& sets = {}) {
  std::vector<Override> overrides;
  for (const std::string& set : sets) overrides.push_back(parse_override(set));
  return parse_scene({.text = text, .file = "test.toml"}, overrides);
}

inline Failure failure_of_text(const std::string& text, const std::vector<std::string>& sets = {}) {
  return failure_of([&] { read_text(text, sets); });
}

/// A file in the test's own folder, with its parents.
inline std::filesystem::path write_file(const std::string& name, const std::string& content) {
  const std::filesystem::path path = output_folder() / name;
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << content;
  return path;
}

/// One triangle: enough for the scene reader, which only looks at the file's bytes.
inline std::filesystem::path write_mesh(const std::string& name) {
  return write_file(name, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
}

}  // namespace umax::test
