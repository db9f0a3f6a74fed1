#include "tools/live/access.h"

#include <fmt/format.h>
#include <sys/random.h>

#include <algorithm>
#include <array>

#include "core/base/error.h"

namespace umax {
namespace {

constexpr std::string_view token_start = "/?token=";

/// In a time that does not depend on where they differ.
bool are_same(std::string_view a, std::string_view b) {
  unsigned difference = a.size() != b.size();
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    difference |= unsigned(static_cast<unsigned char>(a[i])) ^ unsigned(static_cast<unsigned char>(b[i]));
  return difference == 0;
}

std::string_view trimmed_of_spaces(std::string_view text) {
  while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
  while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
  return text;
}

}  // namespace

std::string random_word() {
  std::array<unsigned char, 16> bytes{};
  if (::getrandom(bytes.data(), bytes.size(), 0) != ssize_t(bytes.size()))
    throw Error(Fault::unavailable, {.where = "getrandom",
                                     .what = "the system gives no random numbers, which guard the session",
                                     .remedy = "try again"});
  std::string word;
  for (const unsigned char byte : bytes) word += fmt::format("{:02x}", byte);
  return word;
}

Access new_access() {
  return {.token = random_word(), .cookie = "umax_" + random_word().substr(0, 8), .secret = random_word()};
}

bool is_local_host(std::string_view host) {
  const std::size_t colon = host.rfind(':');
  if (colon != std::string_view::npos) {
    const std::string_view port = host.substr(colon + 1);
    if (port.empty() || port.size() > 5 ||
        !std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; }))
      return false;
    host = host.substr(0, colon);
  }
  return host == "127.0.0.1" || host == "localhost";
}

bool is_own_origin(std::string_view origin, std::string_view host) {
  return is_local_host(host) && origin == "http://" + std::string(host);
}

bool has_secret(const Access& access, std::string_view cookies) {
  while (!cookies.empty()) {
    const std::size_t end = std::min(cookies.find(';'), cookies.size());
    const std::string_view one = trimmed_of_spaces(cookies.substr(0, end));
    cookies.remove_prefix(std::min(end + 1, cookies.size()));
    if (one.starts_with(access.cookie + "=") && are_same(one.substr(access.cookie.size() + 1), access.secret))
      return true;
  }
  return false;
}

bool take_token(Access& access, std::string_view target) {
  if (!target.starts_with(token_start) || !are_same(target.substr(token_start.size()), access.token)) return false;
  access.token = random_word();
  return true;
}

std::string cookie_of(const Access& access) {
  return fmt::format("{}={}; HttpOnly; SameSite=Strict; Path=/", access.cookie, access.secret);
}

std::string content_policy(std::string_view host) {
  return fmt::format(
      "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self' ws://{}; img-src 'self' data:; "
      "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
      host);
}

}  // namespace umax
