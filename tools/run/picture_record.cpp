#include "tools/run/picture_record.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <utility>

#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "tools/run/frame_list.h"

namespace umax {
namespace {

using Settings = std::vector<std::pair<std::string, std::string>>;  // key, value

/// A resolved scene has a line for each key.
Settings settings_in(const std::string& text) {
  Settings settings;
  std::string table;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = line.find(" = ");
    if (line.starts_with("[")) table = line.substr(1, line.find(']') - 1) + ".";
    if (!line.starts_with("#") && equals != std::string::npos)
      settings.emplace_back((line[0] == '[' ? "" : table) + line.substr(0, equals), line.substr(equals + 3));
  }
  return settings;
}

std::string value_of(const Settings& settings, const std::string& key) {
  for (const auto& [name, value] : settings)
    if (name == key) return value;
  return "not set";
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::vector<int> frames_in(const std::string& list) {
  return list.empty() ? std::vector<int>() : parse_frame_list(list);
}

}  // namespace

void write_picture_record(const std::filesystem::path& path, const PictureRecord& record) {
  nlohmann::ordered_json json;
  json["pictures_sha256"] = record.digest;
  json["clip_frames"] = record.clip_frames;
  json["clip_of"] = frame_list_text(record.frames);
  json["next_clip_of"] = frame_list_text(record.next);
  json["clip_is_shared"] = record.clip_is_shared;
  json["settings"] = lines_of(record.settings);
  write_file(path, json.dump(1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
}

std::optional<PictureRecord> read_picture_record(const std::filesystem::path& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return std::nullopt;
  try {
    const nlohmann::json json = nlohmann::json::parse(read_file(path));
    PictureRecord record;
    record.digest = json.at("pictures_sha256");
    record.clip_frames = json.at("clip_frames");
    record.frames = frames_in(json.at("clip_of"));
    record.next = frames_in(json.at("next_clip_of"));
    record.clip_is_shared = json.at("clip_is_shared");
    for (const std::string line : json.at("settings")) record.settings += line + "\n";
    return record;
  } catch (const std::exception&) {  // of JSON, or of a list of frames
    return std::nullopt;
  }
}

std::string first_difference(const std::string& there, const std::string& here) {
  const Settings a = settings_in(there), b = settings_in(here);
  for (const Settings* settings : {&a, &b})
    for (const auto& [key, value] : *settings)
      if (value_of(a, key) != value_of(b, key))
        return fmt::format("{} is {} there, {} here", key, value_of(a, key), value_of(b, key));
  return {};
}

}  // namespace umax
