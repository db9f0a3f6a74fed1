#include <fmt/format.h>

#include "core/base/error.h"
#include "tools/cli/verbs.h"

namespace umax {

const std::vector<VerbHelp>& verbs() {
  static const std::vector<VerbHelp> all{
      {"run", "SCENE", "simulate, render, encode: the whole clip",
       "Simulates the scene, renders its frames and encodes DIR/clip.mp4. DIR/states, DIR/frames and DIR/steps.csv "
       "stay for\n"
       "later use by umax render, turntable and inspect.\n\n"
       "  umax run figure -o falling --size 640x360\n"
       "  umax run beam --set body.beam.limit.energy=0.1J --set clip.frames=60\n"},
      {"simulate", "SCENE", "states and steps.csv only",
       "Writes one state per frame and one row of steps.csv per time step, and draws the rows in DIR/plots. With\n"
       "--resume it goes on from the last whole state; the result is the same to the last bit as without the break.\n\n"
       "  umax simulate armadillo --set body.armadillo.mesh=armadillo.obj --frames 1-100\n"},
      {"render", "DIR", "frames (and clip) from the states in DIR",
       "Renders the frames whose states are in the run's folder, and encodes the clip. With -o the pictures go into "
       "another\n"
       "folder.\n\n"
       "  umax render falling --overwrite --engine osmesa --set render.heatmap=energy\n"},
      {"turntable", "MESH|SCENE|DIR", "camera circles a still or a chosen frame",
       "Circles a mesh, a scene's first instant, or one frame of a run once around. clip.frames is the number of "
       "pictures.\n\n"
       "  umax turntable bunny.ply --height \"20 cm\"\n"
       "  umax turntable falling --still 60\n"},
      {"strip", "DIR…", "one picture of several instants or runs",
       "Puts the bodies of several runs, or of several frames of a run, side by side on one ground into one picture, "
       "with\n"
       "the first run's camera direction, lights and heat map. Without --frames, the last frame of each.\n\n"
       "  umax strip falling --frames 30,50,70,120 -o falling.png --size 1280x440\n"
       "  umax strip soft stiff --frames 60 --label soft --label stiff --set render.heatmap=stretch\n"},
      {"drop", "MESH", "no scene file: voxelise, drop on the ground, run",
       "Puts the mesh into a cage of hexes, drops it on the ground from half its height, renders and encodes. "
       "Stiffness goes\n"
       "with the size, so that a large and a small body sag by the same share of their height.\n\n"
       "  umax drop bunny.ply --height \"20 cm\" --stretch 10%\n"},
      {"inspect", "MESH|SCENE|DIR", "sizes, cage, mass, limits, problems",
       "Tells what a mesh, a scene or a run is, and what is wrong with it. Exit code 65 if it cannot be used. With "
       "--map it\n"
       "draws the factors of limit.map or material.young_map on the surface, from the front and from the back.\n\n"
       "  umax inspect bunny.ply --json\n"
       "  umax inspect figure --set body.figure.limit.map=mesh --map limit -o paint.png\n"},
      {"scenes", "", "lists the built-in scenes", "One line each: name, then a description.\n"},
      {"presets", "[NAME…]", "lists the materials that scenes can name",
       "One line each: name, then a description. With names it prints their keys, ready for a scene's [body.NAME], "
       "and\n"
       "where the numbers come from. --set presets=FILE adds a file of your own.\n\n"
       "  umax presets rubber\n"
       "  umax run figure --set body.figure.material.preset=gel\n"},
      {"reproduce", "[NAME…]", "the paper's figures and tables",
       "Runs the experiments of the paper that the program implements and writes DIR/index.html, a page that shows "
       "what\n"
       "came out beside what the paper prints, DIR/report.csv with all numbers, and the pictures. NAME is one of\n"
       "figure1, figure3, figure4, figure5, figure6, performance, convergence, corrections; without a name, all of\n"
       "them. With --resume a report that was stopped goes on, and further experiments join its page.\n\n"
       "  umax reproduce figure3 --quick\n"
       "  umax reproduce --set body.armadillo.mesh=armadillo.obj\n"},
      {"tune", "SCENE", "variants of a scene side by side",
       "Runs the scene once for every combination of the values that --vary lists, several at a time as cores and "
       "memory\n"
       "allow, and writes DIR/tune.html, a page with all variants in step under one scrubber, their plots and values, "
       "and\n"
       "lines to copy into the scene; DIR/sheet.png, the moment at which they are stretched most; and "
       "DIR/variants.mp4.\n"
       "Each variant is a run of its own in DIR/runs. The page opens from the disk in any browser.\n\n"
       "Without --final it is a preview: small rasterised pictures, cages of 400 hexes at most; what it changes is "
       "said,\n"
       "and never what you set or vary. A variant that fails does not end the others; the exit code is then its own. "
       "With\n"
       "--resume only what is missing is made. --presets compares all materials (umax presets), without a SCENE on "
       "the\n"
       "scene materials. The plots need libjs-chart.js; the environment's UMAX_JAVASCRIPT may name another folder of "
       "it.\n\n"
       "  umax tune figure --vary body.figure.limit.stretch=5%,10%,15%,40%\n"
       "  umax tune figure --vary body.figure.limit.stretch=5%,20% --vary body.figure.material.young=\"50 kPa,200 "
       "kPa\"\n"
       "  umax tune --presets\n"},
      {"fit", "MEASUREMENTS.csv", "material and limit from force-deformation data",
       "Simulates the test that was measured on hexes and adjusts Young's modulus, the limit and, where the data tell "
       "it,\n"
       "Poisson's ratio until the stretches at the measured forces fit. Writes DIR/material.toml, lines for a scene, "
       "and\n"
       "DIR/fit.svg with data, simulated test and residuals.\n\n"
       "The file has comma-separated columns with a header: stretch [%] (change of length over length), stretch ratio\n"
       "(length over length) or displacement [mm]; force [N] or stress [kPa] (over the section at rest); lateral "
       "stretch\n"
       "[%] or lateral stretch ratio, if measured, tell Poisson's ratio. Lines that begin with # are comments.\n\n"
       "  umax fit silicone.csv --length \"50 mm\" --area \"24 mm^2\"\n"
       "  umax fit pads.csv --test shear --length \"4 mm\" --area \"10 cm^2\" --poisson 0.49\n"},
      {"compare", "A B", "image difference: mean FLIP, maximum, percentage",
       "Compares two pictures, or the pictures of the same names in two folders. Exit code 0: the mean FLIP is within\n"
       "--max-flip; 1: it is not; 2 or more: the comparison failed.\n\n"
       "  umax compare reference.png frames/0060.png --max-flip 0.05\n"},
      {"help", "[VERB]", "this text, or a verb's options", "Tells what the program or one of its verbs does.\n"},
  };
  return all;
}

int verb_help(const Options& options) {
  if (options.inputs.size() > 1) throw Error(Fault::usage, {"", "umax help takes one verb", "", "see umax help"});
  fmt::print("{}", help_text(options.inputs.empty() ? "" : options.inputs.front()));
  return 0;
}

}  // namespace umax
