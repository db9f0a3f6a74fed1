// Who works in a folder: a process, told apart from all others on all machines, and whether it is still alive.
//
// On its own machine a process is alive while its number and the time of its start stand in /proc. Of one on another
// machine (another host name, boot or container) only its heartbeat tells: it touches a file every few seconds, and once
// it has not done so for its lease it counts as gone.
#pragma once

#include <optional>
#include <string>

namespace umax {

struct Worker {
  std::string host;       // its name
  std::string boot;       // id that changes whenever the machine starts; empty: not known
  std::string processes;  // in which name space its number counts; empty: not known
  long long process = 0;  // its number
  long long start = 0;    // [clock ticks] after the machine's start; 0: not known
  double lease = 60;      // [s] without heartbeat after which others may take over
  std::string role;       // what it is here for, a word that the folder's users agree on
};

/// This process. The lease is 60 s, or what the environment's UMAX_LEASE says.
Worker this_worker(const std::string& role);

/// As lines "NAME VALUE", and back; none when a line is missing (half-written, or not ours).
std::string worker_text(const Worker& worker);
std::optional<Worker> parse_worker(const std::string& text);

/// age: [s] since its last heartbeat.
bool is_alive(const Worker& worker, double age);

/// "process 4711 on render07".
std::string describe(const Worker& worker);

}  // namespace umax
