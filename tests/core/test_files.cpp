#include "core/files/file_writer.h"
#include "core/files/read_file.h"
#include "core/files/sha256.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/support/temporary_folder.h"

using namespace umax;
using test::contains;
using test::failure_of;

namespace {

/// More than one piece, with a zero byte in it.
const std::string several_pieces = std::string(3000000, 'x') + std::string("\0end", 4);

std::filesystem::path file_with(const std::string& bytes) {
  const std::filesystem::path path = output_folder() / "bytes.bin";
  make_file(path, bytes);
  return path;
}

}  // namespace

TEST_CASE("a file is read whole, byte for byte", "[files]") {
  CHECK(read_file(file_with(several_pieces)) == several_pieces);
  CHECK(read_file(file_with("")).empty());
  CHECK(contains(read_file("/proc/self/status"), "VmRSS"));  // a file that says it has no bytes

  std::string joined;
  read_pieces(file_with(several_pieces), [&](std::string_view piece) { joined += piece; });
  CHECK(joined == several_pieces);
}

TEST_CASE("a file that cannot be read is named with the reason and a remedy", "[files]") {
  const auto missing = failure_of([] { read_file("/no/such/file"); });
  CHECK(missing.code == 66);
  CHECK(missing.message == "/no/such/file: does not exist; check the path");
  const auto folder = failure_of([] { read_file("/"); });
  CHECK(folder.code == 74);
  CHECK(folder.message == "/: is a folder, not a file; name a file in it");
  // memory at address 0: opens, and does not read
  const auto broken = failure_of([] { read_file("/proc/self/mem"); });
  CHECK(broken.code == 74);
  CHECK(contains(broken.message, "/proc/self/mem: cannot be read (Input/output error)"));
  CHECK(failure_of([] { read_pieces("/no/such/file", [](std::string_view) {}); }).code == 66);

  CHECK(is_readable("/proc/self/mem"));
  CHECK_FALSE(is_readable("/no/such/file"));
}

TEST_CASE("a file that grows piece by piece appears whole, or leaves nothing", "[files]") {
  const TemporaryFolder folder;
  const auto path = folder / "grown.bin";
  {
    FileWriter dropped(path);
    dropped.write(several_pieces);
  }
  CHECK(std::filesystem::is_empty(folder.path()));

  FileWriter file(path);
  std::string wanted = "0123456789";
  file.write(wanted);
  for (int i = 0; i < 5; ++i) {  // small pieces wait in memory, large ones go by it
    for (const std::string& piece : {std::string(700000, char('a' + i)), several_pieces, std::string("end")}) {
      file.write(piece);
      wanted += piece;
    }
  }
  CHECK(file.size() == (long long)(wanted.size()));
  file.write_at(3, "ABC");
  file.write_at((long long)(wanted.size()) - 1, "!");
  wanted.replace(3, 3, "ABC");
  wanted.back() = '!';
  FileWriter moved(std::move(file));
  CHECK(!std::filesystem::exists(path));
  moved.finish();
  CHECK(read_file(path) == wanted);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("what is gathered in one file can go to the end of another", "[files]") {
  const TemporaryFolder folder;
  FileWriter file(folder / "whole");
  {
    FileWriter gathered(folder / "part");
    for (int i = 0; i < 3; ++i) gathered.write(several_pieces);
    gathered.write("the end");
    file.write("first ");
    gathered.append_to(file);
  }
  file.finish();
  CHECK(read_file(folder / "whole") == "first " + several_pieces + several_pieces + several_pieces + "the end");
  CHECK(!std::filesystem::exists(folder / "part"));
}

TEST_CASE("a file that cannot be made, or finds the disk full, is named with a remedy", "[files]") {
  const auto failure = failure_of([] { FileWriter("/no/such/folder/file"); });
  CHECK(failure.code == 73);
  CHECK(contains(failure.message, "/no/such/folder/file: cannot be created"));
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder / "taken");
  CHECK(failure_of([&] { FileWriter(folder / "taken").finish(); }).code == 73);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("SHA-256 gives the digests of FIPS 180-4", "[sha256]") {
  CHECK(sha256_hex("") == "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  CHECK(sha256_hex("abc") == "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  CHECK(sha256_hex(std::string(1000000, 'a')) == "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST_CASE("a file has the digest of its bytes", "[sha256]") {
  CHECK(sha256_of_file(file_with(several_pieces)) == sha256_hex(several_pieces));
  CHECK(sha256_of_file(file_with("")) == sha256_hex(""));
  CHECK(failure_of([] { sha256_of_file("/no/such/file"); }).code == 66);
  CHECK(failure_of([] { sha256_of_file("/"); }).code == 66);
}
