// Two versions of the program side by side: the same scenes, in turns, so that both meet the same machine.
#pragma once

#include <string>

namespace umax {

/// Which rows of tools/bench --against are made.
struct AgainstOptions {
  std::string old_program;  // path of the other umax
  std::string only;         // the row of this name alone; empty: all
  bool full = false;        // long rows, too
  int turns = 0;            // that each row has; 0: as many as its length allows
};

/// Prints a line for each row: how much longer this program takes than the other one. Returns how many missed their target.
/// Throws Error (not_found) where there is no such program or row.
int bench_against(const AgainstOptions& options);

}  // namespace umax
