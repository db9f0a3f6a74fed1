// Scene keys of animations that other programs have made: the file, and when it plays.
#pragma once

#include "embedding/caches/point_cache_reader.h"
#include "embedding/caches/sequence_files.h"
#include "scenes/mesh_keys.h"

namespace umax {

/// Reads the path of a point cache or of a folder of meshes, which must be there. Fills path and sha256.
inline void read_cache_path(const SceneValue& value, CacheSource& cache) {
  cache.path = PathKind().read(value);
  std::error_code failed;
  const bool is_folder = std::filesystem::is_directory(cache.path, failed);
  if (!is_folder && !std::filesystem::is_regular_file(cache.path, failed))
    throw Error(Fault::not_found, {.where = where_text(value.place, value.key),
                                   .what = "no such file or folder",
                                   .value = cache.path.string(),
                                   .remedy = "check the path"});
  if (!is_folder && !is_point_cache(cache.path))
    throw value_error(value, "is no animation by its name",
                      "give a .pc2 or .mdd file, or a folder of OBJ or PLY files, one a frame");
  try {
    cache.sha256 = sha256_of_cache(cache.path);
  } catch (const Error& error) {
    ErrorText text = error.text();
    text.where = where_text(value.place, value.key) + ": " + text.where;
    throw Error(error.fault(), text);
  }
}

/// The keys `name`_start, `name`_speed, `name`_offset, `name`_fps and `name`_sha256; cache_of(thing): its CacheSource.
template <class Builder, class CacheOf>
void add_cache_time_keys(Builder& keys, const std::string& name, const CacheOf& cache_of) {
  const auto part = [cache_of](auto member) {
    return [cache_of, member](auto& thing) {
      auto& cache = cache_of(thing);
      return cache.path.empty() ? nullptr : &(cache.*member);
    };
  };
  const std::string owner = name + " = \"PATH\"";
  keys.add(name + "_start", NumberKind{units::time, any_number}, part(&CacheSource::start),
           "the clip's time at which the animation begins; before, it stands still",
           {.unset = number_text(CacheSource().start), .belongs_to = owner});
  keys.add(name + "_speed", NumberKind{units::ratio, {.low = 0, .high = 1e6, .low_open = true}},
           part(&CacheSource::speed), "how fast it plays",
           {.unset = number_text(CacheSource().speed), .belongs_to = owner});
  keys.add(name + "_offset", NumberKind{units::time, any_number}, part(&CacheSource::offset),
           "how far into the animation it begins, in the animation's own time",
           {.unset = number_text(CacheSource().offset), .belongs_to = owner});
  keys.add(name + "_fps", NumberKind{units::rate, {.low = 0, .high = 1e6, .low_open = true}}, part(&CacheSource::fps),
           "frames of the animation in a second, whatever its file says; of a folder, one for each number",
           {.unset = "as an MDD or PC2 says, else clip.fps", .belongs_to = owner});
}

template <class Builder, class CacheOf, class Require>
void add_cache_keys(Builder& keys, const std::string& name, const std::string& meaning, const CacheOf& cache_of,
                    const Require& require) {
  using Text = std::optional<std::string>;
  keys.add_custom(
      name, PathKind().type(), meaning, {.unset = "none", .resets = {name + "_sha256"}},
      [cache_of, require](const SceneValue& value, auto& thing) {
        require(value, thing);
        read_cache_path(value, cache_of(thing));
      },
      [cache_of](const auto& thing) -> Text {
        const CacheSource& cache = cache_of(thing);
        return cache.path.empty() ? std::nullopt : Text(PathKind().write(cache.path));
      });
  keys.add_custom(
      name + "_sha256", "text", "SHA-256 of the animation; another one is refused", {.unset = "not checked"},
      [cache_of](const SceneValue& value, auto& thing) {
        const CacheSource& cache = cache_of(thing);
        if (cache.path.empty()) throw value_error(value, "does not fit here", "it belongs to an animation");
        check_sha256(value, "animation", cache.path, cache.sha256);
      },
      [cache_of](const auto& thing) -> Text {
        const CacheSource& cache = cache_of(thing);
        return cache.path.empty() ? std::nullopt : Text(toml_string(cache.sha256));
      });
  add_cache_time_keys(keys, name, cache_of);
}

}  // namespace umax
