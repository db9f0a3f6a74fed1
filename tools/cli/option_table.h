// The options of the program, each defined once. Which verb takes which, the verbs say (verb.h).
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "tools/cli/options.h"

namespace umax {

/// Where an option's value goes. A bool has none: it stands on the line or not.
using OptionTarget = std::variant<bool Options::*, std::optional<std::string> Options::*, std::optional<int> Options::*,
                                  std::optional<long long> Options::*, std::optional<double> Options::*,
                                  std::vector<std::string> Options::*>;

struct OptionRange {
  double least = 0, largest = 0;
};

struct OptionDefinition {
  std::string name;                        // "--output"
  std::string short_name = {};             // "-o"
  std::string value = {};                  // "DIR"; empty: a flag
  std::string description;                 // after the name, in help
  OptionTarget target;                     // a list: may be given again and again
  std::vector<std::string> choices = {};   // the only values
  std::vector<std::string> examples = {};  // values that completion offers among others
  std::optional<OptionRange> range = {};   // of numbers
  /// What is wrong with a value, or nothing.
  std::string (*check)(const std::string& text) = nullptr;
  bool is_path = false;  // of a file or folder
};

/// All, in the order of help.
const std::vector<OptionDefinition>& option_table();

/// "-o,--output DIR"
std::string usage(const OptionDefinition& option);

}  // namespace umax
