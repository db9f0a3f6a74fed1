#include "core/files/file_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cassert>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <random>
#include <utility>

#include "core/base/error.h"
#include "core/files/disk_error.h"

namespace umax {
namespace {

constexpr std::size_t buffer_size = 1 << 20;

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what, int error, bool creating) {
  throw Error(creating || is_out_of_room(error) ? Fault::cannot_create : Fault::io_error,
              {path.string(), what + " (" + std::strerror(error) + ")", "", disk_remedy(error)});
}

/// Writes all bytes, at the file's end or at an offset; returns errno, 0 for success.
int write_all(int file, std::string_view bytes, long long offset = -1) {
  while (!bytes.empty()) {
    const ssize_t written = offset < 0 ? ::write(file, bytes.data(), bytes.size())
                                       : ::pwrite(file, bytes.data(), bytes.size(), off_t(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes.remove_prefix(std::size_t(written));
    if (offset >= 0) offset += written;
  }
  return 0;
}

int sync(int file) {
  // some file systems (pipes, special ones) know no flushing: that is no failure of the write
  return ::fsync(file) == 0 || errno == EINVAL || errno == EROFS ? 0 : errno;
}

/// So that the file's new name outlives a power cut. Some file systems cannot flush a folder: then it is theirs to keep.
void sync_folder_of(const std::filesystem::path& path) {
  const std::filesystem::path folder = path.has_parent_path() ? path.parent_path() : ".";
  const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (file < 0) return;
  ::fsync(file);
  ::close(file);
}

void rename_to(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  if (::rename(temporary.c_str(), path.c_str()) != 0) {
    const int error = errno;
    ::unlink(temporary.c_str());
    fail(path, "cannot be put in place", error, error == EISDIR || error == EEXIST);
  }
  sync_folder_of(path);
}

}  // namespace

std::filesystem::path temporary_beside(const std::filesystem::path& path, const std::string& ending) {
  // two machines, or two containers, may well have the same process number
  static const unsigned own = std::random_device()();
  static std::atomic<unsigned> count = 0;
  std::array<char, 64> suffix{};
  std::snprintf(suffix.data(), suffix.size(), ".part-%d-%08x-%u", int(::getpid()), own, ++count);
  return path.parent_path() / ("." + path.filename().string() + suffix.data() + ending);
}

void put_in_place(const std::filesystem::path& temporary, const std::filesystem::path& path) {
  const int file = ::open(temporary.c_str(), O_RDONLY | O_CLOEXEC);
  const int error = file < 0 ? errno : sync(file);
  if (file >= 0) ::close(file);
  if (error != 0) {
    ::unlink(temporary.c_str());
    fail(path, "cannot be written", error, false);
  }
  rename_to(temporary, path);
}

FileWriter::FileWriter(const std::filesystem::path& path) : path_(path) {
  temporary_ = temporary_beside(path);
  file_ = ::open(temporary_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file_ < 0) fail(path_, "cannot be created", errno, true);
}

FileWriter::FileWriter(FileWriter&& other) noexcept
    : path_(std::move(other.path_)),
      temporary_(std::move(other.temporary_)),
      file_(std::exchange(other.file_, -1)),
      buffer_(std::move(other.buffer_)),
      flushed_(other.flushed_) {}

FileWriter::~FileWriter() {
  if (file_ < 0) return;
  ::close(file_);
  ::unlink(temporary_.c_str());
}

void FileWriter::flush() {
  const int error = write_all(file_, buffer_);
  if (error != 0) fail(path_, "cannot be written", error, false);
  flushed_ += (long long)(buffer_.size());
  buffer_.clear();
}

void FileWriter::write(std::string_view bytes) {
  if (buffer_.size() + bytes.size() > buffer_size) flush();
  if (bytes.size() < buffer_size) {
    buffer_.append(bytes);
    return;
  }
  const int error = write_all(file_, bytes);
  if (error != 0) fail(path_, "cannot be written", error, false);
  flushed_ += (long long)(bytes.size());
}

void FileWriter::write_at(long long offset, std::string_view bytes) {
  assert(offset >= 0 && offset + (long long)(bytes.size()) <= size());
  flush();
  const int error = write_all(file_, bytes, offset);
  if (error != 0) fail(path_, "cannot be written", error, false);
}

void FileWriter::append_to(FileWriter& other) {
  flush();
  std::string block(buffer_size, '\0');
  for (long long at = 0; at < flushed_;) {
    const ssize_t count = ::pread(file_, block.data(), block.size(), off_t(at));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) fail(path_, "cannot be read again", count < 0 ? errno : EIO, false);
    other.write(std::string_view(block).substr(0, std::size_t(count)));
    at += count;
  }
}

void FileWriter::finish() {
  flush();
  int error = sync(file_);
  if (::close(std::exchange(file_, -1)) != 0 && error == 0) error = errno;
  if (error != 0) {
    ::unlink(temporary_.c_str());
    fail(path_, "cannot be written", error, false);
  }
  rename_to(temporary_, path_);
}

}  // namespace umax
