// The sizes that an OpenEXR file promises in its headers, against the bytes that are there.
#pragma once

#include <string>
#include <string_view>

namespace umax::codec {

/// Walks through the headers as the library would and says at which size, count or length the file promises more than it
/// can hold; empty: at none. The library believes them all, and takes the memory before it looks at the pixels.
std::string broken_exr_promise(std::string_view bytes);

}  // namespace umax::codec
