// Whole files from the disk, with an error that names the file, the system's reason and a remedy.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace umax {

/// Whether the file can be opened for reading.
bool is_readable(const std::filesystem::path& path);

/// All bytes of the file; of a pipe, what comes until it ends. Throws Error: not_found when it does not exist, io_error
/// when it is a folder or cannot be read.
std::string read_file(const std::filesystem::path& path);

/// Hands over the file's bytes piece by piece, in order, for what need not hold all of them. Throws as read_file().
void read_pieces(const std::filesystem::path& path, const std::function<void(std::string_view)>& take);

}  // namespace umax
