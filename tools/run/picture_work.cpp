#include "tools/run/picture_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <set>
#include <thread>
#include <utility>

#include "core/base/error.h"
#include "tools/pictures/exposure.h"
#include "tools/run/clip.h"
#include "tools/run/frame_list.h"
#include "tools/run/frame_order.h"
#include "tools/system/signals.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* agreed = "agreed-";  // begins what each claims who has gone through agree_on_pictures()

/// Who decides over the pictures of a folder, one at a time: which settings they have, and what the clip is of.
class Door {
 public:
  explicit Door(Presence& presence)
      : presence_(presence), is_ours_(presence.claim_when_free("door", [] { return stop_signal() != 0; })) {}
  ~Door() {
    if (is_ours_) presence_.release("door");
  }
  Door(const Door&) = delete;
  Door& operator=(const Door&) = delete;
  bool is_ours() const { return is_ours_; }  // otherwise a signal asks us to stop

 private:
  Presence& presence_;
  bool is_ours_;
};

/// Removes what the killed have left. The door is ours: who comes now waits before it writes.
void tidy(const RunFolder& folder) {
  folder.presence().sweep();
  if (folder.presence().others().empty()) folder.remove_leftovers();
}

bool has_picture(const RunFolder& folder, int frame, bool writes_exr) {
  std::error_code error;
  return fs::exists(folder.picture(frame), error) && (!writes_exr || fs::exists(folder.picture(frame, ".exr"), error));
}

bool has_pictures(const RunFolder& folder) {
  std::error_code error;
  const fs::directory_iterator entries(folder.frames(), error);
  return std::any_of(begin(entries), end(entries),
                     [](const auto& entry) { return entry.path().extension() == ".png"; });
}

std::vector<Worker> with_role(std::vector<Worker> workers, const std::set<std::string>& roles) {
  workers.erase(
      std::remove_if(workers.begin(), workers.end(), [&](const Worker& worker) { return !roles.count(worker.role); }),
      workers.end());
  return workers;
}

/// In words, how the pictures that are there differ from those that are wanted; empty: in no setting.
std::string difference(const PictureRecord& there, const PictureRecord& wanted) {
  if (std::string text = first_difference(there.settings, wanted.settings); !text.empty()) return text;
  if (there.clip_frames == wanted.clip_frames) return {};
  return fmt::format("clip.frames is {} there, {} here", there.clip_frames, wanted.clip_frames);
}

[[noreturn]] void refuse_beside(const RunFolder& folder, const PictureRecord& there, const PictureRecord& wanted,
                                const Worker& worker) {
  const std::string setting = difference(there, wanted);
  const std::string who = "pictures are being drawn there by " + describe(worker);
  if (setting.empty())
    throw Error(Fault::try_again, {.where = folder.path().string(),
                                   .what = who + ", of other states or files than are there now",
                                   .remedy = "wait until it ends"});
  throw Error(Fault::cannot_create, {.where = folder.path().string(),
                                     .what = who + " with another setting: " + setting,
                                     .remedy = "draw with the same, or into another folder with -o"});
}

void refuse_other_settings(const RunFolder& folder, const std::string& setting) {
  throw Error(Fault::cannot_create, {.where = folder.frames().string(),
                                     .what = "holds pictures that were drawn with another setting: " + setting,
                                     .remedy = "replace them by --overwrite, draw with the same, or choose another "
                                               "folder with -o"});
}

/// A clip that was longer or shorter when its pictures were made cut off their blur and motion elsewhere: those go.
void remove_pictures_of_other_length(const RunFolder& folder, const RenderDescription& render, int then, int now) {
  const auto window = [&](int frame, int last) {
    return std::pair(exposure_of(render, frame, last), states_for(render, frame, last));
  };
  for (int frame = 1; frame <= std::max(then, now); ++frame)
    if (window(frame, then) != window(frame, now)) folder.remove_picture(frame);
}

/// Removes the pictures that do not fit any more. Nobody else is drawing.
void remove_misfits(const RunFolder& folder, const PictureRecord& there, const PictureRecord& wanted,
                    const RenderDescription& render, OtherPictures others, Progress& progress) {
  if (!has_pictures(folder)) return;
  const std::string setting = first_difference(there.settings, wanted.settings);
  if (!setting.empty() && others == OtherPictures::refuse) refuse_other_settings(folder, setting);
  if (there.digest == wanted.digest) {
    remove_pictures_of_other_length(folder, render, there.clip_frames, wanted.clip_frames);
    return;
  }
  progress.note(setting.empty() ? "the states, or files that the scene names, have changed: pictures are made anew"
                                : "the pictures that are there were made with other settings (" + setting +
                                      "): they are made anew");
  folder.remove_pictures();
}

