// A mesh file as it was read, as bytes: how the helper program that reads foreign formats hands over what it found.
#pragma once

#include <functional>
#include <optional>
#include <string_view>

#include "core/base/error.h"
#include "embedding/mesh_record/mesh_file.h"

namespace umax {

/// Changes with the layout: both sides must be of one version.
constexpr int mesh_record_version = 1;

/// The helper's exit codes, beside 0 for a whole record.
enum ImportExit : int { import_other_version = 64, import_out_of_memory = 71, import_not_written = 74 };

/// Takes the next bytes of a record.
using PutBytes = std::function<void(std::string_view)>;

void put_mesh_record(const MeshFile& file, const PutBytes& put);

/// Why there is no mesh. Where it was is for the other side to say.
void put_error_record(const Error& error, const PutBytes& put);

/// The mesh, or nothing where the bytes are no whole record, whatever they are. Throws the Error that was put, with
/// `where` in the place of its own.
std::optional<MeshFile> read_mesh_record(std::string_view bytes, const std::string& where);

}  // namespace umax
