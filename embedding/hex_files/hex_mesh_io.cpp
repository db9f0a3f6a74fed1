#include "embedding/hex_files/hex_mesh_io.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/element/hexahedron.h"
#include "core/files/read_file.h"
#include "embedding/hex_files/hex_mesh_formats.h"
#include "embedding/scanning/file_checks.h"
#include "embedding/surface/hex_faces.h"
#include "embedding/surface/topology.h"

namespace umax {
namespace {

using Path = std::filesystem::path;

constexpr std::size_t most_named = 5;  // of many faults, those that are told one by one

// a file with its hexes and what is left of its nodes
struct Parts {
  HexFile file;
  HexMesh mesh;
  std::vector<int> file_node;  // #N of every node that is kept

  std::string hex_name(Eigen::Index e) const {
    return fmt::format("{} {}", file.cell_word, file.hex_ids[std::size_t(e)]);
  }
  long long node_id(int node) const { return file.node_id(file_node[std::size_t(node)]); }
};

// "4 tetrahedra (the first is element 12)"
std::string tally(const HexFile& file, int dimension) {
  std::string text;
  for (const auto& [name, others] : file.others)
    if (others.dimension == dimension)
      text += fmt::format("{}{} {} (the first is {} {})", text.empty() ? "" : ", ", others.count, name, file.cell_word,
                          others.first_id);
  return text;
}

void require_hexes_only(const Path& path, const HexFile& file, std::vector<std::string>& notes) {
  const std::string remedy = "mesh it with 8-node hexahedra only; a surface is read from PLY, OBJ, STL …";
  if (const std::string solids = tally(file, 3); !solids.empty())
    refuse_mesh(path, "holds solid cells that are no 8-node hexahedra", solids, remedy);
  std::string others;
  for (int dimension = 0; dimension < 3; ++dimension)
    if (const std::string more = tally(file, dimension); !more.empty()) others += (others.empty() ? "" : ", ") + more;
  if (file.hexes.empty()) refuse_mesh(path, "holds no hexahedra", others.empty() ? "no cells" : others, remedy);
  if (!others.empty()) notes.push_back("left out: " + others);
}

// keeps the nodes that hexes use, in the file's order
void take_nodes(Parts& parts) {
  std::vector<int> kept(parts.file.nodes.size(), -1);
  for (const auto& hex : parts.file.hexes)
    for (const int node : hex) kept[std::size_t(node)] = 0;
  for (std::size_t node = 0; node < kept.size(); ++node)
    if (kept[node] == 0) {
      kept[node] = int(parts.file_node.size());
      parts.file_node.push_back(int(node));
    }
  HexMesh& mesh = parts.mesh;
  mesh.nodes.resize(Eigen::Index(parts.file_node.size()), 3);
  for (std::size_t n = 0; n < parts.file_node.size(); ++n)
    mesh.nodes.row(Eigen::Index(n)) = parts.file.nodes[std::size_t(parts.file_node[n])].transpose();
  mesh.hexes.resize(Eigen::Index(parts.file.hexes.size()), 8);
  for (Eigen::Index e = 0; e < mesh.hexes.rows(); ++e)
    for (int n = 0; n < 8; ++n) mesh.hexes(e, n) = kept[std::size_t(parts.file.hexes[std::size_t(e)][std::size_t(n)])];
  const std::size_t unused = kept.size() - parts.file_node.size();
  if (unused > 0) mesh.notes.push_back(fmt::format("left out: {} node{} of no hex", unused, unused == 1 ? "" : "s"));
}

void require_distinct_nodes(const Path& path, const Parts& parts) {
  const std::vector<int> welded = weld(parts.mesh.nodes);
  std::string named;
  std::size_t count = 0;
  for (int node = 0; node < int(welded.size()); ++node)
    if (welded[std::size_t(node)] != node && count++ < most_named)
      named += fmt::format("{}{} and {}", named.empty() ? "" : ", ", parts.node_id(welded[std::size_t(node)]),
                           parts.node_id(node));
  if (count > 0)
    refuse_mesh(path, fmt::format("{} nodes lie where another one lies, so that hexes hang apart there", count),
                "nodes " + named + (count > most_named ? " …" : ""),
                "merge them in the program that made the mesh (Gmsh: Coherence Mesh; ParaView: Clean to Grid)");
}

void require_upright_hexes(const Path& path, const Parts& parts) {
  const HexMesh& mesh = parts.mesh;
  const auto num_hexes = std::size_t(mesh.hexes.rows());
  std::size_t count = 0, mirrored = 0;
  std::string named;
  for (Eigen::Index e = 0; e < mesh.hexes.rows(); ++e) {
    Matrix8x3d nodes;
    for (int n = 0; n < 8; ++n) nodes.row(n) = mesh.nodes.row(mesh.hexes(e, n));
    const HexQuality quality = hex_quality(nodes.rowwise() - nodes.row(0));
    if (quality.usable) continue;
    mirrored += quality.least_determinant < 0 && quality.determinant_ratio > 0;  // negative everywhere
    if (count++ >= most_named) continue;
    const std::string place = quality.place < 8
                                  ? place_name(quality.place)
                                  : fmt::format("node {}", parts.node_id(mesh.hexes(e, quality.place - 8)));
    named += fmt::format("{}{} ({:.3g} at {})", named.empty() ? "" : ", ", parts.hex_name(e), quality.least_determinant,
                         place);
  }
  if (count == 0) return;
  if (count > most_named) named += " …";
  if (mirrored == num_hexes)
    refuse_mesh(path, "every hex is numbered as its mirror image: det(dX/ds) is negative everywhere", named,
                "in every hex, exchange the first four nodes with the last four");
  refuse_mesh(path,
              fmt::format("{} of {} hexes {} inverted or tangled: det(dX/ds) must be positive", count, num_hexes,
                          count == 1 ? "is" : "are"),
              named,
              "untangle the mesh, or mesh it again; a hex that is negative everywhere is numbered as its mirror image");
}

// the same four corners, but the other way round
bool are_opposite(const HexFace& a, const HexFace& b) {
  return a.corners[1] == b.corners[3] && a.corners[2] == b.corners[2] && a.corners[3] == b.corners[1];
}

void require_sound_faces(const Path& path, const Parts& parts) {
  for_each_face(hex_faces(parts.mesh.hexes), [&](auto first, auto last) {
    const auto num_hexes = last - first;
    if (num_hexes == 1 || (num_hexes == 2 && are_opposite(first[0], first[1]))) return;
    std::string hexes, nodes;
    for (auto face = first; face != last; ++face)
      hexes += (face == first ? "" : face + 1 == last ? " and " : ", ") + parts.hex_name(face->hex);
    for (const int node : first->corners) nodes += fmt::format(" {}", parts.node_id(node));
    refuse_mesh(path,
                num_hexes > 2 ? fmt::format("{} hexes share one face", num_hexes)
                              : "two hexes lie on the same side of the face that they share, or twist it",
                hexes + " with the nodes" + nodes, "remove cells that are there twice; mesh it again");
  });
}

VectorXd factors_of(const Path& path, const Parts& parts, const std::string& name) {
  const auto found = parts.file.cell_data.find(name);
  if (found == parts.file.cell_data.end()) return {};
  const std::vector<double>& values = found->second;
  VectorXd factors(parts.mesh.hexes.rows());
  for (Eigen::Index e = 0; e < factors.size(); ++e) {
    const bool there = std::size_t(e) < values.size();
    factors[e] = there ? values[std::size_t(e)] : 0;
    if (!(factors[e] > 0 && std::isfinite(factors[e])))
      refuse_mesh(path, fmt::format("cell data {} of {} must be positive and finite", name, parts.hex_name(e)),
                  there ? fmt::format("{:g}", factors[e]) : "none", "1 leaves the body's value as it is");
  }
  return factors;
}

HexFile read_by_ending(const Path& path) {
  const std::string ending = lower_ending(path), text = read_file(path);
  if (ending == "msh") return read_gmsh(path, text);
  if (ending == "vtk") return read_vtk_legacy(path, text);
  return read_vtu(path, text);
}

}  // namespace

bool is_hex_mesh_file(const Path& path) {
  const std::string ending = lower_ending(path);
  return ending == "msh" || ending == "vtk" || ending == "vtu";
}

HexMesh load_hex_mesh(const Path& path) {
  require_readable_file(path);
  if (!is_hex_mesh_file(path))
    refuse_mesh(path, "is no mesh of hexes by its name", '"' + lower_ending(path) + '"', "known are msh, vtk, vtu");
  Parts parts{.file = read_by_ending(path), .mesh = {}, .file_node = {}};
  require_hexes_only(path, parts.file, parts.mesh.notes);
  take_nodes(parts);
  require_finite(path, parts.mesh.nodes);
  require_sensible_box(path, parts.mesh.nodes);
  require_distinct_nodes(path, parts);
  require_upright_hexes(path, parts);
  require_sound_faces(path, parts);
  parts.mesh.young_factor = factors_of(path, parts, "young_factor");
  parts.mesh.limit_factor = factors_of(path, parts, "limit_factor");
  return std::move(parts.mesh);
}

}  // namespace umax
