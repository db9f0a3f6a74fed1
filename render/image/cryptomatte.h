// Mattes that a compositor takes by name: Cryptomatte 1.2.                                                       [FJ15]
// A name's number is its MurmurHash3 as the bits of a float, kept clear of infinities, denormals and not-a-number. Pixels
// hold pairs of such a number and the share of the pixel that it has, in layers of two pairs each.
// [FJ15] J. Friedman, A. Jones: Fully automatic ID mattes with support for motion blur and transparency, SIGGRAPH 2015.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "render/image/image_io.h"

namespace umax {

/// MurmurHash3_x86_32 of the bytes, seed 0.
std::uint32_t murmur_hash_32(std::string_view bytes);

/// The bits of a name's number.
std::uint32_t cryptomatte_bits(std::string_view name);
float cryptomatte_number(std::string_view name);

/// What the header says of the layers `name`00, `name`01, …: which names have which numbers.
ExrTexts cryptomatte_texts(const std::string& name, const std::vector<std::string>& names);

/// The layers of a picture of pairs; 2 n channels, n even.
std::vector<Layer> cryptomatte_layers(const std::string& name, const Image& pairs);

}  // namespace umax
