#include "embedding/hex_files/vtu_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <optional>

#include "embedding/scanning/compression.h"
#include "embedding/scanning/file_checks.h"
#include "embedding/scanning/mesh_scanner.h"
#include "embedding/scanning/raw_numbers.h"

namespace umax {
namespace {

using Path = std::filesystem::path;

[[noreturn]] void refuse_array(const Path& path, const VtuArray& array, const std::string& what,
                               const std::string& value = {},
                               const std::string& remedy = "the file is truncated or damaged: export it again") {
  refuse_mesh(path.string() + ": " + array.name, what, value, remedy);
}

NumberType type_of(const Path& path, const VtuArray& array) {
  static const std::map<std::string, NumberType> types{
      {"Int8", NumberType::int8},      {"UInt8", NumberType::uint8},   {"Int16", NumberType::int16},
      {"UInt16", NumberType::uint16},  {"Int32", NumberType::int32},   {"UInt32", NumberType::uint32},
      {"Int64", NumberType::int64},    {"UInt64", NumberType::uint64}, {"Float32", NumberType::float32},
      {"Float64", NumberType::float64}};
  const auto found = types.find(array.type);
  if (found == types.end()) refuse_array(path, array, "is of an unknown type", '"' + array.type.substr(0, 40) + '"');
  return found->second;
}

int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

// Hands out bytes from the front, which may be encoded. Header and data may be encoded apart: padding between them is
// stepped over.
class Bytes {
 public:
  Bytes(const Path& path, const VtuArray& array, std::string_view text, bool base64)
      : path_(path), array_(array), text_(text), base64_(base64) {}

  // how many may follow at most
  std::size_t room() const { return base64_ ? decoded_.size() - taken_ + (text_.size() + 3) / 4 * 3 : text_.size(); }

  std::string take(std::size_t n) {
    if (n > room()) refuse_array(path_, array_, "ends too early", fmt::format("{} of {} bytes", room(), n));
    if (!base64_) {
      const std::string bytes(text_.substr(0, n));
      text_.remove_prefix(n);
      return bytes;
    }
    while (decoded_.size() - taken_ < n) decode_group();
    const std::string bytes = decoded_.substr(taken_, n);
    taken_ += n;
    if (taken_ > 4096 && 2 * taken_ > decoded_.size()) {
      decoded_.erase(0, taken_);
      taken_ = 0;
    }
    return bytes;
  }

 private:
  void decode_group() {
    std::array<char, 4> group{};
    for (char& c : group) {
      text_.remove_prefix(std::min(text_.find_first_not_of(" \t\r\n"), text_.size()));
      if (text_.empty()) refuse_array(path_, array_, "ends too early", "base64 text");
      c = text_.front();
      text_.remove_prefix(1);
    }
    const std::size_t padding = group[3] != '=' ? 0 : group[2] != '=' ? 1 : 2;
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const int value = i >= 4 - padding ? 0 : base64_value(group[i]);
      if (value < 0) refuse_array(path_, array_, "has a character that is not base64", fmt::format("'{}'", group[i]));
      bits = bits << 6 | std::uint32_t(value);
    }
    for (std::size_t i = 0; i < 3 - padding; ++i) decoded_ += char(bits >> (16 - 8 * i) & 255);
  }

  const Path& path_;
  const VtuArray& array_;
  std::string_view text_;
  bool base64_;
  std::string decoded_;
  std::size_t taken_ = 0;
};

std::uint64_t take_length(Bytes& bytes, const VtuEncoding& encoding) {
  const std::string raw = bytes.take(encoding.long_headers ? 8 : 4);
  std::uint64_t length = 0;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const std::size_t at = encoding.big_endian ? i : raw.size() - 1 - i;
    length = length << 8 | std::uint8_t(raw[at]);
  }
  return length;
}

// number of blocks, size of a block, size of the last one if it is smaller, compressed sizes; then the blocks
std::string take_compressed(const Path& path, const VtuArray& array, const VtuEncoding& encoding, Bytes& bytes) {
  constexpr std::uint64_t largest_block = 1u << 30, most_compression = 1100;
  const std::uint64_t count = take_length(bytes, encoding), size = take_length(bytes, encoding),
                      last = take_length(bytes, encoding);
  if (count > bytes.room() || size > largest_block || last > size)
    refuse_array(path, array, "has impossible compressed blocks", fmt::format("{} of {} bytes", count, size));
  std::vector<std::uint64_t> sizes(count);
  for (std::uint64_t& compressed : sizes) compressed = take_length(bytes, encoding);
  std::string all;
  for (std::uint64_t b = 0; b < count; ++b) {
    const std::uint64_t wanted = b + 1 == count && last > 0 ? last : size;
    if (sizes[b] > bytes.room() || wanted > most_compression * (sizes[b] + 16))
      refuse_array(path, array, fmt::format("ends within compressed block {}", b));
    const std::optional<std::string> block = decompress(bytes.take(sizes[b]), wanted);
    if (!block) refuse_array(path, array, fmt::format("cannot be decompressed (block {})", b));
    all += *block;
  }
  return all;
}

std::vector<double> read_text(const Path& path, const VtuArray& array) {
  MeshScanner scan(path, array.text, array.name);
  std::vector<double> numbers;
  while (!scan.at_end()) numbers.push_back(scan.number("a value"));
  return numbers;
}

}  // namespace

std::vector<double> read_vtu_array(const Path& path, const VtuEncoding& encoding, const VtuArray& array,
                                   long long count) {
  const NumberType type = type_of(path, array);
  std::vector<double> numbers;
  if (array.format == "ascii") {
    numbers = read_text(path, array);
  } else {
    const bool appended = array.format == "appended";
    if (!appended && array.format != "binary")
      refuse_array(path, array, "is of an unknown format", '"' + array.format.substr(0, 40) + '"');
    if (appended && (array.offset < 0 || array.offset >= (long long)(encoding.appended.size())))
      refuse_array(path, array, "begins behind the appended data",
                   fmt::format("{} of {} bytes", array.offset, encoding.appended.size()));
    Bytes bytes(path, array, appended ? encoding.appended.substr(std::size_t(array.offset)) : array.text,
                !appended || encoding.appended_base64);
    const std::string raw =
        encoding.compressed ? take_compressed(path, array, encoding, bytes) : bytes.take(take_length(bytes, encoding));
    if (raw.size() % std::size_t(size_of(type)) != 0)
      refuse_array(path, array, "has bytes left over", std::to_string(raw.size()));
    numbers = decode_numbers(raw, type, encoding.big_endian);
  }
  if (count >= 0 && (long long)(numbers.size()) != count)
    refuse_array(path, array, "does not hold as many numbers as promised",
                 fmt::format("{} of {}", numbers.size(), count));
  return numbers;
}

}  // namespace umax
