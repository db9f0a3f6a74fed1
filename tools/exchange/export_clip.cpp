#include "tools/exchange/export_clip.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <variant>

#include "core/base/error.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "embedding/caches/alembic_file.h"
#include "embedding/caches/gltf_file.h"
#include "embedding/caches/mesh_sequence.h"
#include "embedding/caches/obj_file.h"
#include "embedding/caches/ply_file.h"
#include "embedding/caches/point_cache.h"
#include "embedding/caches/usda_file.h"
#include "tools/exchange/export_cages.h"
#include "tools/exchange/export_files.h"
#include "tools/system/signals.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

using SurfaceWriter = std::variant<PointCacheWriter, MeshSequenceWriter, AlembicWriter, UsdaWriter, GltfWriter>;

MeshFileKind mesh_kind(ExportFormat format) {
  return format == ExportFormat::ply ? MeshFileKind::ply : MeshFileKind::obj;
}

/// What an export works with.
struct ExportInHand {
  const Simulation& simulation;
  const ExportOptions& options;
  const FormatTraits& format;
  const ClipSpace& clip;
  ExportFolder& folder;
  std::optional<ClipCamera> camera = std::nullopt;  // of formats that have one
};

/// The files that frames of a moving thing go to.
std::vector<fs::path> frame_files(const ExportInHand& hand, const ExportedThing& thing) {
  const fs::path file = hand.folder.file_of(thing, hand.format);
  if (hand.options.format == ExportFormat::gltf) return {file, fs::path(file).replace_extension(".bin")};
  if (!hand.format.is_sequence || !thing.surface.moves) return {file};
  std::vector<fs::path> files;
  for (const int frame : hand.clip.frames) files.push_back(sequence_file(file, frame, hand.format.ending));
  return files;
}

/// Where a thing's material and texture stand: beside its meshes.
fs::path folder_beside(const ExportInHand& hand, const ExportedThing& thing) {
  const bool in_folder = hand.format.is_sequence && thing.surface.moves;
  return in_folder ? hand.folder.file_of(thing, hand.format) : hand.folder.path();
}

/// ".png", ".jpg" …; of a picture inside of a mesh file by its first bytes.
std::string ending_of(const ExportedTexture& texture) {
  if (!texture.bytes) return texture.file.extension().string();
  return texture.bytes->starts_with("\x89PNG") ? ".png" : ".jpg";
}

/// glTF knows PNG and JPEG only.
bool takes_texture(ExportFormat format, const ExportedTexture& texture) {
  if (!texture.is_there()) return false;
  const std::string ending = ending_of(texture);
  return format != ExportFormat::gltf || ending == ".png" || ending == ".jpg" || ending == ".jpeg";
}

bool are_same(const ExportedTexture& a, const ExportedTexture& b) {
  return a.file == b.file && a.bytes == b.bytes;
}

/// Puts the textures beside the thing's files, each once, and names them in its materials.
void copy_textures(const ExportInHand& hand, ExportedThing& thing) {
  int count = 0;
  for (std::size_t i = 0; i < thing.textures.size(); ++i) {
    const ExportedTexture& texture = thing.textures[i];
    if (!takes_texture(hand.options.format, texture)) continue;
    const auto first = std::find_if(thing.textures.begin(), thing.textures.end(),
                                    [&](const ExportedTexture& other) { return are_same(other, texture); });
    std::string& name = thing.surface.materials[i].texture;
    if (const auto known = std::size_t(first - thing.textures.begin()); known < i) {
      name = thing.surface.materials[known].texture;
      continue;
    }
    name = thing.stem + (++count > 1 ? fmt::format(".{}", count) : "") + ending_of(texture);
    const fs::path copy = folder_beside(hand, thing) / name;
    hand.folder.claim_plain({copy});
    hand.folder.write_shared(copy, texture.bytes ? *texture.bytes : read_file(texture.file));
  }
}

/// Materials of a thing whose meshes are OBJ.
void write_material(const ExportInHand& hand, const ExportedThing& thing) {
  const fs::path material = folder_beside(hand, thing) / thing.surface.library;
  hand.folder.claim_plain({material});
  hand.folder.write_shared(material, mtl_text(thing.surface));
}

/// The mesh at rest, in the cache's order of vertices; of what does not move, all there is. Importers of OBJ leave
/// vertices of no triangle out, those of PLY do not.
void write_rest(const ExportInHand& hand, const ExportedThing& thing) {
  const auto write = [&](const char* ending, const std::string& bytes) {
    const fs::path path = hand.folder.path() / (thing.stem + ending);
    hand.folder.claim_still({path});
    hand.folder.write_shared(path, bytes);
  };
  write(".obj", obj_text(thing.surface, thing.surface.rest));
  if (!hand.format.is_cache || thing.loose_in_file.empty()) return;
  SurfaceFrame rest;
  rest.positions = thing.surface.rest;
  write(".ply", ply_bytes(thing.surface, rest));
}

