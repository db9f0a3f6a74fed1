// What users' files hold beside plain meshes: strips, loose vertices, odd headers.
#include <cstring>

#include "core/base/error.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/mesh_report.h"
#include "tests/embedding/mesh_file_checks.h"
#include "tests/embedding/mesh_files.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"

using namespace umax;
using namespace umax::testing;
using umax::test::replaced;

namespace {

const float known_vertices[5][3] = {{2, 0.5, 0}, {0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};

/// The quad and the triangle as binary PLY. first: the x of the first vertex.
std::string binary_ply(bool big_endian, float first = 2) {
  std::string text = std::string("ply\r\nformat binary_") + (big_endian ? "big" : "little") +
                     "_endian 1.0\r\nelement vertex 5\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\n"
                     "property uchar quality\r\nelement face 2\r\nproperty list uchar uint vertex_index\r\n"
                     "element extra 1\r\nproperty list uchar short x\r\nend_header\r\n";
  for (int v = 0; v < 5; ++v) {
    for (int axis = 0; axis < 3; ++axis) text += raw(v == 0 && axis == 0 ? first : known_vertices[v][axis], big_endian);
    text += char(7);
  }
  for (const auto& face : {std::vector<unsigned>{1, 3, 2, 4}, std::vector<unsigned>{3, 0, 2}}) {
    text += char(face.size());
    for (const unsigned corner : face) text += raw(corner, big_endian);
  }
  return text + char(1) + raw(std::int16_t(3), big_endian);
}

/// The same as binary OFF.
std::string binary_off(bool big_endian) {
  std::string text = "OFF BINARY\n";
  for (const int count : {5, 2, 0}) text += raw(count, big_endian);
  for (const auto& vertex : known_vertices)
    for (const float x : vertex) text += raw(x, big_endian);
  for (const auto& face : {std::vector<int>{1, 3, 2, 4}, std::vector<int>{3, 0, 2}}) {
    text += raw(int(face.size()), big_endian);
    for (const int corner : face) text += raw(corner, big_endian);
    text += raw(face.size() == 3 ? 4 : 0, big_endian);
    for (std::size_t k = 0; k < (face.size() == 3 ? 4 : 0); ++k) text += raw(0.5f, big_endian);
  }
  return text;
}

void check_two_faces(const MeshFile& file) {
  REQUIRE(file.mesh.num_vertices() == 5);
  for (int v = 0; v < 5; ++v)
    for (int axis = 0; axis < 3; ++axis) CHECK(file.mesh.positions(v, axis) == double(known_vertices[v][axis]));
  REQUIRE(file.mesh.num_triangles() == 3);
  CHECK(report_mesh(file.mesh).area == Approx(1.5));
  CHECK(report_mesh(file.mesh).num_inconsistent_edges == 0);
}

}  // namespace

TEST_CASE("binary PLY of either byte order, with properties and elements that mean nothing here") {
  check_two_faces(load_mesh(write_file("little.ply", binary_ply(false))));
  check_two_faces(load_mesh(write_file("big.ply", binary_ply(true))));
  // its data begin with a byte that is a line's end
  float odd = 2;
  const unsigned bits = 0x4000000a;
  std::memcpy(&odd, &bits, sizeof odd);
  const MeshFile file = load_mesh(write_file("odd.ply", binary_ply(false, odd)));
  CHECK(file.mesh.positions(0, 0) == double(odd));
  CHECK(file.mesh.num_triangles() == 3);
}

TEST_CASE("PLY: triangle strips, turned every other time, begun anew by -1") {
  const std::string text = R"(ply
format ascii 1.0
element vertex 7
property float x
property float y
property float z
element tristrips 1
property list int int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
1 1 0
0 2 0
5 5 0
6 5 0
10 0 1 2 3 4 -1 2 3 3 4
)";
  const MeshFile file = load_mesh(write_file("strip.ply", text));
  Triangles expected(3, 3);
  expected << 0, 1, 2, 1, 3, 2, 2, 3, 4;
  CHECK(file.mesh.triangles == expected);  // what only leads around a corner is none
  CHECK(report_mesh(file.mesh).num_inconsistent_edges == 0);
  CHECK(file.vertex_in_file == std::vector<int>{0, 1, 2, 3, 4});
  CHECK(notes_say(file, "2 vertices belong to no triangle: left out"));
  check_refused(write_file("range.ply", replaced(text, "10 0 1", "10 0 9")), {"vertex 9, which does not exist"});
  check_refused(write_file("cut.ply", replaced(text, " 3 3 4\n", "")), {"truncated or damaged"});
}

