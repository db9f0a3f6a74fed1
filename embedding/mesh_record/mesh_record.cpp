#include "embedding/mesh_record/mesh_record.h"

#include <sys/mman.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <type_traits>
#include <utility>

namespace umax {
namespace {

constexpr std::string_view mesh_mark = "umax mesh", error_mark = "umax err.", end_mark = "end.";

/// What a record consists of; Writer and Reader visit it in the same order.
template <class Visitor, class File>
void visit_file(Visitor& visit, File& file) {
  visit(file.mesh.positions);
  visit(file.mesh.triangles);
  visit(file.mesh.texture_coordinates);
  visit(file.mesh.colors);
  visit(file.mesh.materials);
  visit(file.unit);
  visit(file.up);
  visit(file.materials);
  visit(file.embedded_textures);
  visit(file.notes);
  visit(file.num_parts);
}
template <class Visitor, class Material>
void visit_material(Visitor& visit, Material& material) {
  visit(material.name);
  visit(material.color);
  visit(material.texture_tint);
  visit(material.texture);
  visit(material.embedded_texture);
}

class Writer {
 public:
  explicit Writer(const PutBytes& put) : put_(put) {}

  template <class T>
    requires std::is_arithmetic_v<T>
  void operator()(const T& value) {
    put_({reinterpret_cast<const char*>(&value), sizeof value});
  }
  void operator()(const std::string& text) {
    (*this)(std::uint64_t(text.size()));
    put_(text);
  }
  void operator()(const std::filesystem::path& path) { (*this)(path.native()); }
  void operator()(const MeshMaterial& material) { visit_material(*this, material); }
  template <class Scalar, int rows, int columns, int options>
  void operator()(const Eigen::Matrix<Scalar, rows, columns, options>& matrix) {
    (*this)(std::uint64_t(matrix.rows()));
    put_({reinterpret_cast<const char*>(matrix.data()), std::size_t(matrix.size()) * sizeof(Scalar)});
  }
  template <class T>
  void operator()(const std::optional<T>& value) {
    (*this)(std::uint8_t(value.has_value()));
    if (value) (*this)(*value);
  }
  template <class T>
  void operator()(const std::vector<T>& values) {
    (*this)(std::uint64_t(values.size()));
    if constexpr (std::is_arithmetic_v<T>)
      put_({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)});
    else
      for (const T& value : values) (*this)(value);
  }

 private:
  const PutBytes& put_;
};

/// Fresh memory comes in pages of 2 MiB where the system has them: a million triangles touch 6,000 small ones.
void ask_for_large_pages(void* memory, std::size_t bytes) {
  constexpr std::uintptr_t page = 2 << 20;
  const auto start = reinterpret_cast<std::uintptr_t>(memory);
  const std::uintptr_t first = (start + page - 1) / page * page, end = (start + bytes) / page * page;
  if (first < end) ::madvise(reinterpret_cast<void*>(first), end - first, MADV_HUGEPAGE);
}

/// Trusts nothing: what does not fit into the bytes that are left ends the reading.
class Reader {
 public:
  explicit Reader(std::string_view bytes) : bytes_(bytes) {}

  bool is_sound() const { return sound_; }

  std::string_view take(std::uint64_t count) {
    sound_ = sound_ && count <= bytes_.size();
    if (!sound_) return {};
    const std::string_view taken = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return taken;
  }
  /// A number of things of at least so many bytes.
  std::size_t count(std::size_t bytes_each) {
    std::uint64_t value = 0;
    (*this)(value);
    sound_ = sound_ && value <= bytes_.size() / bytes_each;
    return sound_ ? std::size_t(value) : 0;
  }

