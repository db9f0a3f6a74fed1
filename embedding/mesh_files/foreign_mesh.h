// Meshes of foreign formats, read by the helper program umax-import: whatever such a file does to the library that reads
// it, this process goes on.
#pragma once

#include "embedding/mesh_record/mesh_file.h"

namespace umax {

/// What the helper may take before it is ended.
struct ImportLimits {
  long long memory = 0;   // [bytes] of addresses
  long long seconds = 0;  // [s] of processor time; by the clock, five times as long
};

/// Much more than a sound file of this size needs.
ImportLimits import_limits(const std::filesystem::path& path);

/// glTF, FBX or COLLADA by the given lower-case ending. Throws Error: bad_data that says what the file did (not
/// sound, reader ended by a signal, limit of time or memory), unavailable where there is no helper of this version.
MeshFile read_foreign(const std::filesystem::path& path, const std::string& ending, const ImportLimits& limits);

/// Where the helper is looked for, in order: what the environment's UMAX_IMPORT names; then beside the program, or
/// beside the shared library that holds this code, and in ../libexec/umax and ../../../../libexec/umax of either.
std::vector<std::filesystem::path> import_helper_places();

}  // namespace umax
