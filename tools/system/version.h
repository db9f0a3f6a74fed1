// Which version of the program this is.
#pragma once

#include <optional>
#include <string>

namespace umax {

/// "0.1.0".
std::string version_text();

/// Several lines: version, commit, compiler, instruction set, libraries.
std::string version_report();

/// "avx512 with OpenBLAS 0.3.21 (SkylakeX)": what decides the last bits of states on this machine.
std::string instruction_set_text();

/// Has kernels and OpenBLAS use that instruction set ("avx2") or, where it is not given, the one that the environment's
/// UMAX_ISA names; "best" leaves the choice to them. OpenBLAS listens only when it is loaded: the program is then started
/// again, as `argv` says. Throws Error: usage, unavailable.
void pin_instruction_set(const std::optional<std::string>& isa, char** argv);

}  // namespace umax
