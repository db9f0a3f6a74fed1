// Writes meshes of hexes in every format that is read, with the things that real files carry besides.
#pragma once

#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "core/model/lattice.h"
#include "tests/embedding/raw_bytes.h"
#include "tests/support/distorted.h"

namespace umax::testing {

/// Hexes as Gmsh and VTK number them: around the bottom, then around the top.
struct HexDocument {
  Points nodes;
  std::vector<std::array<int, 8>> hexes;
  std::vector<double> limit_factor;
};

/// Our order of a hex written down by hand: x slowest, z fastest, from VTK's picture of a hexahedron.
inline std::array<int, 8> vtk_order(const Hexes& hexes, Eigen::Index e) {
  const auto at = [&](int x, int y, int z) { return hexes(e, 4 * x + 2 * y + z); };
  return {at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0), at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)};
}

inline Lattice sample_lattice() {
  return test::distorted_lattice(make_box_lattice({3, 2, 2}, {-1, 0.25, 7}, {0.5, 0.4, 0.3}), 0.2);
}

inline HexDocument document_of(const Lattice& lattice) {
  HexDocument document;
  document.nodes = lattice.rest_positions;
  for (Eigen::Index e = 0; e < lattice.num_hexes(); ++e) {
    document.hexes.push_back(vtk_order(lattice.hexes, e));
    document.limit_factor.push_back(1 + 0.25 * double(e));
  }
  return document;
}

template <class T, class List>
std::string raw_list(const List& values, bool big_endian = false) {
  std::string bytes;
  for (const auto value : values) bytes += raw(T(value), big_endian);
  return bytes;
}
inline std::string text_list(const std::vector<double>& values) {
  std::string text;
  for (std::size_t i = 0; i < values.size(); ++i) text += fmt::format("{:.17g}{}", values[i], i % 6 == 5 ? "\n" : " ");
  return text + "\n";
}

// ---- Gmsh: tags with gaps, a quad and a point besides the hexes, other sections ----

inline int gmsh_tag(Eigen::Index node) {
  return 10 + 3 * int(node);
}

inline std::string gmsh_2(const HexDocument& mesh, bool binary) {
  const int num_nodes = int(mesh.nodes.rows()), num_hexes = int(mesh.hexes.size());
  std::string text = fmt::format("$MeshFormat\n2.2 {} 8\n{}$EndMeshFormat\n", int(binary), binary ? raw(1) + "\n" : "");
  text += "$PhysicalNames\n1\n3 1 \"jelly $Nodes\"\n$EndPhysicalNames\n";
  text += fmt::format("$Nodes\n{}\n", num_nodes);
  for (int n = 0; n < num_nodes; ++n) {
    const auto x = mesh.nodes.row(n);
    text += binary ? raw(gmsh_tag(n)) + raw(x[0]) + raw(x[1]) + raw(x[2])
                   : fmt::format("{} {:.17g} {:.17g} {:.17g}\n", gmsh_tag(n), x[0], x[1], x[2]);
  }
  text += std::string(binary ? "\n" : "") + fmt::format("$EndNodes\n$Elements\n{}\n", num_hexes + 1);
  const auto& first = mesh.hexes[0];
  if (binary) {
    text += raw(3) + raw(1) + raw(2) + raw(1) + raw(1) + raw(1);
    for (int k = 0; k < 4; ++k) text += raw(gmsh_tag(first[std::size_t(k)]));
    text += raw(5) + raw(num_hexes) + raw(2);
  } else {
    text += fmt::format("1 3 2 1 1 {} {} {} {}\n", gmsh_tag(first[0]), gmsh_tag(first[1]), gmsh_tag(first[2]),
                        gmsh_tag(first[3]));
  }
  for (int e = 0; e < num_hexes; ++e) {
    text += binary ? raw(e + 2) + raw(1) + raw(1) : fmt::format("{} 5 2 1 1", e + 2);
    for (const int node : mesh.hexes[std::size_t(e)])
      text += binary ? raw(gmsh_tag(node)) : fmt::format(" {}", gmsh_tag(node));
    if (!binary) text += "\n";
  }
  return text + (binary ? "\n" : "") + "$EndElements\n";
}

