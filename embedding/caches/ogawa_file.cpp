#include "embedding/caches/ogawa_file.h"

#include "embedding/caches/bytes.h"

namespace umax {

OgawaFile::OgawaFile(const std::filesystem::path& path) : file_(path) {
  file_.write(std::string_view("Ogawa\0\0\1\0\0\0\0\0\0\0\0", 16));
}

OgawaChild OgawaFile::add_data(std::initializer_list<std::string_view> parts) {
  std::uint64_t size = 0;
  for (const std::string_view part : parts) size += part.size();
  if (size == 0) return empty_ogawa_data;
  const auto position = OgawaChild(file_.size());
  std::string header;
  append_bytes(header, size);
  file_.write(header);
  for (const std::string_view part : parts) file_.write(part);
  return position | empty_ogawa_data;
}

OgawaChild OgawaFile::add_group(const std::vector<OgawaChild>& children) {
  if (children.empty()) return 0;
  const auto position = OgawaChild(file_.size());
  std::string header;
  append_bytes(header, std::uint64_t(children.size()));
  file_.write(header);
  file_.write(bytes_of(children));
  return position;
}

void OgawaFile::finish(OgawaChild root) {
  std::string position;
  append_bytes(position, root);
  file_.write_at(8, position);
  file_.write_at(5, "\xff");
  file_.finish();
}

}  // namespace umax