/// Whether others have gone through agree_on_pictures().
bool others_have_agreed(const Presence& presence) {
  const std::set<std::string> names = presence.claimed_by_others();
  return std::any_of(names.begin(), names.end(), [](const std::string& name) { return name.starts_with(agreed); });
}

/// Frames that others are drawing.
std::set<int> taken_frames(const Presence& presence) {
  constexpr std::string_view prefix = "frame-";
  std::set<int> frames;
  for (const std::string& name : presence.claimed_by_others())
    if (name.starts_with(prefix)) frames.insert(std::atoi(name.c_str() + prefix.size()));
  return frames;
}

/// What is still to be drawn of a list, by us and by others.
class OpenFrames {
 public:
  OpenFrames(const RunFolder& folder, const std::vector<int>& frames, bool writes_exr)
      : folder_(folder), writes_exr_(writes_exr), missing_(frames) {
    drop_drawn();
  }
  const std::vector<int>& missing() const { return missing_; }

  /// Leaves out what is drawn by now; returns how many those are.
  int drop_drawn() {
    const std::size_t before = missing_.size();
    // a folder that is opened anew shows what other machines have put there
    std::error_code error;
    const fs::directory_iterator refreshed(folder_.frames(), error);
    std::erase_if(missing_, [&](int frame) { return has_picture(folder_, frame, writes_exr_); });
    return int(before - missing_.size());
  }

  /// Claims the next frame to draw; 0: others have claimed all.
  int claim_next(int last) {
    std::set<int> taken = taken_frames(folder_.presence());
    while (const int frame = next_frame(missing_, taken, last)) {
      if (folder_.presence().claim(claim_of(frame))) return frame;
      taken.insert(frame);
    }
    return 0;
  }
  void release(int frame) { folder_.presence().release(claim_of(frame)); }

 private:
  static std::string claim_of(int frame) { return "frame-" + frame_name(frame); }
  const RunFolder& folder_;
  bool writes_exr_;
  std::vector<int> missing_;
};

/// Draws what nobody else draws, and waits for what others do: theirs is ours when they die.
void draw_open_frames(OpenFrames& open, const PictureList& list, Painter& painter, const RunFolder& folder,
                      Progress& progress) {
  constexpr std::chrono::milliseconds shortest(20), longest(500);
  auto pause = shortest;
  bool waits = false;
  for (int last = 0; !open.missing().empty() && stop_signal() == 0;) {
    const int frame = open.claim_next(last);
    // drawn meanwhile, perhaps just before it was ours
    progress.frames_done_elsewhere(open.drop_drawn());
    const auto& missing = open.missing();
    if (frame != 0 && std::binary_search(missing.begin(), missing.end(), frame)) {
      const bool is_drawn = painter.paint(list, frame, folder.picture(frame));
      progress.frames_done_elsewhere(open.drop_drawn() - int(is_drawn));
      if (is_drawn) progress.frame_done(last = frame);
      pause = shortest;
    }
    if (frame != 0) {
      open.release(frame);
      continue;
    }
    if (!waits && !missing.empty())
      progress.note("waiting for frames " + frame_list_text(missing) + ", which others draw");
    waits = true;
    std::this_thread::sleep_for(pause);
    pause = std::min(2 * pause, longest);
  }
}

bool all_there(const RunFolder& folder, const std::vector<int>& frames) {
  std::error_code error;
  return std::all_of(frames.begin(), frames.end(), [&](int frame) { return fs::exists(folder.picture(frame), error); });
}

/// Whether the clip is of these frames, and none of their pictures is newer. Who made it may have died just after that.
bool is_current(const RunFolder& folder, const PictureRecord& record, const std::vector<int>& frames) {
  std::error_code error;
  const auto made = fs::last_write_time(folder.clip(), error);
  if (error) return false;
  const bool is_next = record.next == frames && fs::last_write_time(folder.pictures(), error) < made;
  return (record.frames == frames || is_next) && std::all_of(frames.begin(), frames.end(), [&](int frame) {
           return fs::last_write_time(folder.picture(frame), error) <= made && !error;
         });
}