/// Text only, as that format is.
inline std::string gmsh_1(const HexDocument& mesh) {
  std::string text = fmt::format("$NOD\n{}\n", mesh.nodes.rows());
  for (Eigen::Index n = 0; n < mesh.nodes.rows(); ++n)
    text +=
        fmt::format("{} {:.17g} {:.17g} {:.17g}\n", gmsh_tag(n), mesh.nodes(n, 0), mesh.nodes(n, 1), mesh.nodes(n, 2));
  text += fmt::format("$ENDNOD\n$ELM\n{}\n", mesh.hexes.size() + 1);
  const auto& first = mesh.hexes[0];
  text += fmt::format("1 3 1 1 4 {} {} {} {}\n", gmsh_tag(first[0]), gmsh_tag(first[1]), gmsh_tag(first[2]),
                      gmsh_tag(first[3]));
  for (std::size_t e = 0; e < mesh.hexes.size(); ++e) {
    text += fmt::format("{} 5 1 1 8", e + 2);
    for (const int node : mesh.hexes[e]) text += fmt::format(" {}", gmsh_tag(node));
    text += "\n";
  }
  return text + "$ENDELM\n";
}

/// 4.0: each number of a node or element stands before what it is.
inline std::string gmsh_4_0(const HexDocument& mesh, bool binary) {
  using Size = std::uint64_t;
  const auto num_nodes = Size(mesh.nodes.rows()), num_hexes = Size(mesh.hexes.size());
  const auto small = [&](int value, char end) { return binary ? raw(value) : fmt::format("{}{}", value, end); };
  const auto large = [&](Size value, char end) { return binary ? raw(value) : fmt::format("{}{}", value, end); };
  const auto real = [&](double value, char end) { return binary ? raw(value) : fmt::format("{:.17g}{}", value, end); };
  const std::string line_end = binary ? "\n" : "";
  std::string text = fmt::format("$MeshFormat\n4 {} 8\n{}$EndMeshFormat\n", int(binary), binary ? raw(1) + "\n" : "");
  text += "$Entities\nnot looked into\n$EndEntities\n$Nodes\n" + large(2, ' ') + large(num_nodes, '\n');
  for (const auto& [dimension, begin, end] : {std::array<Size, 3>{2, 0, 2}, std::array<Size, 3>{3, 2, num_nodes}}) {
    text += small(1, ' ') + small(int(dimension), ' ') + small(dimension == 2, ' ') + large(end - begin, '\n');
    for (Size n = begin; n < end; ++n) {
      text += small(gmsh_tag(Eigen::Index(n)), ' ');
      for (int axis = 0; axis < 3; ++axis)
        text += real(mesh.nodes(Eigen::Index(n), axis), axis == 2 && dimension == 3 ? '\n' : ' ');
      if (dimension == 2) text += real(0.5, ' ') + real(0.25, '\n');
    }
  }
  text += line_end + "$EndNodes\n$Elements\n" + large(2, ' ') + large(num_hexes + 1, '\n');
  text += small(1, ' ') + small(0, ' ') + small(15, ' ') + large(1, '\n') + small(1, ' ') + small(gmsh_tag(0), '\n');
  text += small(1, ' ') + small(3, ' ') + small(5, ' ') + large(num_hexes, '\n');
  for (Size e = 0; e < num_hexes; ++e) {
    text += small(int(e) + 2, ' ');
    for (std::size_t k = 0; k < 8; ++k) text += small(gmsh_tag(mesh.hexes[e][k]), k == 7 ? '\n' : ' ');
  }
  return text + line_end + "$EndElements\n";
}

