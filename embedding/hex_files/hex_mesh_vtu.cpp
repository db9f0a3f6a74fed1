// VTK XML .vtu: unstructured grids in one or several pieces.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <pugixml.hpp>

#include "embedding/hex_files/hex_mesh_formats.h"
#include "embedding/hex_files/vtu_data.h"
#include "embedding/scanning/file_checks.h"

namespace umax {
namespace {

using Path = std::filesystem::path;

[[noreturn]] void refuse(const Path& path, const std::string& what, const std::string& value,
                         const std::string& remedy = "the file is truncated or damaged: export it again") {
  refuse_mesh(path, what, value, remedy);
}

// Takes the appended data out: raw bytes are no XML.
std::string take_out_appended(const Path& path, const std::string& text, VtuEncoding& encoding) {
  const std::size_t element = text.find("<AppendedData");
  if (element == text.npos) return text;
  const std::size_t opened = text.find('>', element), start = text.find('_', std::min(opened, text.size()));
  if (start == text.npos) refuse(path, "has AppendedData without its beginning (_)", "");
  const std::string_view tag = std::string_view(text).substr(element, opened - element);
  encoding.appended_base64 = tag.find("base64") != tag.npos;
  encoding.appended = std::string_view(text).substr(start + 1);
  const std::size_t end = encoding.appended.rfind("</AppendedData>");
  if (end == encoding.appended.npos) refuse(path, "ends within its AppendedData", "");
  encoding.appended = encoding.appended.substr(0, end);
  return text.substr(0, element) + "</VTKFile>";
}

pugi::xml_document parse(const Path& path, const std::string& xml) {
  pugi::xml_document document;
  const pugi::xml_parse_result result = document.load_buffer(xml.data(), xml.size());
  if (!result) {
    const auto end = xml.begin() + std::min<std::ptrdiff_t>(result.offset, std::ptrdiff_t(xml.size()));
    refuse(path.string() + fmt::format(":{}", 1 + std::count(xml.begin(), end, '\n')), "is no valid XML",
           result.description());
  }
  return document;
}

void read_encoding(const Path& path, const pugi::xml_node& file, VtuEncoding& encoding) {
  if (!file) refuse(path, "has no VTKFile element", "", "save it as .vtu");
  if (std::strcmp(file.attribute("type").value(), "UnstructuredGrid") != 0)
    refuse(path, "holds no unstructured grid", file.attribute("type").value(),
           "save it as an unstructured grid (.vtu) of hexahedra");
  encoding.big_endian = std::strcmp(file.attribute("byte_order").value(), "BigEndian") == 0;
  encoding.long_headers = std::strcmp(file.attribute("header_type").value(), "UInt64") == 0;
  const std::string compressor = file.attribute("compressor").value();
  encoding.compressed = !compressor.empty();
  if (encoding.compressed && compressor != "vtkZLibDataCompressor")
    refuse(path, "is compressed in a way that is not read", compressor, "save it with zlib or without compression");
}

long long count_of(const Path& path, const pugi::xml_node& piece, const char* attribute) {
  const pugi::xml_attribute count = piece.attribute(attribute);
  constexpr long long most = 1LL << 40;
  const long long value = count.as_llong(-1);
  if (value < 0 || value > most) refuse(path, fmt::format("needs {} of its piece", attribute), count.value());
  return value;
}

VtuArray array_of(const pugi::xml_node& node, const std::string& name) {
  return {.name = name,
          .type = node.attribute("type").value(),
          .format = node.attribute("format").as_string("ascii"),
          .text = node.text().get(),
          .offset = node.attribute("offset").as_llong(-1)};
}

pugi::xml_node find_array(const Path& path, const pugi::xml_node& parent, const char* name) {
  const pugi::xml_node node = parent.find_child_by_attribute("DataArray", "Name", name);
  if (!node) refuse(path, fmt::format("has no array \"{}\" in its cells", name), "");
  return node;
}

void read_points(const Path& path, const VtuEncoding& encoding, const pugi::xml_node& piece, HexFile& file) {
  const long long num_points = count_of(path, piece, "NumberOfPoints");
  const pugi::xml_node array = piece.child("Points").child("DataArray");
  if (!array || array.attribute("NumberOfComponents").as_int() != 3)
    refuse(path, "needs points of three components", array.attribute("NumberOfComponents").value());
  const std::vector<double> x = read_vtu_array(path, encoding, array_of(array, "Points"), 3 * num_points);
  for (std::size_t i = 0; i + 2 < x.size(); i += 3) file.nodes.emplace_back(x[i], x[i + 1], x[i + 2]);
}

// returns the number of cells
long long read_piece(const Path& path, const VtuEncoding& encoding, const pugi::xml_node& piece, long long first_cell,
                     HexFile& file) {
  VtkCells cells{.first_cell = first_cell, .first_node = (long long)(file.nodes.size())};
  read_points(path, encoding, piece, file);
  const long long num_cells = count_of(path, piece, "NumberOfCells");
  const pugi::xml_node lists = piece.child("Cells");
  const auto read = [&](const char* name, long long count) {
    return read_vtu_array(path, encoding, array_of(find_array(path, lists, name), name), count);
  };
  cells.types = read("types", num_cells);
  cells.ends = read("offsets", num_cells);
  cells.nodes = read("connectivity", -1);
  add_vtk_cells(path, cells, file);

  for (const pugi::xml_node& node : piece.child("CellData").children("DataArray")) {
    const std::string name = node.attribute("Name").value();
    if (is_known_cell_data(name))
      add_vtk_cell_data(name, read_vtu_array(path, encoding, array_of(node, name), num_cells), first_cell, file);
  }
  return num_cells;
}

}  // namespace

HexFile read_vtu(const Path& path, const std::string& text) {
  VtuEncoding encoding;
  const pugi::xml_document document = parse(path, take_out_appended(path, text, encoding));
  const pugi::xml_node root = document.child("VTKFile");
  read_encoding(path, root, encoding);
  HexFile file;
  long long num_cells = 0;
  for (const pugi::xml_node& piece : root.child("UnstructuredGrid").children("Piece"))
    num_cells += read_piece(path, encoding, piece, num_cells, file);
  return file;
}

}  // namespace umax
