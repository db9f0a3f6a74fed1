#include "embedding/mesh_files/mesh_io.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "embedding/hex_files/hex_mesh_io.h"
#include "embedding/mesh_files/foreign_mesh.h"
#include "embedding/mesh_files/mesh_formats.h"
#include "embedding/scanning/file_checks.h"
#include "embedding/surface/hex_faces.h"

namespace umax {
namespace {

constexpr std::array<const char*, 11> known_endings{"obj", "ply", "stl", "off", "gltf", "glb",
                                                    "fbx", "dae", "msh", "vtk", "vtu"};

void require_triangles(const std::filesystem::path& path, const TriangleMesh& mesh) {
  if (mesh.num_vertices() == 0) refuse_mesh(path, "the mesh has no vertices", "0", "export the mesh again");
  if (mesh.num_triangles() == 0)
    refuse_mesh(path, "the mesh has no triangles", fmt::format("{} vertices", mesh.num_vertices()),
                "export it with its faces");
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t)
    if (mesh.triangles.row(t).minCoeff() < 0 || mesh.triangles.row(t).maxCoeff() >= mesh.num_vertices())
      refuse_mesh(path, fmt::format("triangle {} names a vertex that does not exist", t),
                  fmt::format("{} of {} vertices", mesh.triangles.row(t).maxCoeff(), mesh.num_vertices()),
                  "the file is damaged: export it again");
}

/// A triangle that names a vertex twice encloses nothing and would spoil its neighbours' edges.
void leave_out_collapsed_triangles(MeshFile& file) {
  TriangleMesh& mesh = file.mesh;
  const bool has_texture = mesh.texture_coordinates.rows() > 0;
  Eigen::Index kept = 0;
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    const Eigen::RowVector3i triangle = mesh.triangles.row(t);
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0]) continue;
    mesh.triangles.row(kept) = triangle;
    if (!mesh.materials.empty()) mesh.materials[std::size_t(kept)] = mesh.materials[std::size_t(t)];
    if (has_texture && kept != t)
      mesh.texture_coordinates.middleRows<3>(3 * kept) = mesh.texture_coordinates.middleRows<3>(3 * t).eval();
    ++kept;
  }
  const Eigen::Index left_out = mesh.num_triangles() - kept;
  if (left_out == 0) return;
  mesh.triangles.conservativeResize(kept, 3);
  if (!mesh.materials.empty()) mesh.materials.resize(std::size_t(kept));
  if (has_texture) mesh.texture_coordinates.conservativeResize(3 * kept, 2);
  file.notes.push_back(left_out == 1 ? "1 triangle names a vertex twice: left out"
                                     : fmt::format("{} triangles name a vertex twice: left out", left_out));
}

/// Notes the vertices whose place is -1, for whoever needs all that the file has.
void keep_apart(const std::vector<int>& place, Eigen::Index num_loose, MeshFile& file) {
  const TriangleMesh& mesh = file.mesh;
  const bool has_colors = mesh.colors.rows() > 0;
  file.loose_vertices.resize(num_loose, 3);
  if (has_colors) file.loose_colors.resize(num_loose, 3);
  Eigen::Index loose = 0;
  for (std::size_t v = 0; v < place.size(); ++v) {
    if (place[v] >= 0) continue;
    file.loose_vertices.row(loose) = mesh.positions.row(Eigen::Index(v));
    if (has_colors) file.loose_colors.row(loose) = mesh.colors.row(Eigen::Index(v));
    ++loose;
  }
}

/// A vertex of no triangle would need a hex of its own, and pictures would not show why.
void leave_out_loose_vertices(MeshFile& file) {
  TriangleMesh& mesh = file.mesh;
  std::vector<int> place(std::size_t(mesh.num_vertices()), -1);
  for (const int corner : mesh.triangles.reshaped()) place[std::size_t(corner)] = 0;
  const auto num_loose = std::count(place.begin(), place.end(), -1);
  if (num_loose == 0) return;
  keep_apart(place, num_loose, file);
  for (std::size_t v = 0; v < place.size(); ++v) {
    if (place[v] < 0) continue;
    const auto kept = Eigen::Index(file.vertex_in_file.size());
    place[v] = int(kept);
    file.vertex_in_file.push_back(int(v));
    mesh.positions.row(kept) = mesh.positions.row(Eigen::Index(v)).eval();
    if (mesh.colors.rows() > 0) mesh.colors.row(kept) = mesh.colors.row(Eigen::Index(v)).eval();
  }
  const auto num_kept = Eigen::Index(file.vertex_in_file.size());
  mesh.positions.conservativeResize(num_kept, 3);
  if (mesh.colors.rows() > 0) mesh.colors.conservativeResize(num_kept, 3);
  for (int& corner : mesh.triangles.reshaped()) corner = place[std::size_t(corner)];
  file.notes.push_back(num_loose == 1 ? "1 vertex belongs to no triangle: left out"
                                      : fmt::format("{} vertices belong to no triangle: left out", num_loose));
}

void require_area(const std::filesystem::path& path, const TriangleMesh& mesh) {
  constexpr double rounding = 1e-12;  // of the extent squared
  const double extent = (mesh.positions.colwise().maxCoeff() - mesh.positions.colwise().minCoeff()).maxCoeff();
  double area = 0;
  for (const auto& triangle : mesh.triangles.rowwise()) {
    const Vector3d a = mesh.positions.row(triangle[0]), b = mesh.positions.row(triangle[1]),
                   c = mesh.positions.row(triangle[2]);
    area += 0.5 * (b - a).cross(c - a).norm();
  }
  if (!(area > rounding * extent * extent))
    refuse_mesh(path, "no triangle of the mesh has an area", fmt::format("{} triangles", mesh.num_triangles()),
                "export the surface of a solid shape");
}

MeshFile surface_of_hexes(const std::filesystem::path& path) {
  HexMesh hexes = load_hex_mesh(path);
  MeshFile file;
  file.mesh = surface_of(hexes.nodes, hexes.hexes).mesh;
  file.notes = std::move(hexes.notes);
  file.num_parts = 1;
  return file;
}

MeshFile read_by_ending(const std::filesystem::path& path, const std::string& ending) {
  if (ending == "obj") return read_obj(path);
  if (ending == "ply") return read_ply(path);
  if (ending == "off") return read_off(path);
  if (ending == "stl") return read_stl(path);
  return read_foreign(path, ending, import_limits(path));
}

}  // namespace

std::string known_mesh_formats() {
  return fmt::format("{}", fmt::join(known_endings, ", "));
}

MeshFile load_mesh(const std::filesystem::path& path) {
  require_readable_file(path);
  if (is_hex_mesh_file(path)) return surface_of_hexes(path);
  const std::string ending = lower_ending(path);
  if (std::find(known_endings.begin(), known_endings.end(), ending) == known_endings.end())
    refuse_mesh(path, "unknown mesh format", fmt::format("\"{}\"", ending), "known are " + known_mesh_formats());

  MeshFile file = read_by_ending(path, ending);
  require_triangles(path, file.mesh);
  leave_out_collapsed_triangles(file);
  if (file.mesh.num_triangles() > 0) leave_out_loose_vertices(file);
  require_finite(path, file.mesh.positions);
  require_sensible_box(path, file.mesh.positions);
  require_area(path, file.mesh);
  return file;
}

}  // namespace umax