/// The whole file of a thing that does not move.
void write_still(const ExportInHand& hand, const ExportedThing& thing, const State& first) {
  const fs::path file = hand.folder.file_of(thing, hand.format);
  SurfaceFrame shape = sample(hand.simulation, thing, hand.options, hand.clip.frames.front(), first);
  if (hand.options.format == ExportFormat::ply) {  // whatever the frames, it is the same
    shape.frame = 1;
    shape.time = 0;
    hand.folder.claim_still({file});
    hand.folder.write_shared(file, ply_bytes(thing.surface, shape));
  } else if (hand.options.format == ExportFormat::usd) {
    write_file(file, still_usda(thing.surface, shape, hand.clip));
  } else if (hand.options.format == ExportFormat::abc) {
    AlembicWriter writer(file, thing.surface, hand.clip);
    writer.append(shape);
    writer.finish();
  } else {
    GltfWriter writer(file, thing.surface, hand.clip, hand.camera);
    writer.append(shape);
    writer.finish();
  }
}

/// All that does not wait for frames.
void write_still_parts(const ExportInHand& hand, ExportedThing& thing, const State& first) {
  if (hand.format.holds_hexes) return;
  const bool is_obj = hand.options.format == ExportFormat::obj;
  copy_textures(hand, thing);
  if (hand.format.is_cache || is_obj) write_material(hand, thing);
  if (hand.format.is_cache || (is_obj && !thing.surface.moves))
    write_rest(hand, thing);
  else if (!thing.surface.moves)
    write_still(hand, thing, first);
}

/// A file of all things together: USD's stage, Alembic's camera. No thing has its name.
fs::path shared_file(const ExportInHand& hand, const std::vector<ExportedThing>& things) {
  std::string stem = hand.options.format == ExportFormat::abc ? "camera" : "scene";
  while (std::any_of(things.begin(), things.end(), [&](const ExportedThing& thing) { return thing.stem == stem; }))
    stem += "_";
  return hand.folder.path() / (stem + "." + hand.format.ending);
}

bool has_shared_file(ExportFormat format) {
  return format == ExportFormat::usd || format == ExportFormat::abc;
}

void write_stage(const ExportInHand& hand, const std::vector<ExportedThing>& things) {
  std::vector<StagePart> parts;
  for (const ExportedThing& thing : things) {
    std::string name = usd_name(thing.stem);
    const auto is_taken = [&](const StagePart& part) { return part.name == name; };
    while (name == "camera" || std::any_of(parts.begin(), parts.end(), is_taken)) name += "_";
    parts.push_back({name, hand.folder.file_of(thing, hand.format).filename().string()});
  }
  write_file(shared_file(hand, things), stage_usda(parts, *hand.camera, hand.clip));
}

/// Finds out what is in the way before anything is written.
void require_room(const ExportInHand& hand, const std::vector<ExportedThing>& things) {
  for (const ExportedThing& thing : things) {
    if (hand.format.is_sequence && thing.surface.moves)
      hand.folder.make_folder(hand.folder.file_of(thing, hand.format));
    if ((hand.format.is_cache || hand.format.is_sequence) && !thing.surface.moves) continue;  // shared by exports
    const std::vector<fs::path> files = frame_files(hand, thing);
    for (const fs::path& file : files) hand.folder.require_new(file);
    hand.folder.claim(files);
  }
  if (has_shared_file(hand.options.format)) {
    hand.folder.require_new(shared_file(hand, things));
    hand.folder.claim({shared_file(hand, things)});
  }
  if (hand.format.holds_hexes) hand.folder.claim({cage_index_file(hand.folder.path())});
}

/// Where frames go.
struct Stream {
  std::function<void(int frame, const State&)> append;
  std::function<void()> finish;
};

SurfaceWriter make_writer(const ExportInHand& hand, const ExportedThing& thing) {
  const fs::path file = hand.folder.file_of(thing, hand.format);
  if (hand.format.is_sequence) return MeshSequenceWriter(file, mesh_kind(hand.options.format), thing.surface);
  if (hand.options.format == ExportFormat::abc) return AlembicWriter(file, thing.surface, hand.clip);
  if (hand.options.format == ExportFormat::usd) return UsdaWriter(file, thing.surface, hand.clip);
  if (hand.options.format == ExportFormat::gltf) return GltfWriter(file, thing.surface, hand.clip, hand.camera);
  return PointCacheWriter(file, hand.options.format == ExportFormat::mdd ? PointCacheKind::mdd : PointCacheKind::pc2,
                          thing.surface.num_vertices(), hand.clip);
}