/// The clip is of these frames.
void write_clip_record(const RunFolder& folder, const std::vector<int>& frames, PictureRecord record) {
  record.frames = frames;
  record.next.clear();
  write_picture_record(folder.pictures(), record);
}

/// The door is ours.
void encode_and_record(const RunFolder& folder, const std::vector<int>& frames, const Scene& scene,
                       PictureRecord record, Progress& progress) {
  record.next = frames;
  write_picture_record(folder.pictures(), record);
  encode_pictures(folder, frames, scene, progress);
  write_clip_record(folder, frames, record);
}

}  // namespace

std::vector<Worker> drawing_in(const fs::path& run_folder) {
  return with_role(workers_in_run(run_folder), {draws, draws_for_clip});
}

int agree_on_pictures(const RunFolder& folder, const PictureRecord& wanted, const RenderDescription& render,
                      OtherPictures others, Progress& progress) {
  const Door door(folder.presence());
  if (!door.is_ours()) return stop_signal();
  std::vector<Worker> beside = with_role(folder.presence().others(), {draws, draws_for_clip});
  if (!others_have_agreed(folder.presence())) beside.clear();  // they have just come, and do as we say
  const auto there = read_picture_record(folder.pictures());
  const bool is_same = there && there->digest == wanted.digest && there->clip_frames == wanted.clip_frames;
  if (there && !is_same && !beside.empty()) refuse_beside(folder, *there, wanted, beside.front());
  if (there && !is_same) remove_misfits(folder, *there, wanted, render, others, progress);
  tidy(folder);
  if (!is_same) write_picture_record(folder.pictures(), wanted);
  folder.presence().claim(agreed + folder.presence().name());
  return 0;
}

RenderResult draw_pictures(const PictureList& list, const RenderDescription& render, int threads,
                           const RunFolder& folder, Progress& progress) {
  RenderResult result;
  OpenFrames open(folder, list.frames, render.writes_exr());
  const int done = int(list.frames.size() - open.missing().size());
  if (!open.missing().empty()) {
    create_folder(folder.frames());
    Painter painter(render, threads);
    progress.begin("render", int(list.frames.size()), done);
    draw_open_frames(open, list, painter, folder, progress);
    progress.end();
    if (const Door door(folder.presence()); door.is_ours()) tidy(folder);
  }
  result.pictures = int(list.frames.size() - open.missing().size());
  result.signal = stop_signal();
  return result;
}

int finish_clip(const RunFolder& folder, const std::vector<int>& frames, const Scene& scene, Progress& progress) {
  const Door door(folder.presence());
  if (!door.is_ours()) return stop_signal();
  PictureRecord record = read_picture_record(folder.pictures()).value_or(PictureRecord{});
  const std::vector<Worker> others = with_role(folder.presence().others(), {draws_for_clip});
  const std::vector<int> all = all_frames(scene.clip.frames);
  const bool is_shared = record.clip_is_shared || !others.empty();
  if (is_shared && frames != all && !all_there(folder, all)) {
    progress.note(others.empty() ? "no clip: not all frames are drawn; umax encode makes it when they are"
                                 : "the clip is left to " + describe(others.front()) + ", which is still drawing");
    record.clip_is_shared = true;
    write_picture_record(folder.pictures(), record);
    return 0;
  }
  const std::vector<int>& wanted = is_shared ? all : frames;
  record.clip_is_shared = !others.empty();  // who comes last finds it done
  if (is_current(folder, record, wanted)) {
    if (is_shared || record.frames != wanted) write_clip_record(folder, wanted, record);  // who made it may have died
    return 0;
  }
  encode_and_record(folder, wanted, scene, record, progress);
  if (wanted != all)
    progress.note("the clip is of frames " + frame_list_text(wanted) + " alone; umax encode makes that of all");
  return 0;
}

int make_clip(const RunFolder& folder, const std::vector<int>& frames, const Scene& scene, Progress& progress) {
  const Door door(folder.presence());
  if (!door.is_ours()) return stop_signal();
  tidy(folder);
  PictureRecord record = read_picture_record(folder.pictures()).value_or(PictureRecord{});
  record.clip_is_shared = false;
  encode_and_record(folder, frames, scene, record, progress);
  return 0;
}

}  // namespace umax
