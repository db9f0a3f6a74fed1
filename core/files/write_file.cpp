#include "core/files/write_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "core/base/error.h"

namespace umax {
namespace {

bool is_full(int error) {
  return error == ENOSPC || error == EDQUOT || error == EFBIG;
}

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what, int error, bool creating) {
  const char* remedy =
      is_full(error) ? "free some space or choose another disk" : "choose a folder that can be written";
  throw Error(creating || is_full(error) ? Fault::cannot_create : Fault::io_error,
              {path.string(), what + " (" + std::strerror(error) + ")", "", remedy});
}

/// Writes and flushes all bytes; returns errno, 0 for success.
int write_all(int file, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(file, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes.remove_prefix(std::size_t(written));
  }
  // some file systems (pipes, special ones) know no flushing: that is no failure of the write
  return ::fsync(file) == 0 || errno == EINVAL || errno == EROFS ? 0 : errno;
}

}  // namespace

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  std::string name = ".";
  name.append(path.filename().string()).append(".part-").append(std::to_string(::getpid()));
  const auto temporary = path.parent_path() / name;
  const int file = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (file < 0) fail(path, "cannot be created", errno, true);

  int error = write_all(file, bytes);
  if (::close(file) != 0 && error == 0) error = errno;
  if (error != 0) {
    ::unlink(temporary.c_str());
    fail(path, "cannot be written", error, false);
  }
  if (::rename(temporary.c_str(), path.c_str()) != 0) {
    error = errno;
    ::unlink(temporary.c_str());
    fail(path, "cannot be put in place", error, error == EISDIR || error == EEXIST);
  }
}

}  // namespace umax
