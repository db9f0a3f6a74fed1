#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>
#include <string_view>

#include "core/base/error.h"
#include "core/base/nearest_word.h"
#include "tools/run/options.h"
#include "tools/system/machine_memory.h"

namespace umax {
namespace {

constexpr std::string_view everywhere =
    "run simulate render turntable strip drop inspect scenes presets reproduce tune fit compare help";
constexpr std::string_view not_built[] = {"export"};

/// An option with the verbs that take it and what help says of it.
struct OptionEntry {
  const CLI::Option* option;
  std::string usage;       // "-o DIR"
  std::string_view verbs;  // separated by spaces
  std::string description;
};

bool contains_word(std::string_view words, std::string_view word) {
  while (!words.empty()) {
    const std::size_t end = std::min(words.find(' '), words.size());
    if (words.substr(0, end) == word) return true;
    words.remove_prefix(std::min(end + 1, words.size()));
  }
  return false;
}

[[noreturn]] void usage_error(const std::string& what, const std::string& remedy) {
  throw Error(Fault::usage, {"", what, "", remedy});
}

/// Checker of CLI11: what is wrong with the text, or nothing.
std::string is_size(const std::string& text) {
  int width = 0, height = 0, end = 0;
  const int found = std::sscanf(text.c_str(), "%dx%d%n", &width, &height, &end);
  if (found == 2 && std::size_t(end) == text.size() && width > 0 && height > 0) return "";
  return "\"" + text + "\" is no size; write it as 1280x720";
}

/// Likewise.
std::string is_memory(const std::string& text) {
  if (parse_memory(text)) return "";
  return "\"" + text + "\" is no size of memory; write it as 8G, 500M or a number of bytes";
}

/// The grammar: one set of options for all verbs, so that they may stand anywhere on the line.
class Grammar {
 public:
  explicit Grammar(Options& options) : app_("umax") {
    app_.set_help_flag("");
    app_.allow_extras();
    app_.add_option("words", words_);
    add_run_options(options);
    add_picture_options(options);
    add_mesh_options(options);
    add_tune_options(options);
    add_fit_options(options);
    add_general_options(options);
  }

  void parse(int argc, const char* const* argv, Options& options) {
    try {
      app_.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      usage_error(error.what(), "see umax help");
    }
    if (!words_.empty()) options.verb = words_.front();
    if (words_.size() > 1) options.inputs.assign(words_.begin() + 1, words_.end());
    for (const std::string& extra : app_.remaining()) refuse_unknown(extra);
  }

  /// Throws for an option on the line that the verb does not take.
  void check_fit(const std::string& verb) const {
    for (const OptionEntry& entry : entries_)
      if (entry.option->count() > 0 && !contains_word(entry.verbs, verb))
        usage_error(entry.option->get_name(false, true) + " does not go with umax " + verb, "see umax help " + verb);
  }

  std::string describe(const std::string& verb) const {
    std::string text;
    for (const OptionEntry& entry : entries_) {
      if (!contains_word(entry.verbs, verb)) continue;
      std::string line = "  " + entry.usage;
      line += line.size() < 26 ? std::string(26 - line.size(), ' ') : "\n" + std::string(26, ' ');
      text += line + entry.description + "\n";
    }
    return text;
  }

 private:
  template <class T>
  CLI::Option* add(const std::string& name, const std::string& value, T& target, std::string_view verbs,
                   const std::string& description) {
    CLI::Option* option = app_.add_option(name, target);
    entries_.push_back({option, name + (value.empty() ? "" : " " + value), verbs, description});
    return option;
  }
  void add_flag(const std::string& name, bool& target, std::string_view verbs, const std::string& description) {
    entries_.push_back({app_.add_flag(name, target), name, verbs, description});
  }

