// Files of hexes that are cut off, spoilt, or promise what they do not hold.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "embedding/hex_files/hex_mesh_io.h"
#include "tests/embedding/hex_file_checks.h"
#include "tests/embedding/hex_files.h"
#include "tests/support/catch.h"

using namespace umax;
using namespace umax::testing;
using umax::test::replaced;

namespace {

// the mesh as a file of each kind that is read, by name
std::vector<std::pair<std::string, std::string>> every_format(const HexDocument& mesh) {
  return {{"gmsh22.msh", gmsh_2(mesh, false)},
          {"gmsh22b.msh", gmsh_2(mesh, true)},
          {"gmsh41.msh", gmsh_4(mesh, false)},
          {"gmsh41b.msh", gmsh_4(mesh, true)},
          {"plain.vtk", plain_vtk(mesh)},
          {"legacy4.vtk", vtk_legacy(mesh, 4, false)},
          {"legacy4b.vtk", vtk_legacy(mesh, 4, true)},
          {"legacy5.vtk", vtk_legacy(mesh, 5, false)},
          {"legacy5b.vtk", vtk_legacy(mesh, 5, true)},
          {"xml.vtu", vtu(mesh, {})},
          {"xmlb.vtu", vtu(mesh, {.format = "binary", .compressed = true})},
          {"xmlr.vtu", vtu(mesh, {.format = "appended", .encoding = "raw"})},
          {"xmlz.vtu", vtu(mesh, {.format = "appended", .encoding = "raw", .compressed = true})}};
}

}  // namespace

TEST_CASE("files of hexes that are damaged are refused, wherever they end") {
  const HexDocument good = document_of(sample_lattice());
  for (const auto& [name, text] : every_format(good)) {
    // what ends in the last tenth of a legacy file may be whole but for data that nobody asks for
    const double last = name.ends_with(".vtk") && name != "plain.vtk" ? 0.5 : 0.97;
    for (const double share : {0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.97})
      if (share <= last) refuses(name, text.substr(0, std::size_t(share * double(text.size()))), "");
  }
  std::string noise;
  test::Random random(3);
  for (int i = 0; i < 5000; ++i) noise += char(int(random.uniform(0, 256)));
  for (const char* name : {"noise.msh", "noise.vtk", "noise.vtu"}) {
    refuses(name, noise, "");
    refuses(name, "\n", "");
  }
  refuses("noise2.msh", "$MeshFormat\n2.2 1 8\n" + raw(1) + "\n$EndMeshFormat\n$Nodes\n100\n" + noise, "");
  refuses("noise40.msh", "$MeshFormat\n4 1 8\n" + raw(1) + "\n$EndMeshFormat\n$Nodes\n" + noise, "");
  refuses("noise4.msh", "$MeshFormat\n4.1 1 8\n" + raw(1) + "\n$EndMeshFormat\n$Nodes\n" + noise, "");
  refuses("noise5.vtk", "# vtk DataFile Version 5.1\nx\nBINARY\nDATASET UNSTRUCTURED_GRID\nPOINTS 9 float\n" + noise,
          "");
}

TEST_CASE("files of hexes with bytes changed are read or refused, whatever the bytes") {
  const HexDocument good = document_of(sample_lattice());
  test::Random random(11);
  int refused = 0, read = 0;
  for (const auto& [name, text] : every_format(good))
    for (int round = 0; round < 150; ++round) {
      std::string spoilt = text;
      const int changes = 1 << (round % 4);
      for (int c = 0; c < changes; ++c) {
        // half of them near the front, where the headers are
        const double reach = c % 2 ? double(text.size()) : std::min(400.0, double(text.size()));
        const auto at = std::size_t(random.uniform(0, reach));
        spoilt[at] = round % 3 ? char(int(random.uniform(0, 256))) : char('0' + int(random.uniform(0, 10)));
      }
      CAPTURE(name, round);
      try {
        const HexMesh mesh = load_hex_mesh(write_file(name, spoilt));
        CHECK(mesh.nodes.allFinite());
        CHECK(mesh.hexes.minCoeff() >= 0);
        CHECK(mesh.hexes.maxCoeff() < mesh.nodes.rows());
        ++read;
      } catch (const Error& error) {
        CHECK(error.fault() == Fault::bad_data);
        ++refused;
      }
    }
  CHECK(refused > 300);
  CHECK(read > 100);
}

