// What the command line asks for, verb by verb.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tools/run/run_folder.h"
#include "tools/system/progress.h"

namespace umax {

struct Options {
  std::string verb;
  std::vector<std::string> inputs;  // what follows the verb
  bool help = false, version = false;

  std::optional<std::string> output;  // -o
  std::vector<std::string> settings;  // --set key=value
  std::optional<std::string> frames;  // --frames "1-40,50"
  std::vector<std::string> labels;    // --label TEXT: strip, one for each thing in it
  std::optional<int> still;           // --still: the frame that turntable circles
  std::optional<int> threads;
  std::optional<std::string> memory;  // "8G": parse_memory() reads it
  bool resume = false, overwrite = false, strict = false, quiet = false, verbose = false, quick = false, json = false;
  ProgressMode progress = ProgressMode::automatic;

  std::optional<std::string> engine;  // "embree" | "osmesa"
  std::optional<int> samples;
  std::optional<std::string> size;  // "1280x720"
  std::optional<long long> seed;

  std::optional<std::string> map;  // inspect: "limit" | "young"

  std::optional<std::string> height;  // "1.8 m": drop, turntable, inspect: of the mesh
  std::optional<std::string> unit;    // "cm", or metres as a number
  std::optional<std::string> up;      // "x" | "y" | "z"
  std::optional<int> cells;
  std::optional<std::string> stretch;  // "20%"

  std::vector<std::string> variations;  // tune: --vary key=a,b,c
  bool final = false, presets = false;  // tune: not only a preview; every preset

  std::optional<std::string> test;    // fit: "uniaxial" | "compression" | "shear"
  std::optional<std::string> length;  // fit: "50 mm", of the specimen
  std::optional<std::string> area;    // fit: "25 mm^2"
  std::optional<double> poisson;      // fit: where the data do not tell it

  std::optional<std::string> report;  // compare: a page to write
  std::optional<double> max_flip;     // compare

  ExistingFolder existing_folder() const {
    return overwrite ? ExistingFolder::overwrite : resume ? ExistingFolder::keep : ExistingFolder::refuse;
  }
};

struct VerbHelp {
  const char* name;
  const char* arguments;
  const char* summary;  // one line
  const char* details;  // paragraphs
};
const std::vector<VerbHelp>& verbs();

/// Throws Error (usage): unknown verb or option (naming the nearest), a value that does not fit, an option that the
/// verb does not take.
Options parse_command_line(int argc, const char* const* argv);

/// "umax help" (verb empty) and "umax help VERB".
std::string help_text(const std::string& verb);

}  // namespace umax
