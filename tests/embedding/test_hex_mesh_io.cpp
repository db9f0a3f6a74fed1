#include "embedding/hex_files/hex_mesh_io.h"

#include <cmath>

#include "core/base/error.h"
#include "core/element/hexahedron.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/hex_faces.h"
#include "embedding/surface/mesh_report.h"
#include "tests/embedding/hex_files.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"
#include "tools/system/exit_code.h"

using namespace umax;
using namespace umax::testing;

namespace {

void check_sample(const std::string& name, const std::string& content, bool with_factors) {
  CAPTURE(name);
  const Lattice expected = sample_lattice();
  const HexMesh mesh = load_hex_mesh(write_file(name, content));
  CHECK(mesh.nodes == expected.rest_positions);  // to the last bit, as text too
  CHECK(mesh.hexes == expected.hexes);
  CHECK(mesh.young_factor.size() == 0);
  REQUIRE(mesh.limit_factor.size() == (with_factors ? 12 : 0));
  for (Eigen::Index e = 0; e < mesh.limit_factor.size(); ++e) CHECK(mesh.limit_factor[e] == 1 + 0.25 * double(e));
}

void refuses(const std::string& name, const std::string& content, const std::string& text) {
  CAPTURE(name, text);
  try {
    load_hex_mesh(write_file(name, content));
  } catch (const Error& error) {
    CAPTURE(std::string(error.what()));
    CHECK(exit_code_of(error.fault()) == 65);
    CHECK(std::string(error.what()).find(name) != std::string::npos);
    CHECK(std::string(error.what()).find(text) != std::string::npos);
    CHECK(std::string(error.what()).size() < 700);
    return;
  }
  FAIL_CHECK("was accepted");
}

std::string replaced(std::string text, const std::string& old_part, const std::string& new_part) {
  const std::size_t at = text.find(old_part);
  REQUIRE(at != std::string::npos);
  return text.replace(at, old_part.size(), new_part);
}

// hexes without the vertex, the factors and the rest: easy to spoil
std::string plain_vtk(const HexDocument& mesh) {
  std::string text = fmt::format("# vtk DataFile Version 2.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n",
                                 mesh.nodes.rows());
  for (const auto& x : mesh.nodes.rowwise()) text += fmt::format("{:.17g} {:.17g} {:.17g}\n", x[0], x[1], x[2]);
  text += fmt::format("CELLS {} {}\n", mesh.hexes.size(), 9 * mesh.hexes.size());
  for (const auto& hex : mesh.hexes) text += fmt::format("8 {}\n", fmt::join(hex, " "));
  text += fmt::format("CELL_TYPES {}\n", mesh.hexes.size());
  for (std::size_t e = 0; e < mesh.hexes.size(); ++e) text += "12\n";
  return text;
}

}  // namespace

TEST_CASE("Gmsh 1, 2.2, 4.0 and 4.1, as text and binary") {
  const HexDocument mesh = document_of(sample_lattice());
  for (const bool binary : {false, true}) {
    check_sample(fmt::format("sample22-{}.msh", binary), gmsh_2(mesh, binary), false);
    check_sample(fmt::format("sample40-{}.msh", binary), gmsh_4_0(mesh, binary), false);
    check_sample(fmt::format("sample41-{}.msh", binary), gmsh_4(mesh, binary), false);
  }
  check_sample("sample1.msh", gmsh_1(mesh), false);
  CHECK(load_hex_mesh(write_file("sample1.msh", gmsh_1(mesh))).notes.size() == 1);
  const HexMesh read = load_hex_mesh(write_file("sample.msh", gmsh_4(mesh, false)));
  REQUIRE(read.notes.size() == 1);
  CHECK(read.notes[0] == "left out: 1 points (the first is element 1)");
}

TEST_CASE("VTK legacy of every version, as text and binary, with factors of the cells") {
  const HexDocument mesh = document_of(sample_lattice());
  for (const bool binary : {false, true})
    for (const int version : {2, 3, 4, 5})
      check_sample(fmt::format("sample{}-{}.vtk", version, binary), vtk_legacy(mesh, version, binary), true);
}

