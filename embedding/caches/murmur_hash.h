// MurmurHash3 of 128 bits for 64-bit machines (A. Appleby, public domain), seed 0: the key of an Alembic sample.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace umax {

using Hash128 = std::array<std::uint64_t, 2>;

Hash128 murmur_hash(std::string_view bytes);

}  // namespace umax