TEST_CASE("headers of hex files that promise more than there is, or what is not read, are refused") {
  const HexDocument good = document_of(sample_lattice());
  const std::string vtk = plain_vtk(good), msh = gmsh_2(good, false), msh4 = gmsh_4(good, false);
  const std::string huge = "999999999999";
  refuses("p.msh", replaced(msh, "$Nodes\n36", "$Nodes\n" + huge), "promises 999999999999 nodes");
  refuses("p.msh", replaced(msh, "$Elements\n13", "$Elements\n" + huge), "promises 999999999999 elements");
  refuses("p.msh", replaced(msh, "$Elements\n13", "$Elements\n14"), "");
  refuses("p.msh", replaced(msh, "$Elements\n13", "$Elements\n12"), "$EndElements");
  refuses("p.msh", replaced(msh, "$Nodes\n36", "$Nodes\n-1"), "promises -1 nodes");
  refuses("p4.msh", replaced(msh4, "$Nodes\n2 36", "$Nodes\n2 37"), "1 are missing");
  refuses("p4.msh", replaced(msh4, "$Nodes\n2 36", "$Nodes\n2 35"), "more nodes than promised");
  refuses("p4.msh", replaced(msh4, "$Nodes\n2 36", "$Nodes\n" + huge + " 36"), "promises");
  const std::string msh1 = gmsh_1(good), msh40 = gmsh_4_0(good, false);
  refuses("p1.msh", replaced(msh1, "$NOD\n36", "$NOD\n" + huge), "promises 999999999999 nodes");
  refuses("p1.msh", replaced(msh1, "$ELM\n13", "$ELM\n14"), "");
  refuses("p1.msh", replaced(msh1, "$ELM\n13", "$ELM\n12"), "$ENDELM");
  refuses("p1.msh", replaced(msh1, "2 5 1 1 8", "2 5 1 1 7"), "wrong number of nodes");
  refuses("p1.msh", msh1.substr(0, msh1.find("$ELM")), "has no $Elements");
  refuses("p40.msh", replaced(msh40, "$Nodes\n2 36", "$Nodes\n2 37"), "1 are missing");
  refuses("p40.msh", replaced(msh40, "$Nodes\n2 36", "$Nodes\n2 35"), "more nodes than promised");
  refuses("p40.msh", replaced(msh40, "$Nodes\n2 36", "$Nodes\n" + huge + " 36"), "promises");
  refuses("p40.msh", replaced(msh40, "$Elements\n2 13", "$Elements\n2 14"), "1 are missing");
  refuses("p40.msh", msh40.substr(0, msh40.size() / 2), "");
  refuses("v.msh", replaced(msh, "2.2 0 8", "5 0 8"), "got 5; save it as version 4.1 or 2.2");
  refuses("v.msh", replaced(msh, "2.2 0 8", "2.2 0 4"), "size that is not read");
  refuses("order.msh", replaced(gmsh_2(good, true), raw(1), raw(1, true)), "other byte order");
  refuses("word.msh", replaced(msh, "$EndNodes", "$EndNode"), "$EndNodes");
  refuses("p.vtk", replaced(vtk, "POINTS 36", "POINTS " + huge), "promises");
  refuses("p.vtk", replaced(vtk, "POINTS 36", "POINTS 35"), "");
  refuses("p.vtk", replaced(vtk, "CELLS 12 108", "CELLS 12 " + huge), "promises");
  refuses("p.vtk", replaced(vtk, "CELLS 12 108", "CELLS 11 108"), "longer than its cells");
  refuses("p.vtk", replaced(vtk, "CELL_TYPES 12", "CELL_TYPES 11"), "");
  refuses("p.vtk", replaced(vtk, "\n8 ", "\n7 "), "");
  refuses("k.vtk", replaced(vtk, "UNSTRUCTURED_GRID", "STRUCTURED_GRID"), "unstructured grid");
  refuses("k.vtk", replaced(vtk, "Version 2.0", "Version 7.0"), "unknown version");
  refuses("k.vtk", replaced(vtk, "CELL_TYPES", "CELL_KINDS"), "unknown keyword");
  refuses("k.vtk", replaced(vtk, " double", " decimal"), "unknown type");
  const std::string xml = vtu(good, {}),
                    packed = vtu(good, {.format = "appended", .encoding = "raw", .compressed = true});
  refuses("p.vtu", replaced(xml, "NumberOfPoints=\"36\"", "NumberOfPoints=\"" + huge + "\""),
          "as promised, got 108 of");
  refuses("p.vtu", replaced(xml, "NumberOfCells=\"12\"", "NumberOfCells=\"13\""), "as promised");
  refuses("p.vtu", replaced(xml, "NumberOfComponents=\"3\"", "NumberOfComponents=\"2\""), "three components");
  refuses("p.vtu", replaced(xml, "\"connectivity\"", "\"links\""), "no array \"connectivity\"");
  refuses("p.vtu", replaced(xml, "Int64", "Int99"), "unknown type");
  refuses("k.vtu", replaced(xml, "type=\"UnstructuredGrid\"", "type=\"PolyData\""), "got PolyData");
  refuses("k.vtu", replaced(xml, "</Cells>", "</Cell>"), "no valid XML");
  refuses("k.vtu", replaced(packed, "vtkZLib", "vtkLZ4"), "compressed in a way that is not read");
  refuses("o.vtu", replaced(packed, "offset=\"0\"", "offset=\"99999\""), "behind the appended data");
  refuses("o.vtu", replaced(packed, "offset=\"0\"", "offset=\"7\""), "");
}
