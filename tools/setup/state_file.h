// State files: one instant of a run, exact to the last bit, so that a run can go on from it.
//
// Little-endian: "UMAXSTAT", version (u32), 0 (u32), model digest (64 characters), the state, and the SHA-256 of all
// that stands before (64 characters).
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "core/step/step.h"
#include "tools/setup/model_digest.h"

namespace umax {

std::string encode_state(const State& state, const Digest& model);

/// The state in `bytes`. Throws Error (bad_data) that names `where`: not a state, another version, truncated, damaged.
/// `model` receives the digest of the model that the state was made with.
State decode_state(std::string_view bytes, const std::string& where, Digest& model);

/// Puts the state at `path`, whole or not at all.
void write_state(const std::filesystem::path& path, const State& state, const Digest& model);

/// Throws Error (bad_data) unless a state read from `path`, made with the model `made_with`, belongs to this model.
void require_state_of(const Model& model, const Digest& digest, const std::filesystem::path& path, const State& state,
                      const Digest& made_with);

/// Reads a state and makes sure that it belongs to the model. Throws Error (bad_data, not_found, io_error).
State read_state(const std::filesystem::path& path, const Model& model, const Digest& digest);

}  // namespace umax