inline std::string gmsh_4(const HexDocument& mesh, bool binary) {
  using Size = std::uint64_t;
  const auto num_nodes = Size(mesh.nodes.rows()), num_hexes = Size(mesh.hexes.size());
  const auto small = [&](int value, char end) { return binary ? raw(value) : fmt::format("{}{}", value, end); };
  const auto large = [&](Size value, char end) { return binary ? raw(value) : fmt::format("{}{}", value, end); };
  const auto real = [&](double value, char end) { return binary ? raw(value) : fmt::format("{:.17g}{}", value, end); };
  const std::string line_end = binary ? "\n" : "";
  std::string text = fmt::format("$MeshFormat\n4.1 {} 8\n{}$EndMeshFormat\n", int(binary), binary ? raw(1) + "\n" : "");
  text += "$Entities\nnot looked into\n$EndEntities\n$Nodes\n";
  // a block of two nodes on a surface with its two parameters each, and the others
  text += large(2, ' ') + large(num_nodes, ' ') + large(Size(gmsh_tag(0)), ' ') +
          large(Size(gmsh_tag(Eigen::Index(num_nodes) - 1)), '\n');
  for (const auto& [dimension, begin, end] : {std::array<Size, 3>{2, 0, 2}, std::array<Size, 3>{3, 2, num_nodes}}) {
    text += small(int(dimension), ' ') + small(1, ' ') + small(dimension == 2, ' ') + large(end - begin, '\n');
    for (Size n = begin; n < end; ++n) text += large(Size(gmsh_tag(Eigen::Index(n))), '\n');
    for (Size n = begin; n < end; ++n) {
      for (int axis = 0; axis < 3; ++axis)
        text += real(mesh.nodes(Eigen::Index(n), axis), axis == 2 && dimension == 3 ? '\n' : ' ');
      if (dimension == 2) text += real(0.5, ' ') + real(0.25, '\n');
    }
  }
  text += line_end + "$EndNodes\n$Elements\n" + large(2, ' ') + large(num_hexes + 1, ' ') + large(1, ' ') +
          large(num_hexes + 1, '\n');
  text +=
      small(0, ' ') + small(1, ' ') + small(15, ' ') + large(1, '\n') + large(1, ' ') + large(Size(gmsh_tag(0)), '\n');
  text += small(3, ' ') + small(1, ' ') + small(5, ' ') + large(num_hexes, '\n');
  for (Size e = 0; e < num_hexes; ++e) {
    text += large(e + 2, ' ');
    for (std::size_t k = 0; k < 8; ++k) text += large(Size(gmsh_tag(mesh.hexes[e][k])), k == 7 ? '\n' : ' ');
  }
  return text + line_end + "$EndElements\n";
}

// ---- VTK legacy: the hexes, one vertex and cell data of several kinds ----

inline std::string vtk_legacy(const HexDocument& mesh, int version, bool binary) {
  const auto num_hexes = mesh.hexes.size(), num_cells = num_hexes + 1;
  std::vector<double> coordinates(mesh.nodes.data(), mesh.nodes.data() + mesh.nodes.size());
  std::vector<double> list, ends{0}, nodes, types, factors;
  const auto add = [&](const auto& cell, int type) {
    list.push_back(double(cell.size()));
    for (const int node : cell) list.push_back(node), nodes.push_back(node);
    ends.push_back(double(nodes.size()));
    types.push_back(type);
  };
  add(std::array<int, 1>{3}, 1);
  factors.push_back(-1);  // of the vertex: nobody asks
  for (std::size_t e = 0; e < num_hexes; ++e) add(mesh.hexes[e], 12), factors.push_back(mesh.limit_factor[e]);

  const auto doubles = [&](const auto& values) {
    return binary ? raw_list<double>(values, true) + "\n" : text_list(values);
  };
  const auto ints = [&](const auto& values) {
    return binary ? raw_list<std::int32_t>(values, true) + "\n" : text_list(values);
  };
  const auto longs = [&](const auto& values) {
    return binary ? raw_list<std::int64_t>(values, true) + "\n" : text_list(values);
  };
  std::string text = fmt::format("# vtk DataFile Version {}.{}\nby a test\n{}\nDATASET UNSTRUCTURED_GRID\n", version,
                                 version == 5 ? 1 : 0, binary ? "BINARY" : "ASCII");
  text += fmt::format("POINTS {} double\n", mesh.nodes.rows()) + doubles(coordinates);
  if (version == 5) {
    text += "METADATA\nINFORMATION 0\n\n";
    text += fmt::format("CELLS {} {}\nOFFSETS vtktypeint64\n", num_cells + 1, nodes.size()) + longs(ends);
    text += "CONNECTIVITY vtktypeint64\n" + longs(nodes);
  } else {
    text += fmt::format("CELLS {} {}\n", num_cells, list.size()) + ints(list);
  }
  text += fmt::format("CELL_TYPES {}\n", num_cells) + ints(types);
  text += fmt::format("CELL_DATA {}\nSCALARS group int 1\nLOOKUP_TABLE default\n", num_cells) + ints(types);
  text += fmt::format("FIELD FieldData 2\nthree 3 {} double\n", num_cells) +
          doubles(std::vector<double>(3 * num_cells, 0.5));
  text += fmt::format("limit_factor 1 {} double\n", num_cells) + doubles(factors);
  if (version == 5) text += "METADATA\nINFORMATION 0\n\n";
  text += fmt::format("POINT_DATA {}\nVECTORS limit_factor double\n", mesh.nodes.rows()) + doubles(coordinates);
  return text;
}

