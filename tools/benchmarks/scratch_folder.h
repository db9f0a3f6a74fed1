// A folder that goes with the benchmark that made it, and the program that is measured from outside.
#pragma once

#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <stdexcept>
#include <string>

namespace umax {

struct ScratchFolder {
  std::filesystem::path path;
  explicit ScratchFolder(const std::filesystem::path& place = std::filesystem::temp_directory_path()) {
    std::string name = (place / "umax-bench-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("no scratch folder in " + name);
    path = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
};

/// The program that stands beside the bench.
inline std::string program() {
  return (std::filesystem::read_symlink("/proc/self/exe").parent_path() / "umax").string();
}

}  // namespace umax