TEST_CASE("PLY: colours, texture coordinates of vertices and of corners, and the texture that a comment names") {
  write_file("paint.png", "x");
  const std::string per_vertex = R"(ply
format ascii 1.0
comment TextureFile paint.png
element vertex 3
property double x
property double y
property double z
property float s
property float t
property float red
property float green
property float blue
element face 1
property list uchar int vertex_indices
end_header
0 0 0 0 0.25 1 0 0
1 0 0 1 0.5 0 1 0
0 1 0 0.5 0.75 0 0 1
3 0 1 2
)";
  const MeshFile file = load_mesh(write_file("st.ply", per_vertex));
  REQUIRE(file.mesh.texture_coordinates.rows() == 3);
  CHECK(file.mesh.texture_coordinates(2, 1) == 0.75f);
  CHECK(file.mesh.colors(1, 1) == 1);
  REQUIRE(file.materials.size() == 1);
  CHECK(file.materials[0].texture.filename() == "paint.png");

  std::string per_corner = replaced(per_vertex, "property float s\nproperty float t\n", "");
  per_corner = replaced(per_corner, "vertex_indices", "vertex_indices\nproperty list uchar float texcoord");
  for (const char* both : {"0 0 0 0 0.25", "1 0 0 1 0.5", "0 1 0 0.5 0.75"})
    per_corner = replaced(per_corner, both, std::string(both).substr(0, 5));
  per_corner = replaced(per_corner, "3 0 1 2", "3 0 1 2 6 0 0.1 0.2 0.3 0.4 0.5");
  const MeshFile corners = load_mesh(write_file("corner.ply", per_corner));
  REQUIRE(corners.mesh.texture_coordinates.rows() == 3);
  CHECK(corners.mesh.texture_coordinates(2, 1) == 0.5f);
}

TEST_CASE("PLY headers that promise what cannot be are refused") {
  const std::string ply = ply_document;
  const std::string binary = binary_ply(false);
  check_refused(write_file("many.ply", replaced(ply, "vertex 5", "vertex 999999999")), {"promises 999999999"});
  check_refused(write_file("more.ply", replaced(ply, "vertex 5", "vertex 99999999999999")), {"cannot be"});
  check_refused(write_file("minus.ply", replaced(ply, "vertex 5", "vertex -5")), {"cannot be"});
  check_refused(write_file("faces.ply", replaced(binary, "face 2", "face 999999")), {"promises 999999"});
  check_refused(write_file("list.ply", replaced(binary, std::string("\4\1\0\0\0", 5), std::string("\377\1\0\0\0", 5))),
                {"promises 255 entries"});
  check_refused(write_file("type.ply", replaced(ply, "property float x", "property quad x")), {"\"quad\""});
  check_refused(write_file("format.ply", replaced(ply, "ascii", "morse")), {"\"morse\""});
  check_refused(write_file("noxyz.ply", replaced(ply, "float z", "float w")), {"without x, y and z"});
  check_refused(write_file("word.ply", replaced(ply, "1 0 0 0 255 0", "1 O 0 0 255 0")), {"\"O\""});
  check_refused(write_file("cut.ply", binary.substr(0, binary.size() - 20)), {"truncated or damaged"});
}

