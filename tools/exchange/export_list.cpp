#include "tools/exchange/export_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <sstream>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "embedding/caches/point_cache.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* list_name = ".umax.files";  // a line for each: path, kin, space, frames with tabs between

/// "1-24", "1-99x2", "3,4,9"
std::string frames_text(const std::vector<int>& frames) {
  if (frames.size() < 3 || !is_evenly_spaced(frames)) return fmt::format("{}", fmt::join(frames, ","));
  const int step = frames[1] - frames[0];
  return fmt::format("{}-{}{}", frames.front(), frames.back(), step == 1 ? "" : fmt::format("x{}", step));
}

/// The last frame of such a text.
int last_of(const std::string& frames) {
  const std::string range = frames.substr(0, frames.find('x'));
  return std::atoi(range.c_str() + range.find_last_of(",-") + 1);  // npos + 1: from the start
}

/// Caches, the mesh at rest beside them and sequences of OBJ share files; formats that say their axes and unit have no
/// kin.
std::string kin_of(ExportFormat format) {
  switch (format) {
    case ExportFormat::pc2:
    case ExportFormat::mdd:
    case ExportFormat::obj:
      return "obj";
    case ExportFormat::usd:
    case ExportFormat::gltf:
      return "";
    default:
      return traits_of(format).name;
  }
}

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

}  // namespace

ExportLabel label_of(const ExportOptions& options, const std::vector<int>& frames) {
  return {.kin = kin_of(options.format),
          .space = fmt::format("--up {} --scale {:g}", options.z_up ? 'z' : 'y', options.scale),
          .frames = traits_of(options.format).is_sequence ? "" : frames_text(frames)};
}

ExportList read_export_list(const fs::path& folder) {
  ExportList list;
  if (!is_there(folder / list_name)) return list;
  std::istringstream lines(read_file(folder / list_name));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string path;
    ExportLabel label;
    std::getline(words, path, '\t');
    std::getline(words, label.kin, '\t');
    std::getline(words, label.space, '\t');
    std::getline(words, label.frames, '\t');
    if (!path.empty()) list[path] = label;
  }
  return list;
}

void write_export_list(const fs::path& folder, const ExportList& list) {
  std::string text;
  for (const auto& [path, label] : list)
    text += path + '\t' + label.kin + '\t' + label.space + '\t' + label.frames + '\n';
  write_file(folder / list_name, text);
}

void remove_export_list(const fs::path& folder) {
  std::error_code error;
  fs::remove(folder / list_name, error);
}

std::vector<std::string> misfits(const fs::path& folder, const ExportList& list, const ExportLabel& label) {
  std::vector<std::string> found;
  for (const auto& [path, other] : list)
    if (!label.kin.empty() && other.kin == label.kin && other.space != label.space && is_there(folder / path))
      found.push_back(path);
  return found;
}

void refuse_misfits(const fs::path& folder, const ExportOptions& options, const std::string& remedy) {
  const ExportList list = read_export_list(folder);
  const ExportLabel label = label_of(options, {});
  const std::vector<std::string> found = misfits(folder, list, label);
  if (found.empty()) return;
  const std::string more = found.size() > 1 ? fmt::format(", as {} more files", found.size() - 1) : "";
  throw Error(Fault::cannot_create, {.where = (folder / found.front()).string(),
                                     .what = fmt::format("was exported with {}{}: it would not fit what is exported "
                                                         "with {} beside it",
                                                         list.at(found.front()).space, more, label.space),
                                     .remedy = remedy});
}

std::string caches_that_end_before(const fs::path& folder, int frame) {
  std::vector<std::string> found;
  for (const auto& [path, label] : read_export_list(folder)) {
    const bool is_part = path.find('/') != path.npos;  // of a file that is listed, too
    if (is_part || label.frames.empty() || last_of(label.frames) >= frame || !is_there(folder / path)) continue;
    found.push_back(fmt::format("{} ({})", path, label.frames));
  }
  return fmt::format("{}", fmt::join(found, ", "));
}

}  // namespace umax
