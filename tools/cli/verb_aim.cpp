#include "tools/aim/aiming.h"
#include "tools/cli/options.h"
#include "tools/cli/run_input.h"
#include "tools/cli/verb.h"
#include "tools/system/signals.h"
#include "tools/system/threads.h"

namespace umax {
namespace {

int aim(const Options& options) {
  const ThreadLimit threads(options.threads);
  Progress progress(stdout, progress_mode(options), options.quiet);
  const AimPlan plan = plan_aim({.scene = single_input(options, "scene"),
                                 .settings = scene_overrides(options),
                                 .wants = options.wants,
                                 .ranges = options.variations});
  const AimFolder folder(output_folder(options, plan.scene.name + "-aim"), existing_folder(options));
  const SignalWatch watch;
  return do_aim(plan, folder, {.threads = threads.count(), .memory = memory_limit(options), .strict = options.strict},
                progress);
}

}  // namespace

Verb aim_verb() {
  return {.name = "aim",
          .usage = "SCENE",
          .summary = "finds the value that gives a wanted shape",
          .details =
              "Varies keys of the scene in their ranges until what is wanted comes out to 1 %. It says each run: the "
              "value of the key, what came out, what is left. One key takes at most 10 runs, two 20, three 30. Of the "
              "clip as much is simulated as the wants need.\n\nA want is [min|max] MEASURE(BODY) [at TIME | from TIME "
              "to TIME] = VALUE. Measures: height, width, length(BODY, AXIS), tip(PROBE, AXIS), squash, stretch, and "
              "of the whole clip rest and bounce. A percentage of height, width or length is of what it is as placed, "
              "of bounce of the fall; a value with a unit (12 cm) is itself. Up to three wants and three keys; "
              "ranges are walked by equal factors where both ends are positive and one is ten times the "
              "other.\n\nDIR/aim.html shows the runs with a plot, the body before and after, lines to copy into the "
              "scene and the command that runs it; DIR/lines.toml, DIR/before-after.png and DIR/aim.json are the same "
              "for scripts. Where a want is not reached it says why (out of range, not monotone, a jump), shows the "
              "nearest, and the exit code is 3. With --resume runs that are there are not made again.",
          .examples = {"umax aim figure --want 'height(figure) at 0.8 s = 85 %' --vary "
                       "body.figure.limit.stretch=2%..60%",
                       "umax aim beam --want 'min tip(tip, y) = -30 cm' --vary body.beam.limit.energy=0.01J..1J",
                       "umax aim bowl.toml --want 'max stretch(ball) = 12 %' --want 'rest(ball) = 2 s' --vary "
                       "\"body.ball.material.young=20 kPa..500 kPa\" --vary body.ball.material.damping_mass=0..4"},
          .arguments = {.words = scene_names, .endings = {"toml"}},
          .options = {"--output",  "--set",    "--resume",  "--overwrite", "--deadline", "--strict", "--allow-overlap",
                      "--quick",   "--engine", "--samples", "--size",      "--seed",     "--vary",   "--want",
                      "--threads", "--isa",    "--memory",  "--progress",  "--quiet",    "--verbose"},
          .run = aim};
}

}  // namespace umax