TEST_CASE("VTK XML as text, base64 and appended, plain and compressed, of both byte orders") {
  const HexDocument mesh = document_of(sample_lattice());
  check_sample("ascii.vtu", vtu(mesh, {}), true);
  for (const char* format : {"binary", "appended"})
    for (const char* encoding : {"base64", "raw"})
      for (const bool compressed : {false, true})
        for (const bool other : {false, true})
          check_sample(fmt::format("{}-{}-{}-{}.vtu", format, encoding, compressed, other),
                       vtu(mesh, {.format = format,
                                  .encoding = encoding,
                                  .compressed = compressed,
                                  .long_headers = other,
                                  .big_endian = other}),
                       true);
}

TEST_CASE("a VTU in two pieces is one mesh, cell data that one of them lacks are missed") {
  HexDocument low = document_of(make_irregular_lattice(make_box_lattice({1, 1, 1}, {0, 0, 0}, {1, 1, 1}).rest_positions,
                                                       make_box_lattice({1, 1, 1}, {0, 0, 0}, {1, 1, 1}).hexes));
  HexDocument high = low;
  high.nodes.col(0).array() += 5;
  const std::string first = vtu(low, {}), second = vtu(high, {});
  const auto piece = [](const std::string& text) {
    const std::size_t begin = text.find("<Piece"), end = text.find("</Piece>") + 8;
    return text.substr(begin, end - begin);
  };
  const HexMesh mesh =
      load_hex_mesh(write_file("pieces.vtu", replaced(first, piece(first), piece(first) + piece(second))));
  CHECK(mesh.nodes.rows() == 16);
  CHECK(mesh.hexes.row(1).minCoeff() == 8);
  CHECK(mesh.limit_factor.size() == 2);
  for (const bool second_lacks : {false, true}) {
    const std::string bare = replaced(piece(second_lacks ? second : first), "limit_factor", "other");
    refuses("lacking.vtu", replaced(first, piece(first), second_lacks ? piece(first) + bare : bare + piece(second)),
            second_lacks ? "limit_factor of cell 1" : "limit_factor of cell 0");
  }
}

TEST_CASE("voxels are hexes in another order") {
  std::string text = plain_vtk(document_of(make_box_lattice({1, 1, 1}, {0, 0, 0}, {1, 2, 3})));
  text = replaced(text, "8 0 4 6 2 1 5 7 3", "8 0 4 2 6 1 5 3 7");
  const HexMesh mesh = load_hex_mesh(write_file("voxel.vtk", replaced(text, "\n12\n", "\n11\n")));
  for (int n = 0; n < 8; ++n) CHECK(mesh.hexes(0, n) == n);
}

TEST_CASE("the surface of hexes is closed, faces outward and keeps the order of the nodes") {
  const Lattice lattice = test::distorted_lattice(make_box_lattice({3, 3, 3}, {0, 0, 0}, {1, 1, 1}), 0.3);
  const HexSurface surface = surface_of(lattice.rest_positions, lattice.hexes);
  const MeshReport report = report_mesh(surface.mesh);
  CHECK(report.watertight);
  CHECK(report.problems.empty());
  CHECK(surface.mesh.num_triangles() == 2 * 54);
  CHECK(surface.mesh.num_vertices() == 64 - 8);
  CHECK(report.signed_volume == Approx(27).epsilon(1e-12));
  CHECK(std::is_sorted(surface.nodes.begin(), surface.nodes.end()));
  for (std::size_t v = 0; v < surface.nodes.size(); ++v)
    CHECK(surface.mesh.positions.row(Eigen::Index(v)) == lattice.rest_positions.row(surface.nodes[v]));

  // load_mesh() gives the surface of such a file
  const MeshFile file = load_mesh(write_file("cube.vtu", vtu(document_of(lattice), {.format = "binary"})));
  CHECK(file.mesh.positions == surface.mesh.positions);
  CHECK(file.mesh.triangles == surface.mesh.triangles);
}

