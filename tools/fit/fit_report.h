// What a fit says: a table for the terminal, a scene snippet, a plot.
#pragma once

#include <string>

#include "tools/fit/material_fit.h"

namespace umax {

/// The values with their intervals, how well they fit, and what the data do not tell.
std::string fit_table(const Measurements& measurements, const MaterialFit& fit);

/// How every snippet begins.
inline constexpr const char* snippet_beginning = "# fitted to ";

/// TOML lines to go below a scene's [body.NAME]: material.young, material.poisson where the data tell it, limit.stretch
/// where they reach it; with the intervals as comments.
std::string fit_snippet(const Measurements& measurements, const MaterialFit& fit);

/// Stretch over nominal stress: data, simulated specimen and limit; below, residuals. SVG.
std::string fit_plot(const Measurements& measurements, const MaterialFit& fit);

}  // namespace umax
