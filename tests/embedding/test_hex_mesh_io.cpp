#include "embedding/hex_files/hex_mesh_io.h"

#include <cmath>

#include "core/base/error.h"
#include "core/element/hexahedron.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/hex_faces.h"
#include "embedding/surface/mesh_report.h"
#include "tests/embedding/hex_file_checks.h"
#include "tests/embedding/hex_files.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"

using namespace umax;
using namespace umax::testing;
using umax::test::replaced;

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
