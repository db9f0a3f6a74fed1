// The readers behind load_hex_mesh(): each fills what the file holds; load_hex_mesh() does the checks that all formats
// share.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/base/types.h"

namespace umax {

/// What kind of cell a number in a file means.
struct CellKind {
  int type = 0;           // the format's number
  const char* name = "";  // plural
  int dimension = 0;
  int num_nodes = 0;  // -1: as many as the file says
};

struct HexFile {
  struct Others {
    int dimension = 0;
    long long count = 0, first_id = 0;
  };
  const char* cell_word = "cell";                        // what the format calls a cell
  std::vector<Vector3d> nodes;                           // all of the file
  std::vector<long long> node_ids;                       // the file's names of them; empty: 0, 1, 2 …
  std::vector<std::array<int, 8>> hexes;                 // local order: core/element/hexahedron.h
  std::vector<long long> hex_ids;                        // the file's names of them
  std::map<std::string, Others> others;                  // cells that are no hexes, by name
  std::map<std::string, std::vector<double>> cell_data;  // "young_factor", "limit_factor" by hex; absent: none

  long long node_id(int node) const { return node_ids.empty() ? node : node_ids[std::size_t(node)]; }
};

/// VTK's and Gmsh's number of a kind of cell; null: unknown.
const CellKind* vtk_cell_kind(int type);
const CellKind* gmsh_cell_kind(int type);

/// Takes a cell whose nodes come in VTK's order (Gmsh's is the same for 8-node hexes): a hex, or one of the others.
void add_cell(HexFile& file, const CellKind& kind, long long id, const int* nodes);

/// Cells as VTK has them: types, ends of each cell's nodes and the nodes. first_cell and first_node are added to the
/// numbers of a file in pieces. Throws Error (bad_data) naming the cell whose nodes are not there.
struct VtkCells {
  std::vector<double> types = {}, ends = {}, nodes = {};
  long long first_cell = 0, first_node = 0;
};
void add_vtk_cells(const std::filesystem::path& path, const VtkCells& cells, HexFile& file);

/// Keeps the hexes' share of cell data under the names that mean something; values: one per cell of the piece.
void add_vtk_cell_data(const std::string& name, const std::vector<double>& values, long long first_cell, HexFile& file);
bool is_known_cell_data(const std::string& name);

HexFile read_gmsh(const std::filesystem::path& path, const std::string& text);
HexFile read_vtk_legacy(const std::filesystem::path& path, const std::string& text);
HexFile read_vtu(const std::filesystem::path& path, const std::string& text);

}  // namespace umax
