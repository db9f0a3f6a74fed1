// The plots of a run: what steps.csv says, against simulated time.
#pragma once

#include <array>

namespace umax {

struct Scene;
class RunFolder;

inline constexpr std::array step_plot_names{"energies.svg", "max_energy_ratio.svg", "limits_active.svg", "contacts.svg",
                                            "wall_ms.svg"};

/// Draws the run's steps.csv, as far as it is whole, into its folder plots/: all files of step_plot_names, replacing
/// those that are there. Throws Error: bad_data when the table is another scene's, cannot_create or io_error when a
/// file cannot be written.
void write_step_plots(const RunFolder& folder, const Scene& scene);

}  // namespace umax
