// What identifies the model that states belong to.
#pragma once

#include <cstdint>
#include <string>

#include "core/model/model.h"
#include "core/step/step.h"

namespace umax {

using Digest = std::string;  // SHA-256, 64 hexadecimal digits

/// Of state files; a part of the digest.
inline constexpr std::uint32_t state_format = 4;

/// The digest with keys of gravity (clip.gravity); as it is where gravity is constant.
Digest with_gravity_keys(const Digest& digest, const Track<Vector3d>& gravity);

/// Identifies what a state belongs to: everything that decides the next step's bits (model, time step, solver).
Digest model_digest(const Model& model, const StepOptions& options);

}  // namespace umax
