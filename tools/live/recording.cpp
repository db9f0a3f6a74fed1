#include "tools/live/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <vector>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/sha256.h"
#include "core/files/write_file.h"
#include "scenes/resolved_scene.h"
#include "tools/run/frame_list.h"
#include "tools/run/run_folder.h"
#include "tools/run/run_record.h"
#include "tools/run/step_plots.h"
#include "tools/setup/limit_report.h"
#include "tools/system/version.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* record_name = "live.txt";
constexpr FolderKind live_kind{"live session of umax", ".umax",
                               [](const fs::path& path) { return fs::exists(path / record_name); }, false};

/// As write_file(), but the disk may take its time: sixty of these a second are written.
void write_soon(const fs::path& path, const std::string& bytes) {
  const fs::path temporary = path.parent_path() / ("." + path.filename().string() + ".part-live");
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), std::streamsize(bytes.size()));
  file.close();
  std::error_code failed;
  if (file) fs::rename(temporary, path, failed);
  if (file && !failed) return;
  fs::remove(temporary, failed);
  throw Error(Fault::io_error, {.where = path.string(),
                                .what = "cannot be written",
                                .remedy = "make room on the disk, give another folder with -o, or a smaller --keep"});
}

std::string scene_text(const Session& session, const SessionFiles& files) {
  return "# umax live. The same states again: umax simulate, and for a clip: umax run, with this file.\n" +
         resolved_toml(files.scene, limit_comments(session.simulation));
}

/// All states that a run of the session would have, read and written again as that run's.
bool copy_states(const Session& session, const Recording& recording, const RunFolder& run, int frames,
                 const Digest& digest) {
  create_folder(run.states());
  for (int frame = 1; frame <= frames; ++frame) {
    const std::optional<State> state = recording.state(frame);
    if (!state) return false;
    write_file(run.state(frame), encode_state(*state, digest));
  }
  std::vector<StepRow> rows(session.rows.begin(), session.rows.end());
  while (!rows.empty() && rows.back().frame > frames) rows.pop_back();
  StepsFile(run.steps(), steps_header(probe_names(session.simulation.scene)), 0).append(rows);
  return true;
}

RunRecord record_of(const Session& session, const std::string& scene, const Digest& digest, int frames) {
  RunRecord record;
  record.version = version_text();
  record.verb = "live";
  record.scene = session.simulation.scene.name;
  record.scene_sha256 = sha256_hex(scene);
  record.model_sha256 = digest;
  record.host = host_description();
  record.frames = frames;
  record.steps = (long long)(frames - 1) * session.substeps();
  for (const StepRow& row : session.rows) {
    if (row.frame > frames) continue;
    record.steps_not_converged += row.report.status != StepStatus::converged;
    record.simulate_seconds += row.wall_ms / 1000;
  }
  record.threads = 1;
  record.peak_memory = peak_memory();
  record.exit_status = 0;
  return record;
}

Digest digest_of_files(const Session& session, const Scene& scene) {
  Simulation as_saved = session.simulation;
  as_saved.scene = scene;
  return digest_of(as_saved);
}

fs::path save_as(const Session& session, const fs::path& folder, const std::string& name, SessionFiles& files) {
  files = session_files(session, name + ".pulls");
  if (!files.pulls.empty()) write_file(folder / (name + ".pulls"), files.pulls);
  fs::path path = folder / (name + ".toml");
  write_file(path, scene_text(session, files));
  return path;
}

}  // namespace

Recording::Recording(const fs::path& path, ExistingFolder existing, int keep)
    : folder_(path, existing, live_kind), keep_(keep) {
  write_file(this->path() / record_name, version_text() + "\n");
  create_folder(this->path() / "states");
  std::vector<fs::path> old;
  for (const fs::directory_entry& entry : fs::directory_iterator(this->path() / "states"))
    if (entry.path().extension() == ".state") old.push_back(entry.path());
  for (const fs::path& file : old) fs::remove(file);
  for (const fs::path& place : {this->path(), this->path() / "states"}) remove_leftovers(place);
}

fs::path Recording::file_of(int frame) const {
  return state_path(path(), frame);
}

void Recording::keep(int frame, const State& state, const Digest& digest) {
  cut(frame - 1);
  write_soon(file_of(frame), encode_state(state, digest));
  if (first_ == 0) first_ = frame;
  last_ = frame;
  std::error_code error;
  for (; last_ - first_ + 1 > keep_; ++first_) fs::remove(file_of(first_), error);
}

void Recording::cut(int frame) {
  std::error_code error;
  for (; last_ > frame && last_ >= first_ && last_ > 0; --last_) fs::remove(file_of(last_), error);
  if (last_ < first_) first_ = last_ = 0;
}

std::optional<State> Recording::state(int frame) const {
  if (first_ == 0 || frame < first_ || frame > last_) return std::nullopt;
  Digest digest;
  return decode_state(read_file(file_of(frame)), file_of(frame).string(), digest);
}

std::string Recording::new_name() const {
  std::error_code error;
  for (int number = 1;; ++number) {
    std::string name = fmt::format("session-{:02}", number);
    if (!fs::exists(path() / (name + ".toml"), error) && !fs::exists(path() / name, error)) return name;
  }
}

void check_live_folder(const fs::path& path, ExistingFolder existing) {
  check_folder(path, existing, live_kind);
}

fs::path save_session(const Session& session, const Recording& recording) {
  SessionFiles files;
  return save_as(session, recording.path(), recording.new_name(), files);
}

SessionRun save_run(const Session& session, const Recording& recording) {
  const std::string name = recording.new_name();
  SessionFiles files;
  SessionRun result{.scene = save_as(session, recording.path(), name, files), .run = {}};
  result.frames = files.scene.clip.frames;
  const long long steps = (long long)(result.frames - 1) * session.substeps();
  const bool has_rows = steps == 0 || (!session.rows.empty() && session.rows.front().step == 1);
  if (recording.first_frame() != 1 || recording.last_frame() < result.frames || !has_rows) return result;

  if (!files.pulls.empty()) files.scene.clip.pulls = recording.path() / files.scene.clip.pulls;
  const Digest digest = digest_of_files(session, files.scene);
  const RunFolder run(recording.path() / name, ExistingFolder::refuse);
  const std::string text = scene_text(session, files);
  write_file(run.scene(), text);
  copy_states(session, recording, run, result.frames, digest);
  write_run_record(run.record(), record_of(session, text, digest, result.frames));
  write_step_plots(run, files.scene);
  result.run = run.path();
  return result;
}

}  // namespace umax
