// Writes a file so that it is whole or not there: under a temporary name in the same folder, flushed, renamed.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace umax {

/// Puts `bytes` at `path`, replacing what was there in one step. Throws Error: cannot_create when the folder is missing
/// or read-only or the disk is full, io_error when the write or the renaming fails otherwise; then `path` is as it was
/// before.
void write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace umax
