// Recorded pulls: what a live session pulled bodies by, step by step, so that it can be simulated again.
//
// Little-endian: "UMAXPULL", version (u32), 0 (u32), their number (u64); of each the step that it acts in (i64, from 0),
// its body's number in the model and the hex of that (i32, i32), 8 weights, stiffness [N/m] and place [m] (f64); and the
// SHA-256 of all that stands before (64 characters).
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/model/model.h"
#include "core/problem/step_options.h"

namespace umax {

using RecordedPulls = std::map<long long, std::vector<Pull>>;  // by the number of steps that were done before

std::string encode_pulls(const RecordedPulls& pulls, const Model& model);

/// The pulls in `bytes`. Throws Error (bad_data) that names `where`: no such file, another version, damaged, or of another
/// model.
RecordedPulls decode_pulls(std::string_view bytes, const std::string& where, const Model& model);

}  // namespace umax
