// What pages that carry everything in themselves are made of.
#pragma once

#include <string>
#include <string_view>

namespace umax {

/// Text as it may stand between tags and in attributes.
std::string html_text(std::string_view text);

/// Bytes as letters, digits, + and /.
std::string base64(std::string_view bytes);

/// The src of an <img> that has the file's bytes in itself.
std::string png_data_url(std::string_view png);
std::string svg_data_url(std::string_view svg);

}  // namespace umax