// ---- VTK XML ----

struct VtuStyle {
  std::string format = "ascii";     // "ascii", "binary" or "appended"
  std::string encoding = "base64";  // of appended data: "raw" or "base64"
  bool compressed = false, long_headers = false, big_endian = false;
};

/// Compressed in blocks of 100 bytes, so that there are several and a smaller last one.
inline std::string vtu_bytes(const std::string& data, const VtuStyle& style, bool encode) {
  const auto length = [&](std::size_t n) {
    return style.long_headers ? raw(std::uint64_t(n), style.big_endian) : raw(std::uint32_t(n), style.big_endian);
  };
  if (!style.compressed) return encode ? base64(length(data.size()) + data) : length(data.size()) + data;
  constexpr std::size_t block = 100;
  const std::size_t count = (data.size() + block - 1) / block;
  std::string header = length(count) + length(block) + length(data.size() % block), blocks;
  for (std::size_t b = 0; b < count; ++b) {
    const std::string part = data.substr(b * block, block);
    uLongf size = compressBound(uLong(part.size()));
    std::string compressed(size, '\0');
    compress(reinterpret_cast<Bytef*>(compressed.data()), &size, reinterpret_cast<const Bytef*>(part.data()),
             uLong(part.size()));
    header += length(size);
    blocks += compressed.substr(0, size);
  }
  return encode ? base64(header) + base64(blocks) : header + blocks;
}

inline std::string vtu(const HexDocument& mesh, const VtuStyle& style) {
  std::string appended;
  const auto array = [&](const std::string& attributes, const std::string& type, const std::string& bytes,
                         const std::vector<double>& values) {
    const std::string start = fmt::format("<DataArray type=\"{}\" {} format=\"{}\"", type, attributes, style.format);
    if (style.format == "ascii") return start + ">\n" + text_list(values) + "</DataArray>\n";
    if (style.format == "binary") return start + ">\n  " + vtu_bytes(bytes, style, true) + "\n</DataArray>\n";
    const std::string whole = start + fmt::format(" offset=\"{}\"/>\n", appended.size());
    appended += vtu_bytes(bytes, style, style.encoding == "base64");
    return whole;
  };
  const bool big = style.big_endian;
  const std::vector<double> coordinates(mesh.nodes.data(), mesh.nodes.data() + mesh.nodes.size());
  std::vector<double> nodes, ends, types(mesh.hexes.size(), 12);
  for (const auto& hex : mesh.hexes) {
    for (const int node : hex) nodes.push_back(node);
    ends.push_back(double(nodes.size()));
  }
  std::string text = fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{}\" "
      "header_type=\"{}\"{}>\n<UnstructuredGrid><Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n",
      big ? "BigEndian" : "LittleEndian", style.long_headers ? "UInt64" : "UInt32",
      style.compressed ? " compressor=\"vtkZLibDataCompressor\"" : "", mesh.nodes.rows(), mesh.hexes.size());
  text +=
      "<PointData></PointData>\n<CellData>" +
      array("Name=\"limit_factor\"", "Float64", raw_list<double>(mesh.limit_factor, big), mesh.limit_factor) +
      "</CellData>\n<Points>" +
      array("Name=\"Points\" NumberOfComponents=\"3\"", "Float64", raw_list<double>(coordinates, big), coordinates) +
      "</Points>\n<Cells>" + array("Name=\"connectivity\"", "Int64", raw_list<std::int64_t>(nodes, big), nodes) +
      array("Name=\"offsets\"", "Int32", raw_list<std::int32_t>(ends, big), ends) +
      array("Name=\"types\"", "UInt8", raw_list<std::uint8_t>(types, big), types) +
      "</Cells>\n</Piece></UnstructuredGrid>\n";
  if (style.format == "appended")
    text += "<AppendedData encoding=\"" + style.encoding + "\">\n  _" + appended + "\n</AppendedData>\n";
  return text + "</VTKFile>\n";
}

}  // namespace umax::testing
