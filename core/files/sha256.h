// SHA-256 digests of texts and files: how a run tells that a mesh is still the one it was made with.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace umax {

/// 64 lower-case hexadecimal digits.
std::string sha256_hex(std::string_view bytes);

/// Of a file's bytes. Throws Error: not_found if it is not a file, io_error if it cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace umax
