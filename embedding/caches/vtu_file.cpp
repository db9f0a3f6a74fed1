#include "embedding/caches/vtu_file.h"

#include <fmt/format.h>

#include <array>

#include "embedding/caches/bytes.h"

namespace umax {
namespace {

/// VTK's corners of a hexahedron in our order, x slowest and z fastest.
constexpr std::array<int, 8> vtk_order{0, 4, 6, 2, 1, 5, 7, 3};
constexpr unsigned char vtk_hexahedron = 12;

/// The XML that describes arrays, and their bytes behind it.
struct Appended {
  std::string xml, bytes;

  void add(const std::string& type, const std::string& name, Eigen::Index components, std::string_view data) {
    xml += fmt::format("        <DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" ",
                       type, name, components);
    xml += fmt::format("offset=\"{}\"/>\n", bytes.size());
    append_bytes(bytes, std::uint64_t(data.size()));
    bytes += data;
  }
};

void add_data(const char* kind, const std::vector<DataArray>& arrays, Appended& file) {
  file.xml += fmt::format("      <{}>\n", kind);
  for (const DataArray& array : arrays) file.add("Float64", array.name, array.values.cols(), bytes_of(array.values));
  file.xml += fmt::format("      </{}>\n", kind);
}

void add_cells(const Hexes& hexes, Appended& file) {
  std::string connectivity, offsets;
  for (Eigen::Index e = 0; e < hexes.rows(); ++e) {
    for (const int n : vtk_order) append_bytes(connectivity, std::int64_t(hexes(e, n)));
    append_bytes(offsets, std::int64_t(8 * (e + 1)));
  }
  file.xml += "      <Cells>\n";
  file.add("Int64", "connectivity", 1, connectivity);
  file.add("Int64", "offsets", 1, offsets);
  file.add("UInt8", "types", 1, std::string(std::size_t(hexes.rows()), char(vtk_hexahedron)));
  file.xml += "      </Cells>\n";
}

}  // namespace

std::string vtu_bytes(const HexFrame& frame) {
  Appended file;
  add_data("PointData", frame.node_data, file);
  add_data("CellData", frame.hex_data, file);
  file.xml += "      <Points>\n";
  file.add("Float64", "positions", 3, bytes_of(frame.nodes));
  file.xml += "      </Points>\n";
  add_cells(frame.hexes, file);

  std::string out =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n  <UnstructuredGrid>\n    <FieldData>\n";
  out += fmt::format(
      "      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{}</DataArray>\n",
      frame.time);
  out += fmt::format("    </FieldData>\n    <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n", frame.nodes.rows(),
                     frame.hexes.rows());
  out += file.xml + "    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n_" + file.bytes;
  return out + "\n  </AppendedData>\n</VTKFile>\n";
}

std::string pvd_text(const std::vector<PvdEntry>& entries) {
  std::string out =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
      "  <Collection>\n";
  for (const PvdEntry& entry : entries)
    out += fmt::format("    <DataSet timestep=\"{}\" part=\"{}\" file=\"{}\"/>\n", entry.time, entry.part, entry.file);
  return out + "  </Collection>\n</VTKFile>\n";
}

}  // namespace umax