  template <class T>
    requires std::is_arithmetic_v<T>
  void operator()(T& value) {
    const std::string_view taken = take(sizeof value);
    if (sound_) std::memcpy(&value, taken.data(), sizeof value);
  }
  void operator()(std::string& text) { text = take(count(1)); }
  void operator()(std::filesystem::path& path) {
    std::string text;
    (*this)(text);
    path = text;
  }
  void operator()(MeshMaterial& material) { visit_material(*this, material); }
  template <class Scalar, int rows, int columns, int options>
  void operator()(Eigen::Matrix<Scalar, rows, columns, options>& matrix) {
    const std::size_t row_bytes = sizeof(Scalar) * std::size_t(columns), num_rows = count(row_bytes);
    if constexpr (rows == Eigen::Dynamic)
      matrix.resize(Eigen::Index(num_rows), columns);
    else
      sound_ = sound_ && num_rows == std::size_t(rows);
    const std::string_view taken = take(num_rows * row_bytes);
    if (!sound_ || taken.empty()) return;
    ask_for_large_pages(matrix.data(), taken.size());
    std::memcpy(matrix.data(), taken.data(), taken.size());
  }
  template <class T>
  void operator()(std::optional<T>& value) {
    std::uint8_t has_value = 0;
    (*this)(has_value);
    if (has_value && sound_) (*this)(value.emplace());
  }
  template <class T>
  void operator()(std::vector<T>& values) {
    if constexpr (std::is_arithmetic_v<T>) {
      const std::string_view taken = take(count(sizeof(T)) * sizeof(T));
      values.resize(taken.size() / sizeof(T));
      if (!taken.empty()) std::memcpy(values.data(), taken.data(), taken.size());
    } else {
      const std::size_t size = count(1);
      for (std::size_t i = 0; i < size && sound_; ++i) (*this)(values.emplace_back());
    }
  }

 private:
  std::string_view bytes_;
  bool sound_ = true;
};

template <class Values>
bool is_empty_or(const Values& values, Eigen::Index count) {
  return Eigen::Index(values.size()) == 0 || Eigen::Index(values.size()) == count;
}

/// Whether the parts of the mesh belong together; corners of triangles are for others to check.
bool is_consistent(const MeshFile& file) {
  const TriangleMesh& mesh = file.mesh;
  const int num_materials = int(file.materials.size()), num_textures = int(file.embedded_textures.size());
  return is_empty_or(mesh.texture_coordinates, 6 * mesh.num_triangles()) &&
         is_empty_or(mesh.colors, 3 * mesh.num_vertices()) && is_empty_or(mesh.materials, mesh.num_triangles()) &&
         std::all_of(mesh.materials.begin(), mesh.materials.end(),
                     [&](int material) { return material >= 0 && material < num_materials; }) &&
         std::all_of(file.materials.begin(), file.materials.end(),
                     [&](const MeshMaterial& material) { return material.embedded_texture < num_textures; });
}

}  // namespace

void put_mesh_record(const MeshFile& file, const PutBytes& put) {
  Writer writer(put);
  put(mesh_mark);
  visit_file(writer, file);
  put(end_mark);
}

void put_error_record(const Error& error, const PutBytes& put) {
  Writer writer(put);
  put(error_mark);
  writer(int(error.fault()));
  for (const std::string& text : {error.text().what, error.text().value, error.text().remedy}) writer(text);
  put(end_mark);
}

std::optional<MeshFile> read_mesh_record(std::string_view bytes, const std::string& where) {
  Reader reader(bytes);
  const std::string_view mark = reader.take(mesh_mark.size());
  if (mark == error_mark) {
    int fault = 0;
    ErrorText text{.where = where};
    reader(fault);
    for (std::string* part : {&text.what, &text.value, &text.remedy}) reader(*part);
    const bool known = fault >= int(Fault::usage) && fault <= int(Fault::try_again);
    if (reader.take(end_mark.size()) == end_mark && known) throw Error(Fault(fault), text);
  }
  if (mark != mesh_mark) return std::nullopt;
  MeshFile file;
  visit_file(reader, file);
  if (reader.take(end_mark.size()) != end_mark || !is_consistent(file)) return std::nullopt;
  return file;
}

}  // namespace umax