  void add_run_options(Options& o) {
    constexpr std::string_view runs = "run simulate render turntable strip drop", steps = "run simulate drop tune";
    constexpr std::string_view folders = "run simulate render turntable drop reproduce tune";
    add("-o,--output", "DIR", o.output, "run simulate render turntable strip drop inspect reproduce tune fit",
        "the folder of the run (default: ./NAME, the scene's or mesh's name; reproduce: ./report; tune, fit: "
        "./NAME-tune, ./NAME-fit); strip, inspect --map: the picture (./strip.png, ./NAME-limit-map.png)");
    add("--set", "KEY=VALUE", o.settings, "run simulate render turntable strip drop inspect presets reproduce tune",
        "set any key of the scene, as in --set body.figure.limit.stretch=15%; repeatable")
        ->allow_extra_args(false);
    add("--frames", "LIST", o.frames, runs, "only these frames, as in 1-40,50,60-90x2");
    add_flag("--resume", o.resume, folders, "go on with the folder's run where it stopped");
    add_flag("--overwrite", o.overwrite, "run simulate render turntable strip drop inspect reproduce tune fit",
             "replace the run that the folder holds; strip, inspect --map: the picture");
    add_flag("--strict", o.strict, steps, "end with exit code 75 when a step does not converge");
    add_flag("--quick", o.quick, "run render turntable strip drop reproduce",
             "few samples and small pictures, for a first look");
  }

  void add_picture_options(Options& o) {
    constexpr std::string_view pictures = "run render turntable strip drop tune";
    add("--engine", "ENGINE", o.engine, pictures, "embree (path tracer) or osmesa (rasteriser)")
        ->check(CLI::IsMember({"embree", "osmesa"}));
    add("--samples", "N", o.samples, "run render turntable strip drop reproduce tune",
        "paths per pixel of the path tracer")
        ->check(CLI::Range(1, 1'000'000));
    add("--size", "WxH", o.size, pictures, "size of the pictures in pixels, as in 1280x720")->check(is_size, "WxH");
    add("--seed", "N", o.seed, pictures, "seed of the path tracer's noise")->check(CLI::Range(0LL, 4294967295LL));
    add("--label", "TEXT", o.labels, "strip", "words below a thing in the strip; once for each, from left to right")
        ->allow_extra_args(false);
    add("--still", "FRAME", o.still, "turntable", "the frame of the run that is circled (default: the last)")
        ->check(CLI::PositiveNumber);
  }

  void add_mesh_options(Options& o) {
    constexpr std::string_view meshes = "drop inspect turntable";
    add("--height", "LENGTH", o.height, meshes, "make the mesh this tall, as in 1.8 or \"30 cm\"");
    add("--unit", "UNIT", o.unit, meshes, "length of the mesh file's unit: mm, cm, m, in, ft, or metres as a number");
    add("--up", "AXIS", o.up, meshes, "axis that points up in the mesh file: x, y, z, -x, -y or -z");
    add("--cells", "N", o.cells, "drop inspect", "number of hexes that the cage should have (default: 365)");
    add("--stretch", "PERCENT", o.stretch, "drop", "most that any hex may stretch (default: 20%)");
    add("--max-flip", "X", o.max_flip, "compare", "largest mean FLIP that passes (default: 0.02)")
        ->check(CLI::Range(0.0, 1.0));
    add("--report", "FILE", o.report, "compare", "write an HTML page with both pictures and their difference");
    add_flag("--json", o.json, "inspect", "print one JSON object");
    add("--map", "limit|young", o.map, "inspect",
        "draw the factors on the limit or on Young's modulus, as maps and files of hexes give them")
        ->check(CLI::IsMember({"limit", "young"}));
  }

  void add_tune_options(Options& o) {
    add("--vary", "KEY=A,B,C", o.variations, "tune",
        "run the scene once for each value; repeatable: every combination; as in "
        "--vary body.figure.limit.stretch=5%,10%,20%")
        ->allow_extra_args(false);
    add_flag("--presets", o.presets, "tune", "vary material.preset over all presets (umax presets)");
    add_flag("--final", o.final, "tune", "the scene as it is, not a preview of it");
  }

  void add_fit_options(Options& o) {
    add("--test", "KIND", o.test, "fit", "uniaxial (default), compression or shear")
        ->check(CLI::IsMember({"uniaxial", "compression", "shear"}));
    add("--length", "LENGTH", o.length, "fit",
        "of the specimen at rest, for displacements, as in \"50 mm\"; shear: height of the sheared layer");
    add("--area", "AREA", o.area, "fit",
        "of the specimen's section at rest, for forces, as in \"25 mm^2\"; shear: of the sheared layer");
    add("--poisson", "NU", o.poisson, "fit", "Poisson's ratio where the data do not tell it (default: 0.3)")
        ->check(CLI::Range(-0.99, 0.4999));
  }

