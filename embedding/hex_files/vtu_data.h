// The arrays of a VTK XML file: text, base64 or raw bytes, plain or compressed.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace umax {

/// What the file says of all its arrays.
struct VtuEncoding {
  bool big_endian = false;
  bool long_headers = false;  // lengths before the data are UInt64, not UInt32
  bool compressed = false;    // by zlib
  std::string_view appended;  // what follows the _ of AppendedData; empty: there is none
  bool appended_base64 = false;
};

struct VtuArray {
  std::string name;
  std::string type;    // "Float64"
  std::string format;  // "ascii", "binary" or "appended"
  std::string_view text;
  long long offset = 0;  // in the appended data
};

/// count: how many numbers there must be; -1: as many as there are. Throws Error (bad_data) naming the array.
std::vector<double> read_vtu_array(const std::filesystem::path& path, const VtuEncoding& encoding,
                                   const VtuArray& array, long long count);

}  // namespace umax
