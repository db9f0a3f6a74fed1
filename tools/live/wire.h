// What a browser draws, as bytes. Little-endian; what takes less than a number is padded to the next multiple of 4.
//
// A body, once: "UMXB", #V, #T, #E, #N (u32); of each hex its nodes (8 u32); of each vertex its hex (u32), its coordinates
// in it (3 u16 of 0 ... 1), red and green (2 u8), its normal at rest in these coordinates (3 i8), and blue (u8); triangles
// (3 u32). Colours are square roots of linear Rec. 709.
// Where nodes are, the vertex follows, x = sum_n N_n(s) x_n, and its normal by the gradient of that, J = dx/ds:
// n = cof(J) n_s. In it n_s = J_rest^T n_rest, so that at rest n = n_rest.
//
// An obstacle, once: "UMXO", #V, #T (u32), positions (3 f32), triangles (3 u32), in its own frame.
//
// A picture, every frame: FrameHeader; of each body the box of its nodes (low, extent: 6 f32), then their places in it
// (3 u16 of 0 ... 65535); of each hex U/U_max (u8, 200 is 1), stretch (u8, 255 is largest_stretch) and, where a limit
// holds, the multiplier (u8, logarithmic, 255 is largest_multiplier): energy of all, stretch of all, multiplier of all;
// contact points in the box of all bodies (3 u16); obstacles that may move: number (u32), turn (9 f32, by rows), place (3 f32).
#pragma once

#include <cstdint>
#include <string>

#include "tools/live/session.h"

namespace umax {

struct FrameHeader {
  std::uint8_t kind = 1, status = 0, flags = 0, num_bodies = 0;
  std::uint32_t number = 0;  // of the picture, which the browser sends back once it has been drawn
  std::uint32_t frame = 0, step = 0, first_kept = 0, last_kept = 0, steps_not_converged = 0;
  float time = 0;                                                // [s]
  float rate = 0;                                                // [-] of real time
  float step_ms = 0;                                             // [ms] that a step takes
  float max_ratio = 0, kinetic = 0, elastic = 0, potential = 0;  // [-], [J]
  float penetration = 0, residual = 0;                           // [m], [-]
  std::uint16_t limits_active = 0, contacts = 0, iterations = 0, retries = 0;
  float largest_stretch = 0, largest_multiplier = 0;
  float grab[3]{}, held[3]{};  // [m] where the spring pulls to, and the vertex that it holds
  std::uint16_t num_points = 0, num_moving = 0;
};
static_assert(sizeof(FrameHeader) == 108);

/// Of FrameHeader::flags.
enum FrameFlag : std::uint8_t {
  flag_plays = 1,
  flag_past = 2,
  flag_grabbed = 4,
  flag_behind = 8,
  flag_multipliers = 16
};

std::string encode_body(const Simulation& simulation, std::size_t body);
std::string encode_obstacle(const Simulation& simulation, std::size_t obstacle);

/// What the session knows of a picture beside the state.
struct FrameInfo {
  std::uint32_t number = 0, first_kept = 0, last_kept = 0;
  bool plays = false, is_past = false, is_behind = false;
  double rate = 0, step_ms = 0;  // [-], [ms]
};

/// Of a state of the session, with what its step told.
std::string encode_frame(const Session& session, const State& state, const StepReport& report, const FrameInfo& info);

/// For tests: the places of nodes that a picture's bytes hold, of all bodies [m].
Points decode_places(const std::string& frame, const Model& model);

}  // namespace umax
