// What a live session's server answers to a request: which files it gives to whom. Knows nothing of sockets.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include "tools/live/access.h"
#include "tools/setup/simulation_setup.h"

namespace umax {

/// A request's method ("GET"), target ("/page.js") and headers; empty: there is none.
struct Asked {
  std::string_view method, target, host, origin, cookies;
};

struct Answer {
  int status = 200;  // of HTTP
  std::string body, type = "text/plain; charset=utf-8";
  std::string set_cookie = {};  // header, or empty
  bool is_admission = false;    // the token has been exchanged for the cookie: another address is to be told
};

/// files: by their names, as page_files() has them; the simulation's meshes are made when they are asked for. Uses up the
/// token that the target has.
Answer answer_to(const Asked& asked, const std::map<std::string, std::string>& files, const Simulation& simulation,
                 Access& access);

/// Whether who asks may watch over a WebSocket.
bool may_watch(const Asked& asked, const Access& access);

}  // namespace umax
