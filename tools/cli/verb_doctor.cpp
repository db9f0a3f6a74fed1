#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/vfs.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iterator>
#include <thread>

#include "core/base/error.h"
#include "core/files/write_file.h"
#include "embedding/mesh_files/mesh_io.h"
#include "render/raster/rasterize.h"
#include "tools/cli/options.h"
#include "tools/cli/verb.h"
#include "tools/live/server.h"
#include "tools/run/clip.h"
#include "tools/run/run_record.h"
#include "tools/system/exit_code.h"
#include "tools/system/machine_memory.h"
#include "tools/system/scratch_folder.h"
#include "tools/system/seconds_since.h"
#include "tools/system/subprocess.h"
#include "tools/system/threads.h"
#include "tools/system/version.h"
#include "tools/tune/tune_page.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr double gibi = 1024.0 * 1024 * 1024;
constexpr double little_memory = 2 * gibi, little_room = 5 * gibi;  // [bytes] that a usual clip may outgrow
constexpr double slow_sync = 0.2;                                   // [s] of a small file

enum class Health { good, poor, missing };

struct Finding {
  Health health = Health::good;
  std::string text, remedy = {};
};

Finding look_at_processor() {
  if (!(__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2")))
    return {Health::missing, "has no AVX2, FMA and BMI2 (x86-64-v3)", "run umax on one from 2013 or later"};
  return {Health::good, host_description() + ", used by " + instruction_set_text()};
}

/// More threads than processors that they may have wait for each other.
Finding look_at_threads() {
  const int threads = ThreadLimit({}).count(), processors = int(std::thread::hardware_concurrency());
  const double allowed = allowed_processors();
  const std::string text =
      fmt::format("{} unless --threads says otherwise, on {} of {} processors", threads, allowed, processors);
  if (allowed < threads - 0.5)
    return {Health::poor, text + ": the group of processes may use no more of their time",
            fmt::format("--threads {:.0f}, or ask for more", std::max(1.0, std::floor(allowed)))};
  return {Health::good, text};
}

Finding look_at_memory() {
  const auto available = double(available_memory());
  const std::string text = format_memory(available) + " to be had";
  if (available < little_memory)
    return {Health::poor, text, "close other programs; umax inspect SCENE says what a scene takes"};
  return {Health::good, text};
}

// an error of a check is what it found
Finding found_by(const std::function<Finding()>& check) {
  try {
    return check();
  } catch (const Error& error) {
    return {Health::missing,
            error.text().where.empty() ? error.text().what : error.text().where + ": " + error.text().what,
            error.text().remedy};
  }
}

Finding look_at_encoder() {
  require_clip_encoder();
  require_page_encoder();
  return {Health::good, find_program("ffmpeg")->string() + " with H.264 and WebP"};
}

Finding look_at_rasteriser() {
  const Rasterizer rasterizer;
  return {Health::good, "OSMesa with GL 4.5"};
}

Finding look_at_importer() {
  const ScratchFolder scratch;
  const fs::path path = scratch.path() / "triangle.dae";
  write_file(path, R"(<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset><unit meter="1"/><up_axis>Y_UP</up_axis>
</asset><library_geometries><geometry id="g"><mesh><source id="p"><float_array id="a" count="9">0 0 0 1 0 0 0 1 0
</float_array><technique_common><accessor source="#a" count="3" stride="3"><param name="X" type="float"/><param name="Y"
type="float"/><param name="Z" type="float"/></accessor></technique_common></source><vertices id="v"><input
semantic="POSITION" source="#p"/></vertices><triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1
2</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="s"><node><instance_geometry
url="#g"/></node></visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)");
  if (load_mesh(path).mesh.num_triangles() != 1)
    return {Health::missing, "umax-import reads COLLADA wrongly", "install umax anew"};
  return {Health::good, "umax-import reads glTF, FBX and COLLADA"};
}

Finding look_at_font() {
  const char* home = std::getenv("HOME");
  std::error_code error;
  for (const fs::path& folder : {fs::path("/usr/share/fonts"), fs::path("/usr/local/share/fonts"),
                                 fs::path(home ? home : "/nonexistent") / ".local/share/fonts"})
    for (auto at = fs::recursive_directory_iterator(folder, error); at != fs::recursive_directory_iterator();
         at.increment(error))
      if (at->path().filename() == "DejaVuSans.ttf") return {Health::good, at->path().string()};
  return {Health::poor, "no DejaVu Sans: captions and legends take another font",
          "install it (apt-get install fonts-dejavu-core)"};
}

Finding look_at_plots() {
  plotting_library();
  return {Health::good, "Chart.js for the pages of umax tune"};
}

Finding look_at_live_page() {
  page_files();
  return {Health::good, "three.js for the page of umax live"};
}

/// Of the file system, by what it says of itself; other kinds are local disks.
struct FileSystemKind {
  long magic;
  const char* name;
  bool is_shared = false, is_memory = false;
};
constexpr FileSystemKind kinds[]{{0x6969, "NFS", true, false},
                                 {0xFF534D42, "CIFS", true, false},
                                 {0xFE534D42, "SMB", true, false},
                                 {0x0BD00BD0, "Lustre", true, false},
                                 {0x47504653, "GPFS", true, false},
                                 {0x00C36400, "Ceph", true, false},
                                 {0x01021994, "tmpfs", false, true},
                                 {0x858458F6, "ramfs", false, true},
                                 {0xEF53, "ext4"},
                                 {0x58465342, "XFS"},
                                 {0x9123683E, "Btrfs"},
                                 {0x2FC12FC1, "ZFS"},
                                 {0x794C7630, "overlay"},
                                 {0x65735546, "FUSE", true, false}};

FileSystemKind kind_of(const fs::path& folder) {
  struct statfs system{};
  if (statfs(folder.c_str(), &system) != 0) return {0, "unknown"};
  const auto* known = std::find_if(std::begin(kinds), std::end(kinds),
                                   [&](const FileSystemKind& kind) { return kind.magic == long(system.f_type); });
  return known == std::end(kinds) ? FileSystemKind{0, "another kind"} : *known;
}

/// What several processes need to share a folder's work, and long files their room.
Finding look_at_file_system(const fs::path& folder) {
  const FileSystemKind kind = kind_of(folder);
  const ScratchFolder scratch(folder);
  write_file(scratch.path() / "file", "x");
  std::error_code error;
  fs::create_hard_link(scratch.path() / "file", scratch.path() / "link", error);
  const std::string text = fmt::format("{}{}{}", kind.name, kind.is_shared ? ", shared with other machines" : "",
                                       error ? ", without hard links: claims on frames are copies" : "");
  rlimit largest{};
  getrlimit(RLIMIT_FSIZE, &largest);
  if (largest.rlim_cur != RLIM_INFINITY && double(largest.rlim_cur) < little_room)
    return {Health::poor,
            fmt::format("{}; files may have no more than {}", text, format_memory(double(largest.rlim_cur))),
            "ulimit -f unlimited: clips and exports may be larger"};
  if (kind.is_memory) return {Health::poor, text + ": gone when the machine is", "choose a folder on a disk with -o"};
  return {Health::good, text};
}

Finding look_at_files(const fs::path& folder) {
  const ScratchFolder scratch(folder);
  const auto start = std::chrono::steady_clock::now();
  write_file(scratch.path() / "file", std::string(1 << 20, 'x'));
  const double seconds = seconds_since(start);
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  const std::string text = fmt::format("{}: {} free, a file of 1 MiB written in {:.0f} ms", folder.string(),
                                       format_memory(double(space.available)), 1000 * seconds);
  if (double(space.available) < little_room)
    return {Health::poor, text, "make room: states and pictures of a clip take some gigabytes"};
  if (seconds > slow_sync) return {Health::poor, text, "use a faster disk: each state and picture is synced to it"};
  return {Health::good, text};
}

int examine(const Options& options) {
  if (!options.inputs.empty())
    throw Error(Fault::usage, {.what = "umax doctor takes no input", .remedy = "see umax help doctor"});
  const fs::path folder = options.output ? fs::path(*options.output) : fs::current_path();
  if (!options.quiet) fmt::print("umax {}\n", version_text());
  bool all_there = true;
  const auto tell = [&](const char* name, const std::function<Finding()>& check) {
    const Finding found = found_by(check);
    all_there = all_there && found.health != Health::missing;
    if (options.quiet && found.health == Health::good) return;
    constexpr const char* marks[]{"ok", "poor", "MISSING"};
    fmt::print("{:<8} {:<11} {}\n", marks[int(found.health)], name, found.text);
    if (!found.remedy.empty()) fmt::print("{:<20} {}\n", "", found.remedy);
  };
  tell("processor", look_at_processor);
  tell("threads", look_at_threads);
  tell("memory", look_at_memory);
  tell("files", [&] { return look_at_files(folder); });
  tell("file system", [&] { return look_at_file_system(folder); });
  tell("encoder", look_at_encoder);
  tell("rasteriser", look_at_rasteriser);
  tell("importer", look_at_importer);
  tell("font", look_at_font);
  tell("plots", look_at_plots);
  tell("live page", look_at_live_page);
  return all_there ? 0 : exit_code_of(Fault::unavailable);
}

}  // namespace

Verb doctor_verb() {
  return {.name = "doctor",
          .usage = "",
          .summary = "what the machine lacks and how to mend it",
          .details =
              "Tries what umax needs of this machine: processor, threads, memory, the folder's disk and file system "
              "(the current "
              "one, or that of -o), ffmpeg, OSMesa, the program that reads foreign meshes, fonts and the libraries of "
              "pages. Exit code 69 "
              "where anything is missing. --quiet tells only what is not well.",
          .examples = {"umax doctor"},
          .arguments = {},
          .options = {"--output", "--quiet"},
          .run = examine};
}

}  // namespace umax
