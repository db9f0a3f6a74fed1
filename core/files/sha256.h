// SHA-256 digests of texts and files: how a run tells that a mesh is still the one it was made with.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

struct evp_md_ctx_st;  // of OpenSSL

namespace umax {

/// A digest of bytes that come in pieces.
class Sha256 {
 public:
  Sha256();
  void add(std::string_view bytes);
  /// 64 lower-case hexadecimal digits; nothing may be added afterwards.
  std::string hex();

 private:
  std::unique_ptr<evp_md_ctx_st, void (*)(evp_md_ctx_st*)> context_;
};

/// 64 lower-case hexadecimal digits.
std::string sha256_hex(std::string_view bytes);

/// Of a file's bytes. Throws Error: not_found if it is not a file, io_error if it cannot be read.
std::string sha256_of_file(const std::filesystem::path& path);

}  // namespace umax
