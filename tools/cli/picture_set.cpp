#include "tools/cli/picture_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>

#include "core/base/error.h"
#include "tools/run/clip.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

bool is_picture(const fs::path& path) {
  return path.extension() == ".png" || path.extension() == ".exr";
}

std::vector<std::string> pictures_in(const fs::path& folder) {
  std::error_code error;
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (is_picture(entry.path())) names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

void require_all(const PictureSet& set, const std::vector<std::string>& wanted) {
  for (const std::string& name : wanted)
    if (!std::binary_search(set.names().begin(), set.names().end(), name))
      throw Error(Fault::not_found, {.where = set.path_of(name).string(),
                                     .what = "does not exist, but the other folder has it",
                                     .remedy = "render the same frames and kinds of pictures in both"});
}

std::vector<std::string> pngs_of(const PictureSet& set) {
  std::vector<std::string> names = set.names();
  std::erase_if(names, [](const fs::path& name) { return name.extension() != ".png"; });
  return names;
}

}  // namespace

bool is_clip_file(const fs::path& path) {
  constexpr std::array endings{".mp4", ".mov", ".mkv", ".webm", ".avi", ".gif", ".webp", ".m4v"};
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

PictureSet::PictureSet(const fs::path& source) : source_(source), folder_(source) {
  std::error_code error;
  if (is_clip_file(source)) {
    decode_clip(source, decoded_.emplace().path());
    folder_ = decoded_->path();
  } else if (fs::is_directory(source / "frames", error)) {
    folder_ = source / "frames";
  }
  names_ = pictures_in(folder_);
  if (names_.empty())
    throw Error(Fault::not_found,
                {.where = folder_.string(),
                 .what = "holds no pictures",
                 .remedy = "give two pictures, two clips, or two folders with pictures of the same names"});
}

std::vector<std::string> names_of_both(const PictureSet& a, const PictureSet& b) {
  if (!a.is_clip() && !b.is_clip()) {
    require_all(b, a.names());
    require_all(a, b.names());
    return a.names();
  }
  std::vector<std::string> names = pngs_of(a);
  const std::size_t others = pngs_of(b).size();
  if (names.size() != others)
    throw Error(Fault::bad_data, {.where = b.source().string(),
                                  .what = fmt::format("has another number of frames than {}", a.source().string()),
                                  .value = fmt::format("{} and {}", others, names.size()),
                                  .remedy = "render and encode the same frames of both"});
  return names;
}

}  // namespace umax
