#include "tools/cli/option_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>

#include "scenes/quantity.h"
#include "tools/exchange/export_format.h"
#include "tools/system/machine_memory.h"

namespace umax {
namespace {

std::string check_size(const std::string& text) {
  int width = 0, height = 0, end = 0;
  const int found = std::sscanf(text.c_str(), "%dx%d%n", &width, &height, &end);
  if (found == 2 && std::size_t(end) == text.size() && width > 0 && height > 0) return "";
  return "\"" + text + "\" is no size; write it as 1280x720";
}

std::string check_memory(const std::string& text) {
  if (parse_memory(text)) return "";
  return "\"" + text + "\" is no size of memory; write it as 8G, 500M or a number of bytes";
}

std::string check_deadline(const std::string& text) {
  std::string problem;
  const auto time = parse_quantity(text, units::time, problem);
  if (!time) return "\"" + text + "\" " + problem + "; write it as 2 h, 90 min or a number of seconds";
  if (!(time->value > 0) || time->value > 1e8) return "\"" + text + "\" is no time from now; write it as 2 h or 90 min";
  return "";
}

using Table = std::vector<OptionDefinition>;

Table run_table() {
  return {
      {.name = "--output",
       .short_name = "-o",
       .value = "DIR",
       .description = "the folder of the run (default: ./NAME, the scene's or mesh's name; reproduce: ./report; "
                      "tune, aim, fit, live: ./NAME-tune, ./NAME-aim, ./NAME-fit, ./NAME-live; farm with --vary: "
                      "./NAME-farm); strip, inspect --map, "
                      "--picture: the "
                      "picture (./strip.png, "
                      "./NAME-limit-map.png, ./NAME-overlaps.png)",
       .target = &Options::output,
       .is_path = true},
      {.name = "--set",
       .value = "KEY=VALUE",
       .description = "set any key of the scene, as in --set body.figure.limit.stretch=15%; repeatable",
       .target = &Options::settings},
      {.name = "--frames",
       .value = "LIST",
       .description = "only these frames, as in 1-40,50,60-90x2",
       .target = &Options::frames},
      {.name = "--resume", .description = "go on with the folder's run where it stopped", .target = &Options::resume},
      {.name = "--overwrite",
       .description = "replace the run that the folder holds (live: saved sessions stay); strip, inspect --map, "
                      "--picture: the picture",
       .target = &Options::overwrite},
      {.name = "--deadline",
       .value = "TIME",
       .description = "stop cleanly after that long, as 2 h or 90 min, with exit code 75; --resume goes on",
       .target = &Options::deadline,
       .examples = {"2h", "90min"},
       .check = check_deadline},
      {.name = "--strict",
       .description = "end with exit code 75 when a step does not converge",
       .target = &Options::strict},
      {.name = "--allow-overlap",
       .description = "start although bodies are deep inside each other (clip.allow_overlap)",
       .target = &Options::allow_overlap},
      {.name = "--no-clip",
       .description = "pictures alone, which umax encode makes the clip of",
       .target = &Options::no_clip},
      {.name = "--quick",
       .description = "few samples and small pictures, for a first look",
       .target = &Options::quick}};
}

Table picture_table() {
  return {{.name = "--engine",
           .value = "ENGINE",
           .description = "embree (path tracer) or osmesa (rasteriser)",
           .target = &Options::engine,
           .choices = {"embree", "osmesa"}},
          {.name = "--samples",
           .value = "N",
           .description = "paths per pixel of the path tracer",
           .target = &Options::samples,
           .range = OptionRange{1, 1e6}},
          {.name = "--size",
           .value = "WxH",
           .description = "size of the pictures in pixels, as in 1280x720",
           .target = &Options::size,
           .examples = {"1280x720", "1920x1080", "640x360"},
           .check = check_size},
          {.name = "--seed",
           .value = "N",
           .description = "seed of the path tracer's noise",
           .target = &Options::seed,
           .range = OptionRange{0, 4294967295.0}},
          {.name = "--label",
           .value = "TEXT",
           .description = "words below a thing in the strip; once for each, from left to right",
           .target = &Options::labels},
          {.name = "--still",
           .value = "FRAME",
           .description = "the frame of the run that is circled (default: the last)",
           .target = &Options::still,
           .range = OptionRange{1, 1e9}}};
}

Table mesh_table() {
  return {{.name = "--height",
           .value = "LENGTH",
           .description = "make the mesh this tall, as in 1.8 or \"30 cm\"",
           .target = &Options::height},
          {.name = "--unit",
           .value = "UNIT",
           .description = "length of the mesh file's unit: mm, cm, m, in, ft, or metres as a number",
           .target = &Options::unit,
           .examples = {"mm", "cm", "m", "in", "ft"}},
          {.name = "--up",
           .value = "AXIS",
           .description = "axis that points up in the mesh file: x, y, z, -x, -y or -z; export: in what is written, y "
                          "(default) or z",
           .target = &Options::up,
           .examples = {"x", "y", "z"}},
          {.name = "--cells",
           .value = "N",
           .description = "number of hexes that the cage should have (default: 365)",
           .target = &Options::cells},
          {.name = "--count",
           .value = "N",
           .description = "drop: so many bodies in all, the meshes taken in turn (default: each once)",
           .target = &Options::count,
           .range = OptionRange{1, 1000}},
          {.name = "--stretch",
           .value = "PERCENT",
           .description = "most that any hex may stretch (default: 20%)",
           .target = &Options::stretch},
          {.name = "--stage",
           .value = "STAGE",
           .description = "what a mesh is shown in: studio (default), sky (outdoors) or plain (even light on white)",
           .target = &Options::stage,
           .choices = {"studio", "sky", "plain"}}};
}

Table export_table() {
  return {{.name = "--format",
           .value = "FORMAT",
           .description = "export: " + fmt::format("{}", fmt::join(export_format_names(), ", ")),
           .target = &Options::format,
           .choices = export_format_names()},
          {.name = "--bodies",
           .value = "LIST",
           .description = "export: only these bodies and obstacles, as in cow,obstacle.plate (default: all)",
           .target = &Options::bodies},
          {.name = "--scale",
           .value = "FACTOR",
           .description = "export: multiplies all lengths, as in 100 for centimetres (default: 1, metres)",
           .target = &Options::scale,
           .range = OptionRange{1e-9, 1e9}},
          {.name = "--export",
           .value = "FORMAT",
           .description = "write the clip into DIR/export, too, as umax export DIR does; repeatable",
           .target = &Options::exports,
           .choices = export_format_names()}};
}

Table look_table() {
  return {{.name = "--max-flip",
           .value = "X",
           .description = "largest mean FLIP that passes (default: 0.02)",
           .target = &Options::max_flip,
           .range = OptionRange{0, 1}},
          {.name = "--report",
           .value = "FILE",
           .description = "write an HTML page with both pictures and their difference",
           .target = &Options::report,
           .is_path = true},
          {.name = "--json", .description = "print one JSON object", .target = &Options::json},
          {.name = "--map",
           .value = "limit|young",
           .description = "draw the factors on the limit or on Young's modulus, as maps and files of hexes give them",
           .target = &Options::map,
           .choices = {"limit", "young"}},
          {.name = "--picture",
           .description = "draw where bodies are inside each other at the start, and how deep",
           .target = &Options::picture}};
}

Table tune_table() {
  return {{.name = "--vary",
           .value = "KEY=A,B,C",
           .description = "tune, farm: run the scene once for each value; repeatable: every combination; as in --vary "
                          "body.figure.limit.stretch=5%,10%,20%; aim: KEY=A..B, the range of a key; repeatable",
           .target = &Options::variations},
          {.name = "--want",
           .value = "WANT",
           .description = "aim: what is wanted, as in 'height(figure) at 0.6 s = 85 %'; repeatable",
           .target = &Options::wants},
          {.name = "--presets",
           .description = "vary material.preset over all presets (umax presets)",
           .target = &Options::presets},
          {.name = "--final", .description = "the scene as it is, not a preview of it", .target = &Options::final}};
}

Table farm_table() {
  return {{.name = "--frames-per-job",
           .value = "N",
           .description = "farm: frames that a job draws (default: 10)",
           .target = &Options::frames_per_job,
           .range = OptionRange{1, 1e7}},
          {.name = "--queue",
           .value = "QUEUE",
           .description =
               "farm: slurm (default), here (this machine, for trying), or a file of functions as queue.sh in the "
               "farm's folder",
           .target = &Options::queue,
           .examples = {"slurm", "here"}},
          {.name = "--dry-run",
           .description = "farm: print the scripts and what would be submitted, and do nothing",
           .target = &Options::dry_run}};
}

Table live_table() {
  return {{.name = "--port",
           .value = "N",
           .description = "live: the port on 127.0.0.1, for tunnels (default: one that is free)",
           .target = &Options::port,
           .range = OptionRange{1, 65535}},
          {.name = "--no-browser", .description = "live: open none", .target = &Options::no_browser},
          {.name = "--keep",
           .value = "FRAMES",
           .description = "live: the last states that stay on the disk (default: 3600)",
           .target = &Options::keep,
           .range = OptionRange{2, 1e7}}};
}

Table fit_table() {
  return {{.name = "--test",
           .value = "KIND",
           .description = "uniaxial (default), compression or shear",
           .target = &Options::test,
           .choices = {"uniaxial", "compression", "shear"}},
          {.name = "--length",
           .value = "LENGTH",
           .description = "of the specimen at rest, for displacements, as in \"50 mm\"; shear: height of the sheared "
                          "layer",
           .target = &Options::length},
          {.name = "--area",
           .value = "AREA",
           .description = "of the specimen's section at rest, for forces, as in \"25 mm^2\"; shear: of the sheared "
                          "layer",
           .target = &Options::area},
          {.name = "--poisson",
           .value = "NU",
           .description = "Poisson's ratio where the data do not tell it (default: 0.3)",
           .target = &Options::poisson,
           .range = OptionRange{-0.99, 0.4999}}};
}

Table general_table() {
  return {
      {.name = "--threads",
       .value = "N",
       .description = "number of threads (default: all cores); results do not depend on it",
       .target = &Options::threads,
       .range = OptionRange{1, 1024}},
      {.name = "--isa",
       .value = "SET",
       .description =
           "avx2: states have the same bytes on every machine, also on one with AVX-512; best (default): the "
           "fastest that the machine has. UMAX_ISA in the environment says the same",
       .target = &Options::isa,
       .choices = {"avx2", "best"}},
      {.name = "--memory",
       .value = "SIZE",
       .description = "memory that a simulation may take, as in 8G or 500M (default: what the machine has to "
                      "give); what would need more is refused before it starts",
       .target = &Options::memory,
       .check = check_memory},
      {.name = "--progress",
       .value = "MODE",
       .description = "auto (a bar on a terminal), plain (a line per frame) or json",
       .target = &Options::progress,
       .choices = {"auto", "plain", "json"}},
      {.name = "--quiet", .description = "say nothing but warnings and errors", .target = &Options::quiet},
      {.name = "--verbose",
       .description = "say more; simulate prints a line per iteration",
       .target = &Options::verbose},
      {.name = "--man", .description = "the manual page, as in umax help --man | man -l -", .target = &Options::man},
      {.name = "--completion",
       .value = "SHELL",
       .description = "what makes the shell complete the program's words, as in source <(umax help --completion "
                      "bash)",
       .target = &Options::completion,
       .choices = {"bash", "zsh"}},
      {.name = "--help", .short_name = "-h", .description = "this text", .target = &Options::help},
      {.name = "--version",
       .description = "the program's version, commit, compiler, instruction set and libraries",
       .target = &Options::version}};
}

}  // namespace

const std::vector<OptionDefinition>& option_table() {
  static const Table all = [] {
    Table joined;
    for (const Table& part : {run_table(), picture_table(), mesh_table(), export_table(), look_table(), tune_table(),
                              farm_table(), live_table(), fit_table(), general_table()})
      joined.insert(joined.end(), part.begin(), part.end());
    return joined;
  }();
  return all;
}

std::string usage(const OptionDefinition& option) {
  return (option.short_name.empty() ? "" : option.short_name + ",") + option.name +
         (option.value.empty() ? "" : " " + option.value);
}

}  // namespace umax
