#include "tools/pages/html.h"

#include <cstddef>
#include <utility>

namespace umax {

// Written by CMake into the build folder from style.css.
extern const std::pair<const char*, const char*> embedded_page_style[];

std::string base64(std::string_view bytes) {
  constexpr char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) {
      return k < bytes.size() ? unsigned(static_cast<unsigned char>(bytes[k])) : 0u;
    };
    const unsigned three = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    text += letters[three >> 18 & 63];
    text += letters[three >> 12 & 63];
    text += i + 1 < bytes.size() ? letters[three >> 6 & 63] : '=';
    text += i + 2 < bytes.size() ? letters[three & 63] : '=';
  }
  return text;
}

std::string html_text(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string png_data_url(std::string_view png) {
  return "data:image/png;base64," + base64(png);
}

std::string svg_data_url(std::string_view svg) {
  return "data:image/svg+xml;base64," + base64(svg);
}

void fill_in(std::string& page, const std::string& mark, const std::string& text) {
  page.replace(page.find("{{" + mark + "}}"), mark.size() + 4, text);
}

void replace_all(std::string& text, const std::string& what, const std::string& with) {
  for (std::size_t at = 0; (at = text.find(what, at)) != std::string::npos; at += with.size())
    text.replace(at, what.size(), with);
}

std::string json_in_script(std::string json) {
  replace_all(json, "<", "\\u003c");
  return json;
}

std::string page_style() {
  return embedded_page_style[0].second;
}

}  // namespace umax
