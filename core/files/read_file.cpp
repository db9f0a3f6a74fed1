#include "core/files/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <vector>

#include "core/base/error.h"

namespace umax {
namespace {

class FileDescriptor {
 public:
  explicit FileDescriptor(const std::filesystem::path& path) : number_(::open(path.c_str(), O_RDONLY | O_CLOEXEC)) {}
  ~FileDescriptor() {
    if (number_ >= 0) ::close(number_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

[[noreturn]] void fail(const std::filesystem::path& path, const char* action, int error) {
  if (error == ENOENT || error == ENOTDIR)
    throw Error(Fault::not_found, {path.string(), "does not exist", "", "check the path"});
  if (error == EISDIR)
    throw Error(Fault::io_error, {path.string(), "is a folder, not a file", "", "name a file in it"});
  const bool is_denied = error == EACCES || error == EPERM;
  throw Error(Fault::io_error, {path.string(), std::string("cannot be ") + action + " (" + std::strerror(error) + ")",
                                "", is_denied ? "check its permissions" : "check the file and its disk"});
}

/// Calls take(bytes) until the file ends.
template <class Take>
void read_all(int file, const std::filesystem::path& path, const Take& take) {
  std::vector<char> block(1 << 18);
  while (true) {
    const ssize_t count = ::read(file, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail(path, "read", errno);
    if (count == 0) return;
    take(std::string_view(block.data(), std::size_t(count)));
  }
}

}  // namespace

bool is_readable(const std::filesystem::path& path) {
  return FileDescriptor(path).number() >= 0;
}

std::string read_file(const std::filesystem::path& path) {
  const FileDescriptor file(path);
  if (file.number() < 0) fail(path, "opened", errno);
  struct stat status{};
  std::string bytes;
  if (::fstat(file.number(), &status) == 0 && status.st_size > 0) bytes.reserve(std::size_t(status.st_size));
  read_all(file.number(), path, [&](std::string_view piece) { bytes.append(piece); });
  return bytes;
}

void read_pieces(const std::filesystem::path& path, const std::function<void(std::string_view)>& take) {
  const FileDescriptor file(path);
  if (file.number() < 0) fail(path, "opened", errno);
  read_all(file.number(), path, take);
}

}  // namespace umax
