// Who may talk to a live session: loopback names, one-time tokens, a cookie.
//
// A page of another site cannot steer: its requests bear its own Origin, a name of its own that points to 127.0.0.1 (DNS
// rebinding) stands in Host, and neither it nor another user of the machine has the cookie, for which the address on the
// terminal is exchanged, once.
#pragma once

#include <string>
#include <string_view>

namespace umax {

struct Access {
  std::string token;   // that the next address has
  std::string cookie;  // its name: two sessions do not take each other's
  std::string secret;  // its value
};

/// 32 hexadecimal digits of the system's randomness. Throws Error (unavailable).
std::string random_word();

Access new_access();

/// Whether a Host header names this machine: "127.0.0.1:8123", "localhost".
bool is_local_host(std::string_view host);

/// Whether an Origin header is that of a page of ours at this Host.
bool is_own_origin(std::string_view origin, std::string_view host);

/// Whether a Cookie header holds the secret.
bool has_secret(const Access& access, std::string_view cookies);

/// Uses up the token: true once, for a target "/?token=…" that has it; then another one is made.
bool take_token(Access& access, std::string_view target);

/// The Set-Cookie header.
std::string cookie_of(const Access& access);

/// The Content-Security-Policy of every answer.
std::string content_policy(std::string_view host);

}  // namespace umax
