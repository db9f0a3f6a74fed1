#include "core/files/sha256.h"

#include "tests/scenes/scene_testing.h"

using namespace umax;

TEST_CASE("SHA-256 gives the digests of FIPS 180-4", "[sha256]") {
  CHECK(sha256_hex("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256_hex("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256_hex(std::string(1000000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("a file has the digest of its bytes", "[sha256]") {
  const std::string bytes = std::string(3000000, 'x') + std::string("\0end", 4);
  CHECK(sha256_of_file(test::write_file("digest.bin", bytes)) == sha256_hex(bytes));
  CHECK(sha256_of_file(test::write_file("empty.bin", "")) == sha256_hex(""));
  CHECK(test::failure_of([] { sha256_of_file("/no/such/file"); }).code == 66);
  CHECK(test::failure_of([] { sha256_of_file("/"); }).code == 66);
}
