#include "embedding/caches/sequence_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <optional>

#include "core/base/error.h"
#include "core/files/sha256.h"

namespace umax {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const fs::path& folder, const std::string& what, const std::string& remedy) {
  throw Error(Fault::bad_data, {.where = folder.string(), .what = what, .remedy = remedy});
}

std::string ending_of(const fs::path& path) {
  std::string ending = path.extension().string();
  for (char& c : ending) c = char(std::tolower(static_cast<unsigned char>(c)));
  return ending;
}

// a name taken apart: "walk_" and 12 of walk_0012.obj
struct NumberedName {
  std::string before;
  int number = 0;
};
std::optional<NumberedName> numbered(const std::string& stem) {
  constexpr std::size_t most_digits = 9;
  std::size_t digits = 0;
  while (digits < stem.size() && std::isdigit(static_cast<unsigned char>(stem[stem.size() - 1 - digits]))) ++digits;
  if (digits == 0 || digits > most_digits) return std::nullopt;
  return NumberedName{stem.substr(0, stem.size() - digits), std::stoi(stem.substr(stem.size() - digits))};
}

std::vector<fs::path> meshes_in(const fs::path& folder) {
  std::error_code failed;
  std::vector<fs::path> meshes;
  for (const auto& entry : fs::directory_iterator(folder, failed))
    if (entry.is_regular_file() && (ending_of(entry.path()) == ".obj" || ending_of(entry.path()) == ".ply"))
      meshes.push_back(entry.path());
  if (failed)
    throw Error(Fault::not_found, {.where = folder.string(),
                                   .what = "cannot be read as a folder (" + failed.message() + ")",
                                   .remedy = "check the path"});
  std::sort(meshes.begin(), meshes.end());
  if (meshes.empty())
    refuse(folder, "holds no OBJ or PLY files: it has no frames", "export the animation into it, one mesh a frame");
  return meshes;
}

// neighbours in a sorted sequence are equally far apart
void require_even(const fs::path& folder, const std::vector<SequenceFile>& sequence) {
  int step = 0;
  for (std::size_t i = 1; i < sequence.size(); ++i) {
    const int by = sequence[i].frame - sequence[i - 1].frame;
    if (by == 0)
      refuse(folder,
             fmt::format("has frame {} twice: {} and {}", sequence[i].frame, sequence[i - 1].path.filename().string(),
                         sequence[i].path.filename().string()),
             "remove one of them");
    step = step == 0 ? by : std::min(step, by);
  }
  for (std::size_t i = 1; i < sequence.size(); ++i)
    if (sequence[i].frame - sequence[i - 1].frame != step)
      refuse(folder,
             fmt::format("has a gap: frame {} is missing between {} and {}", sequence[i - 1].frame + step,
                         sequence[i - 1].path.filename().string(), sequence[i].path.filename().string()),
             "export the frames that are missing");
}

}  // namespace

std::vector<SequenceFile> find_sequence(const fs::path& folder) {
  const std::vector<fs::path> meshes = meshes_in(folder);
  std::vector<SequenceFile> sequence;
  std::optional<std::string> before;
  for (const fs::path& path : meshes) {
    const std::string name = path.filename().string();
    const auto parts = numbered(path.stem().string());
    if (!parts)
      refuse(folder, "has a mesh whose name does not end with the number of a frame: " + name,
             "name the files like walk_0001.obj, or move it elsewhere");
    if (ending_of(path) != ending_of(meshes.front()) || (before && parts->before != *before))
      refuse(folder, "has meshes of more than one animation: " + meshes.front().filename().string() + " and " + name,
             "give each animation a folder of its own");
    before = parts->before;
    sequence.push_back({parts->number, path});
  }
  std::sort(sequence.begin(), sequence.end(), [](const SequenceFile& a, const SequenceFile& b) {
    return a.frame != b.frame ? a.frame < b.frame : a.path < b.path;
  });
  require_even(folder, sequence);
  return sequence;
}

std::string sha256_of_cache(const fs::path& path) {
  if (!fs::is_directory(path)) return sha256_of_file(path);
  std::string names_and_digests;
  for (const SequenceFile& file : find_sequence(path))
    names_and_digests += file.path.filename().string() + '\n' + sha256_of_file(file.path) + '\n';
  return sha256_hex(names_and_digests);
}

}  // namespace umax