  void add_general_options(Options& o) {
    constexpr std::string_view workers = "run simulate render turntable strip drop reproduce tune inspect compare";
    static const std::map<std::string, ProgressMode> modes{
        {"auto", ProgressMode::automatic}, {"plain", ProgressMode::plain}, {"json", ProgressMode::json}};
    add("--threads", "N", o.threads, workers, "number of threads (default: all cores); results do not depend on it")
        ->check(CLI::Range(1, 1024));
    add("--memory", "SIZE", o.memory, "run simulate drop reproduce tune",
        "memory that a simulation may take, as in 8G or 500M (default: what the machine has to give); what would need "
        "more is refused before it starts")
        ->check(is_memory, "SIZE");
    CLI::Option* progress = app_.add_option("--progress", o.progress)->transform(CLI::CheckedTransformer(modes));
    entries_.push_back({progress, "--progress MODE", "run simulate render turntable drop reproduce tune",
                        "auto (a bar on a terminal), plain (a line per frame) or json"});
    add_flag("--quiet", o.quiet, "run simulate render turntable strip drop reproduce tune inspect fit compare",
             "say nothing but warnings and errors");
    add_flag("--verbose", o.verbose, workers, "say more; simulate prints a line per iteration");
    entries_.push_back({app_.add_flag("-h,--help", o.help), "-h, --help", everywhere, "this text"});
    entries_.push_back({app_.add_flag("--version", o.version), "--version", everywhere, "the program's version"});
  }

  [[noreturn]] void refuse_unknown(const std::string& extra) const {
    std::vector<std::string> known;
    for (const OptionEntry& entry : entries_)
      for (const std::string& name : entry.option->get_lnames()) known.push_back("--" + name);
    const std::string word = extra.substr(0, extra.find('='));
    usage_error("unknown option " + word, "did you mean " + nearest_word(word, known) + "? See umax help");
  }

  CLI::App app_;
  std::vector<std::string> words_;
  std::vector<OptionEntry> entries_;
};

const VerbHelp* find_verb(const std::string& name) {
  for (const VerbHelp& verb : verbs())
    if (name == verb.name) return &verb;
  return nullptr;
}

[[noreturn]] void refuse_verb(const std::string& name) {
  if (std::find(std::begin(not_built), std::end(not_built), name) != std::end(not_built))
    usage_error("umax " + name + ": not in this version", "see umax help for what there is");
  std::vector<std::string> known;
  for (const VerbHelp& verb : verbs()) known.emplace_back(verb.name);
  usage_error("unknown verb \"" + name + "\"", "did you mean umax " + nearest_word(name, known) + "? See umax help");
}

}  // namespace

Options parse_command_line(int argc, const char* const* argv) {
  Options options;
  Grammar grammar(options);
  grammar.parse(argc, argv, options);
  if (options.verb.empty()) {
    if (!options.help && !options.version) usage_error("no verb is given", "try umax help, or umax run figure");
    options.verb = "help";
    return options;
  }
  if (find_verb(options.verb) == nullptr) refuse_verb(options.verb);
  grammar.check_fit(options.verb);
  if (options.resume && options.overwrite)
    usage_error("--resume and --overwrite exclude each other", "give one of them");
  return options;
}

std::string help_text(const std::string& name) {
  Options options;
  const Grammar grammar(options);
  std::string text;
  if (name.empty()) {
    text = "umax: soft bodies that stop deforming exactly where you say\n\nusage: umax VERB [options]\n\n";
    for (const VerbHelp& verb : verbs()) {
      std::string line = "  " + std::string(verb.name) + " " + verb.arguments;
      line.resize(std::max<std::size_t>(line.size() + 1, 32), ' ');
      text += line + verb.summary + "\n";
    }
    return text +
           "\nSCENE is a .toml file or the name of a built-in scene (umax scenes). DIR is the folder of a run.\n"
           "umax help VERB tells a verb's options. Exit codes: 0 success, 1 pictures differ, 2 wrong usage,\n"
           "65 bad data, 66 not found, 69 a helper is missing, 70 internal, 73 cannot create, 74 read or write failed, "
           "75 "
           "try again.\n";
  }
  const VerbHelp* verb = find_verb(name);
  if (verb == nullptr) refuse_verb(name);
  text =
      "usage: umax " + name + " " + verb->arguments + " [options]\n\n" + verb->details + "\noptions, in any order:\n";
  return text + grammar.describe(name);
}

}  // namespace umax
