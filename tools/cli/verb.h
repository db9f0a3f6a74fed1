// The verbs of the program: one description of each, from which the command line, help, manual page and completion come.
#pragma once

#include <string>
#include <vector>

namespace umax {

struct Options;

/// What may stand where a verb's arguments stand, for completion.
struct Arguments {
  std::vector<std::string> (*words)() = nullptr;  // names that the program knows
  std::vector<std::string> endings = {};          // of files that it takes: "toml"; "*": any
  bool folders = false;                           // it takes folders
};

struct Verb {
  std::string name;                   // "run"
  std::string usage;                  // of its arguments: "SCENE"
  std::string summary;                // one line
  std::string details;                // paragraphs, an empty line between two
  std::vector<std::string> examples;  // whole commands
  Arguments arguments;
  std::vector<std::string> options;  // long names of those that it takes, beside --help and --version
  int (*run)(const Options&);        // returns the exit code; throws Error for what the user can mend
};

/// All, in the order in which help lists them.
const std::vector<Verb>& verbs();

/// Throws Error (usage) that names the nearest when there is none.
const Verb& find_verb(const std::string& name);

bool takes_option(const Verb& verb, const std::string& long_name);

}  // namespace umax
