// What Mesa's software driver takes from the environment, put right before the first context is made.
#pragma once

namespace umax::raster {

/// Removes settings that make llvmpipe crash and, when num_threads > 0, says how many threads it has. The first call of
/// the process counts.
void prepare_llvmpipe(int num_threads);

}  // namespace umax::raster
