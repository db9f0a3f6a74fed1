#include "core/files/sha256.h"

#include <openssl/evp.h>

#include <array>

#include "core/base/error.h"
#include "core/files/read_file.h"

namespace umax {
namespace {

void check(int result) {
  if (result != 1) throw Error(Fault::internal, {.what = "SHA-256 is not available in this OpenSSL"});
}

}  // namespace

Sha256::Sha256() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
  check(EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr));
}

void Sha256::add(std::string_view bytes) {
  check(EVP_DigestUpdate(context_.get(), bytes.data(), bytes.size()));
}

std::string Sha256::hex() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
  unsigned size = 0;
  check(EVP_DigestFinal_ex(context_.get(), digest.data(), &size));
  std::string text;
  for (unsigned i = 0; i < size; ++i) {
    text += "0123456789abcdef"[digest[i] >> 4];
    text += "0123456789abcdef"[digest[i] & 15];
  }
  return text;
}

std::string sha256_hex(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.hex();
}

std::string sha256_of_file(const std::filesystem::path& path) {
  std::error_code failed;
  if (!std::filesystem::is_regular_file(path, failed))
    throw Error(Fault::not_found, {.where = path.string(), .what = "no such file"});
  Sha256 hash;
  read_pieces(path, [&](std::string_view bytes) { hash.add(bytes); });
  return hash.hex();
}

}  // namespace umax
