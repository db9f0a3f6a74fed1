// Ogawa, the container of Alembic files: data and groups of positions, written one behind the other.
//
// "Ogawa", byte 0xff once all is there (else 0), uint16 version 1 (big-endian), uint64 position of the root group; then
// data   uint64 size, bytes
// group  uint64 count, for each child its uint64 position; the highest bit is set where the child is data
// Position 0 is an empty group, or with the highest bit empty data. Numbers are little-endian.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <vector>

#include "core/files/file_writer.h"

namespace umax {

/// What a group holds of a child: its position, and what it is.
using OgawaChild = std::uint64_t;
inline constexpr OgawaChild empty_ogawa_data = OgawaChild(1) << 63;

class OgawaFile {
 public:
  /// Throws Error (cannot_create).
  explicit OgawaFile(const std::filesystem::path& path);

  /// Writes the parts as one piece of data, or a group. Throw Error (cannot_create, io_error).
  OgawaChild add_data(std::initializer_list<std::string_view> parts);
  OgawaChild add_group(const std::vector<OgawaChild>& children);

  void finish(OgawaChild root);

 private:
  FileWriter file_;
};

}  // namespace umax
