#include "embedding/mesh_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iterator>
#include <system_error>
#include <utility>

#include "core/error.h"
#include "embedding/hex_faces.h"
#include "embedding/hex_mesh_io.h"
#include "embedding/mesh_formats.h"

namespace umax {
namespace {

constexpr std::array<const char*, 11> known_endings{"obj", "ply", "stl", "off", "gltf", "glb",
                                                    "fbx", "dae", "msh", "vtk", "vtu"};
constexpr double largest_coordinate = 1e9;

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

MeshFile surface_of_hexes(const std::filesystem::path& path) {
  HexMesh hexes = load_hex_mesh(path);
  MeshFile file;
  file.mesh = surface_of(hexes.nodes, hexes.hexes).mesh;
  file.notes = std::move(hexes.notes);
  file.num_parts = 1;
  return file;
}

}  // namespace

void refuse_mesh(const std::filesystem::path& path, const std::string& what, const std::string& value,
                 const std::string& remedy) {
  throw Error(ExitCode::bad_data, {path.string(), what, value, remedy});
}

std::string lower_ending(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  if (!ending.empty()) ending.erase(0, 1);
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return ending;
}

void require_readable_file(const std::filesystem::path& path, const std::string& thing) {
  std::error_code error;
  const auto refuse_input = [&](const std::string& what, const char* remedy) {
    throw Error(ExitCode::not_found, {path.string(), what, "", remedy});
  };
  if (!std::filesystem::exists(path, error)) refuse_input("the " + thing + " does not exist", "check the path");
  if (std::filesystem::is_directory(path, error)) refuse_input("is a folder, not a " + thing, "name a file in it");
  if (!std::ifstream(path, std::ios::binary)) refuse_input("the " + thing + " cannot be read", "check its permissions");
  if (std::filesystem::is_regular_file(path, error) && std::filesystem::file_size(path, error) == 0)
    refuse_mesh(path, "the " + thing + " is empty", "0 bytes", "export it again");
}

std::string read_whole_file(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  if (in.bad()) refuse_mesh(path, "could not be read to its end", "", "check the disk");
  return text;
}

void require_finite(const std::filesystem::path& path, const Points& positions) {
  long long num_bad = 0;
  Eigen::Index first = -1;
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    if (!positions.row(v).allFinite() && num_bad++ == 0) first = v;
  if (num_bad > 0)
    refuse_mesh(path,
                fmt::format("{} of {} vertices are not finite numbers, the first is vertex {}", num_bad,
                            positions.rows(), first),
                fmt::format("({}, {}, {})", positions(first, 0), positions(first, 1), positions(first, 2)),
                "repair or export the mesh again");
}

void require_sensible_box(const std::filesystem::path& path, const Points& positions) {
  const double largest = positions.cwiseAbs().maxCoeff();
  if (largest > largest_coordinate)
    refuse_mesh(path, "coordinates are absurdly large (more than 1e9)", fmt::format("{:g}", largest),
                "check the file's unit, or scale it down");
  const Eigen::RowVector3d extent = positions.colwise().maxCoeff() - positions.colwise().minCoeff();
  if (!(extent.maxCoeff() > 1e-12 * std::max(largest, 1e-12)))
    refuse_mesh(path, "all vertices lie in one point", fmt::format("extent {:g}", extent.maxCoeff()),
                "give a mesh with an extent");
}

double linear_from_srgb(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

std::string known_mesh_formats() {
  return fmt::format("{}", fmt::join(known_endings, ", "));
}

MeshFile load_mesh(const std::filesystem::path& path) {
  require_readable_file(path);
  if (is_hex_mesh_file(path)) return surface_of_hexes(path);
  const std::string ending = lower_ending(path);
  if (std::find(known_endings.begin(), known_endings.end(), ending) == known_endings.end())
    refuse_mesh(path, "unknown mesh format", fmt::format("\"{}\"", ending), "known are " + known_mesh_formats());

  const long long promised = check_promised_size(path, ending);
  MeshFile file = ending == "obj" ? read_obj(path) : read_with_assimp(path, ending);
  require_triangles(path, file.mesh);
  if (promised >= 0 && promised != file.mesh.num_vertices())
    refuse_mesh(path, "the file does not hold the vertices that its header promises",
                fmt::format("{} of {}", file.mesh.num_vertices(), promised),
                "it is truncated or damaged: export it again");
  require_finite(path, file.mesh.positions);
  require_sensible_box(path, file.mesh.positions);
  return file;
}

}  // namespace umax