Stream surface_stream(const ExportInHand& hand, const ExportedThing& thing) {
  const auto writer = std::make_shared<SurfaceWriter>(make_writer(hand, thing));
  const auto append = [&hand, &thing, writer](int frame, const State& state) {
    const SurfaceFrame shape = sample(hand.simulation, thing, hand.options, frame, state);
    std::visit([&](auto& kind) { kind.append(shape); }, *writer);
  };
  const auto finish = [&hand, writer] {
    std::visit([](auto& kind) { kind.finish(); }, *writer);
    const auto* usda = std::get_if<UsdaWriter>(writer.get());
    if (!usda) return;
    hand.folder.claim(usda->files());
    hand.folder.keep_only(usda->folder_of_clips(), usda->files());
  };
  return {append, finish};
}

std::vector<Stream> open_streams(const ExportInHand& hand, const std::vector<ExportedThing>& things) {
  std::vector<Stream> streams;
  if (hand.format.holds_hexes) {
    const fs::path& folder = hand.folder.path();
    streams.push_back({[&hand, &things, folder](int frame, const State& state) {
                         write_cages(hand.simulation, things, hand.options, folder, frame, state);
                       },
                       [&hand, &things, folder] { write_cage_index(hand.simulation.scene.clip, things, folder); }});
    return streams;
  }
  for (const ExportedThing& thing : things)
    if (thing.surface.moves) streams.push_back(surface_stream(hand, thing));
  if (hand.options.format == ExportFormat::usd)
    streams.push_back({[](int, const State&) {}, [&hand, &things] { write_stage(hand, things); }});
  if (hand.options.format == ExportFormat::abc)
    streams.push_back({[](int, const State&) {},
                       [&hand, &things] { write_alembic_camera(shared_file(hand, things), *hand.camera, hand.clip); }});
  return streams;
}

/// Returns the signal that stopped it, or 0.
int write_frames(const ExportInHand& hand, const ClipSource& source, const std::vector<Stream>& streams,
                 Progress& progress) {
  progress.begin("export", int(hand.clip.frames.size()));
  for (const int frame : hand.clip.frames) {
    if (stop_signal() != 0) break;
    const State state = source.state(frame);
    for (const Stream& stream : streams) stream.append(frame, state);
    progress.frame_done(frame);
  }
  progress.end();
  return stop_signal();
}

}  // namespace

void check_export(const ExportOptions& options, const std::vector<int>& frames) {
  if (!(options.scale > 0) || !std::isfinite(options.scale))
    throw Error(Fault::usage, {.where = "--scale",
                               .what = "must be a positive number",
                               .value = fmt::format("{:g}", options.scale),
                               .remedy = "give a factor such as 100 for centimetres"});
  if (options.format == ExportFormat::pc2 && !is_evenly_spaced(frames))
    throw Error(Fault::usage, {.where = "--frames",
                               .what = "PC2 holds frames at equal distances only",
                               .remedy = "give such frames (1-40, 1-99x2), or export mdd, which holds any"});
  if (options.format == ExportFormat::gltf && options.z_up)
    throw Error(Fault::usage, {.where = "--up",
                               .what = "glTF has y up always",
                               .value = "z",
                               .remedy = "leave --up out: programs turn it as they need"});
}

ExportResult export_clip(const Simulation& simulation, const ClipSource& source, const std::vector<int>& frames,
                         const fs::path& path, const ExportOptions& options, Progress& progress) {
  check_export(options, frames);
  std::vector<ExportedThing> things = things_to_export(simulation, options);
  const State first = source.state(frames.front());
  ExportFolder folder(path, options.overwrite, label_of(options, frames));
  const ClipSpace clip{
      .fps = simulation.scene.clip.fps, .frames = frames, .z_up = options.z_up, .unit = 1 / options.scale};
  ExportInHand hand{simulation, options, traits_of(options.format), clip, folder};
  if (!options.overwrite)
    refuse_misfits(path, options, "replace all such files with --overwrite, or choose another folder with -o");
  else if (const std::string removed = folder.remove_misfits(); !removed.empty())
    progress.note(removed);
  require_room(hand, things);
  if (hand.format.has_camera) hand.camera = exported_camera(source.camera(), simulation.scene.render, options);
  for (ExportedThing& thing : things) write_still_parts(hand, thing, first);

  const std::vector<Stream> streams = open_streams(hand, things);
  ExportResult result;
  result.signal = write_frames(hand, source, streams, progress);
  if (result.signal != 0) return result;
  for (const Stream& stream : streams) stream.finish();
  for (const ExportedThing& thing : things) result.files.push_back(folder.file_of(thing, hand.format));
  return result;
}

}  // namespace umax
