// The verbs of the program. Each returns the exit code and throws Error for what the user can mend.
#pragma once

#include "tools/run/options.h"

namespace umax {

int verb_run(const Options& options);
int verb_simulate(const Options& options);
int verb_render(const Options& options);
int verb_turntable(const Options& options);
int verb_strip(const Options& options);
int verb_drop(const Options& options);
int verb_inspect(const Options& options);
int verb_scenes(const Options& options);
int verb_presets(const Options& options);
int verb_reproduce(const Options& options);
int verb_tune(const Options& options);
int verb_fit(const Options& options);
int verb_compare(const Options& options);
int verb_help(const Options& options);

}  // namespace umax
