// How much memory there is, and how many processors: what the machine can give, and what the user says.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

namespace umax {

/// [bytes] that this machine can give, without swap; no more than the cgroups (version 2) that we are in leave. root:
/// where the system's files are.
long long available_memory(const std::filesystem::path& root = "/");

/// Processors that this process may run on; no more than their time that the cgroups (version 2) that we are in leave.
double allowed_processors(const std::filesystem::path& root = "/");

/// "8G", "500M", "1.5 GiB", "1000000" -> bytes; K, M, G and T are powers of 1024. Nothing where that is no positive
/// size.
std::optional<long long> parse_memory(const std::string& text);

/// From now on memory that is freed stays with the process. Solvers free and allocate the same vectors at each
/// iteration: giving their pages back to the system, to be cleared again, took a twentieth of a step on 100,000 hexes.
void keep_freed_memory();

/// Memory that has been freed goes back to the system.
void give_back_freed_memory();

/// "1.2 GiB", "350 MiB"
std::string format_memory(double bytes);

}  // namespace umax
