// Meshes: whatever the bytes are, what is accepted can be worked with.
#include <cmath>

#include "embedding/hex_files/hex_mesh_io.h"
#include "embedding/mesh_files/mesh_io.h"
#include "tests/fuzz/fuzz_target.h"

namespace umax::fuzz {
namespace {

/// Whether all corners are rows of a table with so many.
template <class Corners>
bool all_below(const Corners& corners, Eigen::Index rows) {
  return corners.size() > 0 && corners.minCoeff() >= 0 && corners.maxCoeff() < rows;
}

void load_surface(std::string_view bytes, const char* name) {
  const auto path = as_file(bytes, name);
  accepts([&] {
    const MeshFile file = load_mesh(path);
    const TriangleMesh& mesh = file.mesh;
    require(mesh.positions.allFinite(), "a mesh has finite vertices");
    require(all_below(mesh.triangles, mesh.num_vertices()), "triangles name vertices that there are");
    require(mesh.colors.rows() == 0 || mesh.colors.rows() == mesh.num_vertices(), "every vertex has a colour, or none");
    require(mesh.texture_coordinates.rows() == 0 || mesh.texture_coordinates.rows() == 3 * mesh.num_triangles(),
            "every corner has a place in the texture, or none");
    require(mesh.materials.empty() || Eigen::Index(mesh.materials.size()) == mesh.num_triangles(),
            "every triangle has a material, or none");
    for (const int material : mesh.materials)
      require(material >= 0 && material < int(file.materials.size()), "triangles name materials that there are");
    require(file.vertex_in_file.empty() || Eigen::Index(file.vertex_in_file.size()) == mesh.num_vertices(),
            "every vertex has its place in the file");
  });
}

}  // namespace

void read_mesh(std::string_view bytes) {
  if (bytes.starts_with("ply")) return load_surface(bytes, "mesh.ply");
  if (bytes.starts_with("OFF") || bytes.starts_with("COFF")) return load_surface(bytes, "mesh.off");
  if (bytes.starts_with("solid") || (bytes.size() > 84 && bytes[0] == ' ')) return load_surface(bytes, "mesh.stl");
  load_surface(bytes, "mesh.obj");
}

void read_hexes(std::string_view bytes) {
  const auto path = as_file(bytes, bytes.starts_with("$")   ? "hexes.msh"
                                   : bytes.starts_with("#") ? "hexes.vtk"
                                                            : "hexes.vtu");
  accepts([&] {
    const HexMesh mesh = load_hex_mesh(path);
    require(mesh.nodes.allFinite(), "a mesh of hexes has finite nodes");
    require(all_below(mesh.hexes, mesh.nodes.rows()), "hexes name nodes that there are");
    for (const VectorXd* factors : {&mesh.young_factor, &mesh.limit_factor}) {
      require(factors->size() == 0 || factors->size() == mesh.hexes.rows(), "every hex has a factor, or none");
      require((factors->array() > 0).all() && factors->allFinite(), "factors are positive");
    }
  });
}

}  // namespace umax::fuzz
