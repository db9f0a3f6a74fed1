// The server of a live session: pages and meshes by HTTP, pictures and wishes by WebSocket, on the loopback interface.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "tools/live/live_loop.h"

namespace umax {

struct ServeOptions {
  int port = 0;  // 0: any that is free
  /// Called once the server listens, with the address that a browser opens; and with another one whenever that has been
  /// used.
  std::function<void(const std::string& address, bool is_first)> on_address = {};
  std::function<void(const std::string& line)> on_line = {};  // for the terminal
  std::function<bool()> ends = {};                            // asked several times a second
  double slower = 1;                                          // [-] than real time, at the start; 0: as fast as it goes
  int keep = 3600;                                            // frames, for the page
};

/// Serves the session until ends() says so. Throws Error: unavailable when the page's libraries are missing or the port
/// is taken, and what the session throws.
void serve(Session& session, Recording& recording, const ServeOptions& options);

/// The page's files by their names ("three.min.js"): ours, and the libraries read from Debian's folders or from that which
/// the environment's UMAX_THREE names. Throws Error (unavailable) with the remedy when one is not there.
std::map<std::string, std::string> page_files();

}  // namespace umax