TEST_CASE("nodes of no hex are left out and told") {
  HexDocument mesh = document_of(sample_lattice());
  mesh.nodes.conservativeResize(mesh.nodes.rows() + 2, 3);
  mesh.nodes.bottomRows(2).setConstant(std::nan(""));  // not looked at
  const HexMesh read = load_hex_mesh(write_file("unused.vtk", plain_vtk(mesh)));
  CHECK(read.nodes == sample_lattice().rest_positions);
  REQUIRE(read.notes.size() == 1);
  CHECK(read.notes[0] == "left out: 2 nodes of no hex");
}

TEST_CASE("hexes that are inverted, tangled or mirrored are named with determinant and place") {
  const Lattice lattice = make_box_lattice({8, 1, 1}, {0, 0, 0}, {1, 1, 1});
  HexDocument mesh = document_of(lattice);
  for (const std::size_t e : {2u, 5u})
    std::rotate(mesh.hexes[e].begin(), mesh.hexes[e].begin() + 4, mesh.hexes[e].end());
  refuses("two.vtk", plain_vtk(mesh),
          "2 of 8 hexes are inverted or tangled: det(dX/ds) must be positive, got cell 2 (-0.125 at ");
  refuses("two.vtk", plain_vtk(mesh), "cell 5 (-0.125 at ");
  refuses("two.msh", gmsh_2(mesh, false), "element 4 (-0.125 at ");

  mesh = document_of(lattice);
  for (auto& hex : mesh.hexes) std::rotate(hex.begin(), hex.begin() + 4, hex.end());
  refuses("all.vtk", plain_vtk(mesh), "every hex is numbered as its mirror image");
  refuses("all.vtk", plain_vtk(mesh), " …; in every hex, exchange");

  mesh = document_of(lattice);
  mesh.nodes.row(0) << 0.7, 0.7, 0.7;  // a corner pushed through
  refuses("corner.msh", gmsh_4(mesh, false), "1 of 8 hexes is inverted or tangled");
  refuses("corner.msh", gmsh_4(mesh, false), "element 2 (-");
  refuses("corner.msh", gmsh_4(mesh, false), fmt::format(" at node {}", gmsh_tag(0)));
}

TEST_CASE("meshes of hexes that cannot be simulated are refused with what is wrong and where") {
  const HexDocument good = document_of(sample_lattice());
  const std::string vtk = plain_vtk(good), msh = gmsh_2(good, false), msh4 = gmsh_4(good, false);

  // other solids
  const std::string tetrahedron = replaced(vtk, "CELLS 12 108\n", "CELLS 13 113\n4 0 1 2 3\n");
  refuses("tet.vtk", replaced(tetrahedron, "CELL_TYPES 12\n", "CELL_TYPES 13\n10\n"),
          "solid cells that are no 8-node hexahedra, got 1 tetrahedra (the first is cell 0)");
  refuses("tet.msh", replaced(msh, "1 3 2 1 1", "1 4 2 1 1"), "1 tetrahedra (the first is element 1)");
  refuses("unknown.vtk", replaced(vtk, "\n12\n", "\n99\n"), "unknown type, got 99");
  refuses("unknown.msh", replaced(msh, "1 3 2 1 1", "1 77 2 1 1"), "type that is not known, got 77");
  const std::string none = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 1 float\n0 0 0\n";
  refuses("none.vtk", none + "CELLS 1 2\n1 0\nCELL_TYPES 1\n1\n", "no hexahedra, got 1 vertices");

  // nodes
  HexDocument bad = good;
  bad.nodes(7, 1) = std::nan("");
  refuses("nan.vtk", plain_vtk(bad), "1 of 36 vertices are not finite numbers, the first is vertex 7");
  bad.nodes(7, 1) = 2e9;
  refuses("far.vtk", plain_vtk(bad), "absurdly large");
  bad = good;
  bad.nodes.conservativeResize(37, 3);
  bad.nodes.row(36) = bad.nodes.row(bad.hexes[0][6]);
  const int doubled = bad.hexes[0][6];
  bad.hexes[0][6] = 36;
  refuses("double.vtk", plain_vtk(bad), fmt::format("apart there, got nodes {} and 36; merge", doubled));
  bad = good;
  bad.hexes[3][5] = 99;
  refuses("range.vtk", plain_vtk(bad), "cell 3 names a node that the file does not have, got 99 of 36");
  bad.hexes[3][5] = -1;
  refuses("negative.vtk", plain_vtk(bad), "cell 3 names a node");
  refuses("tag.msh", replaced(msh, fmt::format(" {}\n", gmsh_tag(good.hexes[0][7])), " 9999\n"),
          "names node 9999, which the file does not have");
  refuses("twice.msh", replaced(msh, "\n13 ", "\n10 "), "node 10 is given twice");
  bad = good;
  bad.hexes[4][2] = bad.hexes[4][1];
  refuses("collapsed.vtk", plain_vtk(bad), "inverted or tangled");

  // faces
  bad = good;
  bad.hexes.push_back(bad.hexes[6]);
  refuses("same.vtk", plain_vtk(bad), "share");
  bad.hexes = {good.hexes[6], good.hexes[6]};
  refuses("only.vtk", plain_vtk(bad), "same side of the face");

  // factors
  bad = good;
  bad.limit_factor[4] = -2;
  refuses("factor.vtu", vtu(bad, {}), "limit_factor of cell 4 must be positive and finite, got -2");
  refuses("width.vtk", replaced(vtk_legacy(good, 3, false), "limit_factor 1 13", "limit_factor 2 13"), "");
}

