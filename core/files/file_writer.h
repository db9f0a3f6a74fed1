// A file that is written piece by piece and still appears whole or not at all: under a temporary name, then renamed.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace umax {

/// A name beside `path` for a file that will be renamed to it, which no other process on any machine chooses:
/// ".NAME.part-PROCESS-RANDOM" and the ending.
std::filesystem::path temporary_beside(const std::filesystem::path& path, const std::string& ending = {});

/// Flushes a whole file that another program has written, renames it to `path`, which is replaced in one step, and flushes
/// the folder. Throws Error (cannot_create, io_error), and removes it then.
void put_in_place(const std::filesystem::path& temporary, const std::filesystem::path& path);

/// Owns a file that is not finished yet. Dropped unfinished, it leaves nothing behind.
class FileWriter {
 public:
  /// Throws Error (cannot_create): no such folder, read-only, disk full.
  explicit FileWriter(const std::filesystem::path& path);
  FileWriter(FileWriter&& other) noexcept;
  FileWriter& operator=(FileWriter&&) = delete;
  ~FileWriter();

  /// Appends. Throws Error: cannot_create when the disk is full, io_error when the write fails otherwise.
  void write(std::string_view bytes);

  /// Replaces bytes that have been written. Throws as write().
  void write_at(long long offset, std::string_view bytes);

  /// Appends all of this file's bytes to another one: for what is gathered apart first. Throws as write().
  void append_to(FileWriter& other);

  /// Flushes, and puts the file at its path in one step, replacing what was there; then flushes the folder. Throws as
  /// write_file().
  void finish();

  long long size() const { return flushed_ + (long long)(buffer_.size()); }  // [bytes] so far
  const std::filesystem::path& path() const { return path_; }

 private:
  void flush();

  std::filesystem::path path_, temporary_;
  int file_ = -1;
  std::string buffer_;
  long long flushed_ = 0;
};

}  // namespace umax
