#include "tests/fuzz/fuzz_target.h"

#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>

#include "core/base/error.h"

namespace umax::fuzz {
namespace {

/// A folder of this process's own.
class Folder {
 public:
  Folder() : path_(std::filesystem::temp_directory_path() / ("umax-fuzz-" + std::to_string(::getpid()))) {
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code error;
    std::filesystem::remove_all(path_, error);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

void require_clear(const Error& error) {
  if (error.fault() != Fault::bad_data && error.fault() != Fault::not_found)
    break_off(std::string("an error of another kind than bad data: ") + error.what());
  const ErrorText& text = error.text();
  if (text.where.empty() || text.what.empty() || text.remedy.empty())
    break_off(std::string("an error that lacks where, what or the remedy: ") + error.what());
}

}  // namespace

void break_off(const std::string& what) {
  std::fprintf(stderr, "does not hold: %s\n", what.c_str());
  std::abort();
}

bool accepts(const std::function<void()>& read) {
  try {
    read();
    return true;
  } catch (const Error& error) {
    require_clear(error);
    return false;
  }
}

std::filesystem::path as_file(std::string_view bytes, const std::string& name) {
  static const Folder folder;
  const std::filesystem::path path = folder.path() / name;
  std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
  return path;
}

}  // namespace umax::fuzz
