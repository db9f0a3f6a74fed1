// What stands on the command line, whatever the verb. Verbs make of it what the rooms below take; none of those sees it.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scenes/scene_document.h"
#include "tools/run/job.h"
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
  std::optional<std::string> isa;       // "avx2" | "best"
  std::optional<std::string> memory;    // "8G": parse_memory() reads it
  std::optional<std::string> deadline;  // "2 h"
  bool resume = false, overwrite = false, strict = false, quiet = false, verbose = false, quick = false,
       no_clip = false, json = false;
  bool allow_overlap = false;
  std::optional<std::string> progress;  // "auto" | "plain" | "json"

  std::optional<std::string> engine;  // "embree" | "osmesa"
  std::optional<int> samples;
  std::optional<std::string> size;  // "1280x720"
  std::optional<long long> seed;

  std::optional<std::string> map;  // inspect: "limit" | "young"
  bool picture = false;            // inspect: of bodies inside each other

  std::optional<std::string> format;  // export: "pc2"
  std::optional<std::string> bodies;  // export: "cow,obstacle.plate"
  std::optional<double> scale;        // export: on all lengths
  std::vector<std::string> exports;   // run, drop: --export FORMAT

  std::optional<std::string> height;  // "1.8 m": drop, turntable, inspect: of the mesh
  std::optional<std::string> unit;    // "cm", or metres as a number
  std::optional<std::string> up;      // "x" | "y" | "z": of the mesh file; export: of what is written
  std::optional<int> cells;
  std::optional<std::string> stretch;  // "20%"
  std::optional<std::string> stage;    // "studio" | "sky" | "plain"
  std::optional<int> count;            // drop: of bodies in all

  std::vector<std::string> variations;  // tune, farm: --vary key=a,b,c; aim: key=a..b
  std::vector<std::string> wants;       // aim
  bool final = false, presets = false;  // tune: not only a preview; every preset

  std::optional<int> frames_per_job;  // farm: that a job draws
  std::optional<std::string> queue;   // farm: "slurm" | "here" | a file
  bool dry_run = false;               // farm

  std::optional<int> port, keep;  // live: where it listens; frames that stay on the disk
  bool no_browser = false;        // live

  std::optional<std::string> test;    // fit: "uniaxial" | "compression" | "shear"
  std::optional<std::string> length;  // fit: "50 mm", of the specimen
  std::optional<std::string> area;    // fit: "25 mm^2"
  std::optional<double> poisson;      // fit: where the data do not tell it

  std::optional<std::string> report;  // compare: a page to write
  std::optional<double> max_flip;     // compare

  bool man = false;                       // help: the manual page
  std::optional<std::string> completion;  // help: "bash" | "zsh"
};

/// The only input; throws Error (usage) when there is none or more than one.
std::string single_input(const Options& options, const std::string& what);

/// -o, or ./NAME.
std::filesystem::path output_folder(const Options& options, const std::string& name);

/// What --resume and --overwrite make of a folder that is there.
ExistingFolder existing_folder(const Options& options);

/// Throws Error (cannot_create) when a file is there that --overwrite does not give up.
void require_new_file(const std::filesystem::path& path, const Options& options);

/// The options --engine, --samples, --size, --seed and --quick as settings of the scene, behind those of --set.
std::vector<Override> scene_overrides(const Options& options);

ProgressMode progress_mode(const Options& options);

/// [s] from now that --deadline gives.
std::optional<double> deadline_of(const Options& options);

/// [bytes] that --memory gives.
std::optional<long long> memory_limit(const Options& options);

/// threads: see ThreadLimit.
RunOptions run_options(const Options& options, int threads);

/// What --export asks for. Throws Error (usage).
std::vector<ExportOptions> job_exports(const Options& options);

/// Does the job with the threads and the progress that the options ask for; returns the exit code.
int run_job(const Job& job, const Options& options);

}  // namespace umax