TEST_CASE("files of hexes that are damaged are refused, wherever they end") {
  const HexDocument good = document_of(sample_lattice());
  const std::vector<std::pair<std::string, std::string>> whole{
      {"cut22.msh", gmsh_2(good, false)},
      {"cut22b.msh", gmsh_2(good, true)},
      {"cut41.msh", gmsh_4(good, false)},
      {"cut41b.msh", gmsh_4(good, true)},
      {"cut2.vtk", plain_vtk(good)},
      {"cut5.vtk", vtk_legacy(good, 5, false)},
      {"cut5b.vtk", vtk_legacy(good, 5, true)},
      {"cut.vtu", vtu(good, {})},
      {"cutb.vtu", vtu(good, {.format = "binary", .compressed = true})},
      {"cutr.vtu", vtu(good, {.format = "appended", .encoding = "raw"})},
      {"cutz.vtu", vtu(good, {.format = "appended", .encoding = "raw", .compressed = true})}};
  for (const auto& [name, text] : whole) {
    // what ends in the last tenth of a legacy file may be whole but for data that nobody asks for
    const double last = name.ends_with(".vtk") && name != "cut2.vtk" ? 0.5 : 0.97;
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
  const std::vector<std::pair<std::string, std::string>> whole{
      {"fuzz22.msh", gmsh_2(good, false)},
      {"fuzz22b.msh", gmsh_2(good, true)},
      {"fuzz41.msh", gmsh_4(good, false)},
      {"fuzz41b.msh", gmsh_4(good, true)},
      {"fuzz4.vtk", vtk_legacy(good, 4, false)},
      {"fuzz4b.vtk", vtk_legacy(good, 4, true)},
      {"fuzz5.vtk", vtk_legacy(good, 5, false)},
      {"fuzz5b.vtk", vtk_legacy(good, 5, true)},
      {"fuzz.vtu", vtu(good, {})},
      {"fuzzb.vtu", vtu(good, {.format = "binary", .compressed = true})},
      {"fuzzr.vtu", vtu(good, {.format = "appended", .encoding = "raw"})},
      {"fuzzz.vtu", vtu(good, {.format = "appended", .encoding = "raw", .compressed = true})}};
  test::Random random(11);
  int refused = 0, read = 0;
  for (const auto& [name, text] : whole)
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
