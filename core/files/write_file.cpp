#include "core/files/write_file.h"

#include "core/files/file_writer.h"

namespace umax {

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  FileWriter file(path);
  file.write(bytes);
  file.finish();
}

}  // namespace umax
