// Writes a scene as it was resolved, with every key and default spelled out, so that a run can be repeated.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "scenes/scene.h"

namespace umax {

/// TOML with every default, absolute paths, the SHA-256 of meshes, numbers to the last bit. Reading it gives the same
/// scene, writing that gives the same bytes.
/// comments: by full key ("body.beam.limit.energy"), put behind the key's value.
std::string resolved_toml(const Scene& scene, const std::map<std::string, std::string>& comments = {});

/// Its settings that are not those of the table of keys by default, as "body.beam.limit.energy = 0.1", in the order of the
/// resolved scene.
std::vector<std::string> changed_settings(const Scene& scene);

}  // namespace umax
