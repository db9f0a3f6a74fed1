#include "embedding/mesh_files/foreign_mesh.h"

#include <dlfcn.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "embedding/mesh_files/import_process.h"
#include "embedding/mesh_record/mesh_record.h"
#include "embedding/scanning/file_checks.h"

namespace umax {
namespace {

namespace fs = std::filesystem;

constexpr long long mebibyte = 1 << 20;

const char* const convert = "the file is damaged: export it again, or as OBJ or PLY";

fs::path find_helper(const fs::path& mesh) {
  std::string looked;
  std::error_code error;
  for (const fs::path& place : import_helper_places()) {
    if (fs::is_regular_file(place, error)) return place;
    looked += (looked.empty() ? "" : ", ") + place.string();
  }
  throw Error(Fault::unavailable,
              {.where = mesh.string(),
               .what = "the program umax-import, which reads this format, is not there (looked for " + looked + ")",
               .value = "",
               .remedy = "put it beside umax, or name it in the environment's UMAX_IMPORT"});
}

/// Records of triangles with positions are longer than the file by a third; more than this is not made room for.
long long likely_record_bytes(long long file_bytes) {
  constexpr long long most = 512 * mebibyte;
  return std::min(file_bytes + file_bytes / 2, most);
}

/// Bytes of the file, and of those beside it that a glTF keeps its numbers in.
long long size_with_buffers(const fs::path& path) {
  std::error_code error;
  auto size = (long long)(fs::file_size(path, error));
  if (error) return 0;
  if (lower_ending(path) != "gltf") return size;
  for (const auto& entry : fs::directory_iterator(path.has_parent_path() ? path.parent_path() : ".", error))
    if (lower_ending(entry.path()) == "bin" && entry.is_regular_file(error))
      size += (long long)(entry.file_size(error));
  return size;
}

std::string signal_text(int signal) {
  const char* name = ::sigdescr_np(signal);
  return fmt::format("signal {}{}", signal, name ? fmt::format(", {}", name) : "");
}

[[noreturn]] void refuse_end(const fs::path& path, const ImportEnd& end, const ImportLimits& limits) {
  if (end.kind == ImportEnd::Kind::timed_out)
    refuse_mesh(path, fmt::format("cannot be read within {} s", limits.seconds), "", convert);
  if (end.kind == ImportEnd::Kind::exited && end.number == import_out_of_memory)
    refuse_mesh(path, fmt::format("cannot be read within {} MiB of memory", limits.memory / mebibyte), "", convert);
  if (end.kind == ImportEnd::Kind::exited && end.number == import_other_version)
    throw Error(Fault::unavailable, {.where = path.string(),
                                     .what = "the program umax-import, which reads this format, is of another version",
                                     .value = "",
                                     .remedy = "install it and umax together"});
  if (end.kind == ImportEnd::Kind::exited && end.number == import_not_written)
    throw Error(Fault::io_error, {path.string(), "what was read cannot be handed over", "", "free some memory"});
  refuse_mesh(
      path, "makes the program that reads it fail",
      end.kind == ImportEnd::Kind::signalled ? signal_text(end.number) : fmt::format("exit code {}", end.number),
      convert);
}

}  // namespace

std::vector<fs::path> import_helper_places() {
  std::vector<fs::path> places;
  if (const char* named = std::getenv("UMAX_IMPORT"); named && *named) places.emplace_back(named);
  std::error_code error;
  std::vector<fs::path> holders{fs::read_symlink("/proc/self/exe", error)};
  Dl_info info{};
  if (::dladdr(reinterpret_cast<void*>(&import_helper_places), &info) != 0 && info.dli_fname)
    holders.emplace_back(info.dli_fname);
  for (const fs::path& holder : holders)
    // (a Python module is four folders below what it was installed in)
    for (const char* place : {"umax-import", "../libexec/umax/umax-import", "../../../../libexec/umax/umax-import"}) {
      if (!holder.is_absolute()) continue;  // as it was called: says nothing of where it is
      const fs::path path = (holder.parent_path() / place).lexically_normal();
      if (std::find(places.begin(), places.end(), path) == places.end()) places.push_back(path);
    }
  return places;
}

ImportLimits import_limits(const fs::path& path) {
  const long long size = size_with_buffers(path);
  return {.memory = 1024 * mebibyte + 64 * size, .seconds = 30 + size / mebibyte};
}

MeshFile read_foreign(const fs::path& path, const std::string& ending, const ImportLimits& limits) {
  ImportProcess process({find_helper(path).string(), std::to_string(mesh_record_version), std::to_string(limits.memory),
                         std::to_string(limits.seconds), ending, path.string()},
                        5 * limits.seconds, likely_record_bytes(size_with_buffers(path)));
  if (auto file = read_mesh_record(process.output(), path.string())) return std::move(*file);
  refuse_end(path, process.end(), limits);
}

}  // namespace umax