TEST_CASE("OFF: binary of either byte order, colours, normals, and counts beside the keyword") {
  check_two_faces(load_mesh(write_file("big.off", binary_off(true))));
  check_two_faces(load_mesh(write_file("little.off", binary_off(false))));
  check_two_faces(load_mesh(write_file("glued.off", replaced(off_document, "OFF\n# by hand\n5 2 0", "OFF5 2 0"))));
  check_two_faces(load_mesh(write_file("bare.off", replaced(off_document, "OFF\n", ""))));
  const MeshFile painted = load_mesh(write_file("painted.off", R"(CNOFF
3 1 0
0 0 0  0 0 1  255 0 0 255
1 0 0  0 0 1  188 0 0 255   # half
0 1 0  0 0 1  0 0 255 255
3 0 1 2  0.1 0.2 0.3
)"));
  REQUIRE(painted.mesh.colors.rows() == 3);
  CHECK(painted.mesh.colors(0, 0) == Approx(1));
  CHECK(painted.mesh.colors(1, 0) == Approx(0.50289).epsilon(1e-4));
  const MeshFile pictured =
      load_mesh(write_file("st.off", "STOFF\n3 1 0\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 0.5\n3 0 1 2\n"));
  REQUIRE(pictured.mesh.texture_coordinates.rows() == 3);
  CHECK(pictured.mesh.texture_coordinates(2, 1) == 0.5f);
}

TEST_CASE("OFF files that are damaged say where") {
  const std::string binary = binary_off(true);
  check_refused(write_file("cut.off", binary.substr(0, binary.size() - 30)), {"truncated or damaged"});
  check_refused(write_file("counts.off", "OFF BINARY\n" + std::string(12, '\x7f')), {"counts"});
  check_refused(write_file("minus.off", "OFF\n-3 1 0\n0 0 0\n"), {"counts"});
  check_refused(write_file("many.off", "OFF\n3 99999999 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), {"promises 99999999"});
  check_refused(write_file("word.off", "OFF\n3 1 0\n0 0 0\n1 o 0\n0 1 0\n3 0 1 2\n"), {"vertex 1", "\"o 0\""});
  check_refused(write_file("nan.off", "OFF\n3 1 0\n0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"), {"not finite"});
  check_refused(write_file("four.off", "4OFF\n3 1 0\n0 0 0 1\n1 0 0 1\n0 1 0 1\n3 0 1 2\n"), {"three coordinates"});
  std::string corner = binary;
  corner[11 + 12 + 60 + 7] = 99;  // of the first face
  check_refused(write_file("corner.off", corner), {"face 0 names vertex 99"});
}

TEST_CASE("polygons that are not convex are cut within themselves") {
  // a quad whose second corner lies inside, an L of six corners, and the same turned around
  const auto area_of = [](const std::string& corners, const std::string& faces) {
    return report_mesh(load_mesh(write_file("polygon.off", "OFF\n" + corners + faces)).mesh).area;
  };
  CHECK(area_of("4 1 0\n0 0 0\n1 0.2 0\n2 0 0\n1 3 0\n", "4 0 1 2 3\n") == Approx(2.8));
  CHECK(area_of("4 1 0\n1 0.2 0\n2 0 0\n1 3 0\n0 0 0\n", "4 0 1 2 3\n") == Approx(2.8));
  const std::string l = "6 1 0\n0 0 0\n2 0 0\n2 1 0\n1 1 0\n1 3 0\n0 3 0\n";
  CHECK(area_of(l, "6 0 1 2 3 4 5\n") == Approx(4));
  CHECK(area_of(l, "6 5 4 3 2 1 0\n") == Approx(4));
  CHECK(area_of(l, "6 3 4 5 0 1 2\n") == Approx(4));
  // convex ones as a fan from their first corner, as ever
  const Triangles fan =
      load_mesh(write_file("fan.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 2 3 0 1\n")).mesh.triangles;
  Triangles expected(2, 3);
  expected << 2, 3, 0, 2, 0, 1;
  CHECK(fan == expected);
}

TEST_CASE("OBJ: lines that go on behind a backslash are one, and later lines keep their numbers") {
  const MeshFile file = load_mesh(write_file("long.obj",
                                             "# C:\\models\\\nv 2 0.5 \\\n0\nv 0 0 0\nv 1 1 0\r\nv 1 0 0\nv 0 1 0\n"
                                             "f 2 \\\r\n 4 3\\\n 5\nf 4 1 3\n"));
  check_two_faces(file);
  check_refused(write_file("late.obj", "v 0 0 0\nv 1 0 0\nv 0 \\\n1 \\\n0\nf 1 2 3\nf 1 2\n"),
                {"late.obj:7", "three corners"});
  check_refused(write_file("end.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 \\"), {"end.obj:5"});
}

TEST_CASE("vertices of no triangle are left out and said, and the others know their place in the file") {
  std::string obj = "v 9e8 9e8 9e8\n";
  for (int i = 0; i < 1000; ++i) obj += "v 7 7 7\n";
  obj += "v 0 0 0\nv 1 0 0\nv 3 3 3\nv 0 1 0\nf 1002 1003 1005\n";
  const MeshFile file = load_mesh(write_file("loose.obj", obj));
  CHECK(file.mesh.num_vertices() == 3);
  CHECK(file.vertex_in_file == std::vector<int>{1001, 1002, 1004});
  CHECK(notes_say(file, "1002 vertices belong to no triangle: left out"));
  REQUIRE(file.loose_vertices.rows() == 1002);
  CHECK(file.loose_vertices.row(1001) == Eigen::RowVector3d(3, 3, 3));
  // those of a scan that are no numbers, too
  const MeshFile scan = load_mesh(write_file("scan.off", "OFF\n4 1 0\n0 0 0\n1 0 0\nnan nan nan\n0 1 0\n3 0 1 3\n"));
  CHECK(scan.mesh.num_vertices() == 3);
  CHECK(notes_say(scan, "1 vertex belongs to no triangle: left out"));
}
