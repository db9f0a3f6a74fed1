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

/// Replaces {{mark}} of a template, which stands there once.
void fill_in(std::string& page, const std::string& mark, const std::string& text);

/// All occurrences.
void replace_all(std::string& text, const std::string& what, const std::string& with);

/// JSON as it may stand in a <script>, which no text in it may end.
std::string json_in_script(std::string json);

/// What pages of the program look like: colours, letters, tables, buttons.
std::string page_style();

}  // namespace umax
