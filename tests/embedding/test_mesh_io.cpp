#include "core/base/error.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/mesh_report.h"
#include "tests/embedding/mesh_files.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"
#include "tests/support/replaced.h"
#include "tools/system/exit_code.h"

using namespace umax;
using namespace umax::testing;
using umax::test::replaced;

namespace {

Points known_vertices() {
  Points points(5, 3);
  points << 2, 0.5, 0, 0, 0, 0, 1, 1, 0, 1, 0, 0, 0, 1, 0;
  return points;
}

// the quad and the triangle, whatever the quad's diagonal
void check_faces(const TriangleMesh& mesh) {
  REQUIRE(mesh.num_triangles() == 3);
  const MeshReport report = report_mesh(mesh);
  CHECK(report.area == Approx(1.5));
  CHECK(report.num_inconsistent_edges == 0);
  CHECK(report.num_boundary_edges == 5);
  CHECK(report.box_max[0] - report.box_min[0] == Approx(2));
}

// exit code and message of what load_mesh() throws
std::pair<int, std::string> failure(const std::filesystem::path& path) {
  try {
    load_mesh(path);
  } catch (const Error& error) {
    return {exit_code_of(error.fault()), error.what()};
  }
  return {0, "no error"};
}

void refuses(int exit_code, const std::filesystem::path& path, const std::string& part_of_message) {
  INFO(path.string());
  const auto [code, message] = failure(path);
  INFO(message);
  CHECK(code == exit_code);
  CHECK(message.find(part_of_message) != std::string::npos);
  CHECK(message.find(path.filename().string()) != std::string::npos);
}

}  // namespace

TEST_CASE("OBJ, PLY and OFF keep the file's vertex order and number") {
  const auto check = [](const MeshFile& file) {
    REQUIRE(file.mesh.num_vertices() == 5);
    CHECK(file.mesh.positions == known_vertices());
    check_faces(file.mesh);
    CHECK_FALSE(file.unit);
    CHECK_FALSE(file.up);
  };
  check(load_mesh(write_file("two.obj", obj_document)));
  check(load_mesh(write_file("two.ply", ply_document)));
  check(load_mesh(write_file("two.off", off_document)));
  check(load_mesh(write_file("TWO.OFF", off_document)));
}

TEST_CASE("vertex order survives in a mesh with many vertices, some doubled, one of no triangle") {
  const TriangleMesh mesh = joined(joined(make_sphere(1, 3), make_box({1, 1, 1})), make_sphere(1, 3));
  std::string obj, ply = "ply\nformat ascii 1.0\nelement vertex ", off = "OFF\n";
  const Eigen::Index num_vertices = mesh.num_vertices() + 1;
  ply += std::to_string(num_vertices) + "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
         std::to_string(mesh.num_triangles()) + "\nproperty list uchar int vertex_indices\nend_header\n";
  off += std::to_string(num_vertices) + " " + std::to_string(mesh.num_triangles()) + " 0\n";
  char line[200];
  for (Eigen::Index v = 0; v < num_vertices; ++v) {
    const Eigen::RowVector3d p =
        v < mesh.num_vertices() ? Eigen::RowVector3d(mesh.positions.row(v)) : Eigen::RowVector3d(7, 7, 7);
    std::snprintf(line, sizeof line, "%.17g %.17g %.17g\n", p[0], p[1], p[2]);
    obj += std::string("v ") + line;
    ply += line;
    off += line;
  }
  for (const auto& t : mesh.triangles.rowwise()) {
    std::snprintf(line, sizeof line, "f %d %d %d\n", t[0] + 1, t[1] + 1, t[2] + 1);
    obj += line;
    std::snprintf(line, sizeof line, "3 %d %d %d\n", t[0], t[1], t[2]);
    ply += line;
    off += line;
  }
  const auto check = [&](const std::filesystem::path& path, double precision) {
    const TriangleMesh read = load_mesh(path).mesh;
    REQUIRE(read.num_vertices() == mesh.num_vertices());
    CHECK((read.positions - mesh.positions).cwiseAbs().maxCoeff() < precision);
    CHECK(read.triangles == mesh.triangles);
  };
  check(write_file("many.obj", obj), 1e-14);
  check(write_file("many.ply", ply), 1e-14);
  check(write_file("many.off", off), 1e-14);
}

TEST_CASE("OBJ: texture coordinates per corner, the colour texture, parts") {
  write_file("paint.mtl", "newmtl red\nmap_Kd paint.png\n");
  write_file("paint.png", "not looked at");
  const MeshFile file = load_mesh(write_file("two.obj", obj_document));
  REQUIRE(file.mesh.texture_coordinates.rows() == 9);
  const float expected[5][2] = {{0.5f, 0.5f}, {0, 0}, {1, 1}, {1, 0}, {0, 1}};  // by vertex
  for (Eigen::Index corner = 0; corner < 9; ++corner)
    for (int k = 0; k < 2; ++k)
      CHECK(file.mesh.texture_coordinates(corner, k) == expected[file.mesh.triangles(corner / 3, corner % 3)][k]);
  REQUIRE(file.materials.size() == 1);
  CHECK(file.materials[0].name == "red");
  CHECK(file.materials[0].texture.filename() == "paint.png");
  CHECK(file.materials[0].texture.is_absolute());
  CHECK(file.mesh.materials.empty());
  CHECK(file.num_parts == 2);
}

TEST_CASE("PLY: vertex colours become linear") {
  const MeshFile file = load_mesh(write_file("two.ply", ply_document));
  REQUIRE(file.mesh.colors.rows() == 5);
  CHECK(file.mesh.colors(0, 0) == Approx(1));
  CHECK(file.mesh.colors(0, 1) == Approx(0).margin(1e-9));
  CHECK(file.mesh.colors(1, 1) == Approx(0.50289).epsilon(1e-4));  // 188 of 255
}

TEST_CASE("STL, as text and binary: three vertices a facet") {
  for (const auto& path : {write_file("text.stl", stl_document), write_file("binary.stl", binary_stl())}) {
    const TriangleMesh mesh = load_mesh(path).mesh;
    CHECK(mesh.num_vertices() == 6);
    REQUIRE(mesh.num_triangles() == 2);
    CHECK(mesh.positions.row(4) == Eigen::RowVector3d(1, 1, 0));
    CHECK(report_mesh(mesh).num_boundary_edges == 4);
  }
  CHECK(load_mesh(write_file("solid.stl", "solid" + binary_stl().substr(5))).mesh.num_triangles() == 2);
  refuses(65, write_file("word.stl", replaced(stl_document, "vertex 1 0 0", "vertex 1 o 0")),
          "word.stl:5: a coordinate");
  refuses(65, write_file("nan.stl", replaced(stl_document, "vertex 1 0 0", "vertex 1 nan 0")), "not finite");
  refuses(65, write_file("two.stl", replaced(stl_document, "vertex 1 0 0\n", "")), "other than three vertices");
  std::string many = binary_stl();
  many.replace(80, 4, "\xff\xff\xff\xff");
  refuses(65, write_file("many.stl", many), "truncated");
}

TEST_CASE("glTF: every node's copy, metres, Y up") {
  const MeshFile file = load_mesh(write_file("two.gltf", gltf_document));
  CHECK(file.mesh.num_vertices() == 6);
  CHECK(file.mesh.num_triangles() == 2);
  CHECK(file.mesh.positions.col(0).maxCoeff() == 11);
  CHECK(file.unit.value() == 1.0);
  CHECK(file.up.value() == "y");
  CHECK(file.num_parts == 2);
}

TEST_CASE("COLLADA: file units and axes, node transforms, corners joined") {
  const MeshFile file = load_mesh(write_file("two.dae", collada_document));
  check_faces(file.mesh);
  CHECK(file.mesh.num_vertices() == 5);
  CHECK(file.unit.value() == Approx(0.0254));
  CHECK(file.up.value() == "z");
  CHECK((file.mesh.positions.col(2).array() == 5).all());
  CHECK(file.mesh.positions.col(1).maxCoeff() == 1);
}

TEST_CASE("FBX: file units and axes, node transforms, corners joined") {
  const MeshFile file = load_mesh(write_file("two.fbx", fbx_document));
  check_faces(file.mesh);
  CHECK(file.mesh.num_vertices() == 5);
  CHECK(file.unit.value() == Approx(0.01));
  CHECK(file.up.value() == "z");
  CHECK((file.mesh.positions.col(2).array() == 5).all());
  CHECK(file.mesh.positions.col(1).maxCoeff() == 1);
}

TEST_CASE("a triangle that names a vertex twice is left out, with its texture coordinates and a note") {
  const std::string two = replaced(obj_document, "mtllib paint.mtl\n", "");
  const MeshFile whole = load_mesh(write_file("whole.obj", two));
  CHECK(whole.notes.empty());
  const auto check = [&](const MeshFile& file, const std::string& note) {
    REQUIRE(file.notes.size() == 1);
    CHECK(file.notes[0] == note);
    CHECK(file.mesh.triangles == whole.mesh.triangles);
    CHECK(file.mesh.texture_coordinates == whole.mesh.texture_coordinates);
    CHECK(file.mesh.num_vertices() == 5);
  };
  check(load_mesh(write_file("one.obj", replaced(two, "f 2/1", "f 1/1 1/2 2/3\nf 2/1"))),
        "1 triangle names a vertex twice: left out");
  check(load_mesh(
            write_file("several.obj", replaced(two, "o second", "f 3/1 1/2 3/3\nf 4/1 4/2 4/3") + "f 2/1 3/2 3/3\n")),
        "3 triangles name a vertex twice: left out");
  // of a quad with a doubled corner one triangle stays
  const MeshFile quad = load_mesh(write_file("quad.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 2 3\n"));
  CHECK(quad.mesh.num_triangles() == 1);
  CHECK(quad.notes.size() == 1);
}

TEST_CASE("files that are not there or no files are not found") {
  refuses(66, "no/such/mesh.obj", "does not exist");
  refuses(66, write_file("x.obj", "").parent_path(), "folder");
}

TEST_CASE("files that cannot be used say what is wrong") {
  const std::string obj = obj_document, ply = ply_document, off = off_document;
  refuses(65, write_file("empty.obj", ""), "empty");
  refuses(65, write_file("empty.ply", ""), "empty");
  refuses(65, write_file("mesh.xyz", "1 2 3"), "known are obj, ply, stl, off, gltf, glb, fbx, dae");
  refuses(65, write_file("points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), "no triangles");
  refuses(65, write_file("nan.obj", replaced(obj, "v 1 1 0", "v nan 1 0")),
          "1 of 5 vertices are not finite numbers, the first is vertex 2");
  refuses(65, write_file("inf.obj", replaced(obj, "v 1 1 0", "v 1 -inf 0")), "not finite");
  refuses(65, write_file("huge.obj", replaced(obj, "v 1 1 0", "v 1 2e9 0")), "absurdly large");
  refuses(65, write_file("overflow.obj", replaced(obj, "v 1 1 0", "v 1 2e999 0")), "");
  refuses(65, write_file("word.obj", replaced(obj, "v 1 1 0", "v 1 one 0")), "no number");
  refuses(65, write_file("range.obj", replaced(obj, "f 2/1", "f 9/1")), "does not exist");
  refuses(65, write_file("negative.obj", replaced(obj, "f -2/2", "f -9/2")), "");
  refuses(65, write_file("zero.obj", replaced(obj, "f 2/1", "f 0/1")), "");
  refuses(65, write_file("cut.obj", obj.substr(0, obj.find("v 1 0 0") + 4)), "");
  refuses(65, write_file("cut2.obj", obj.substr(0, obj.rfind(" 3/3"))), "three corners");
  refuses(65, write_file("point.obj", "v 1 2 3\nv 1 2 3\nv 1 2 3\nf 1 2 3\n"), "one point");
  refuses(65, write_file("collapsed.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 1 2\n"),
          "no triangle of the mesh has an area");
  refuses(65, write_file("line.obj", "v 0 0 0\nv 1 0.3 0.7\nv 2 0.6 1.4\nf 1 2 3\n"), "has an area");
  const std::string beyond = "a face names a vertex beyond all that can be counted";
  for (const char* index :
       {"18446744073709551619", "4294967299", "-4294967299", "2/18446744073709551617", "2//4294967297"})
    refuses(65, write_file("beyond.obj", replaced(obj, "f 2/1", "f " + std::string(index))), "obj:15: " + beyond);
  refuses(65, write_file("letters.obj", replaced(obj, "f 2/1", "f 2x/1")), "a corner that is no number");
  refuses(65, write_file("binary.obj", std::string("\0\1\2\3\xff\xfe rubbish \n", 16)), "no vertices");

  refuses(65, write_file("nan.ply", replaced(ply, "1 1 0 0", "nan 1 0 0")), "not finite");
  refuses(65, write_file("cut.ply", ply.substr(0, ply.rfind("3 3 0 2"))), "truncated");
  refuses(65, write_file("header.ply", ply.substr(0, 100)), "without end_header");
  refuses(65, write_file("range.ply", replaced(ply, "3 3 0 2", "3 3 0 7")), "");
  refuses(65,
          write_file("nofaces.ply", replaced(ply.substr(0, ply.rfind("4 1 3")), "element face 2", "element face 0")),
          "");
  refuses(65, write_file("cut.off", off.substr(0, off.rfind("3 3 0 2"))), "truncated");
  refuses(65, write_file("nan.off", replaced(off, "1 1 0", "nan 1 0")), "");
  refuses(65, write_file("range.off", replaced(off, "3 3 0 2", "3 3 0 9")), "vertex 9");
  refuses(65, write_file("negative.off", replaced(off, "3 3 0 2", "3 3 0 -1")), "vertex -1");
  refuses(65, write_file("counts.off", "OFF\n"), "");
  refuses(65, write_file("cut.stl", binary_stl().substr(0, 150)), "truncated");
  refuses(65, write_file("cuttext.stl", std::string(stl_document).substr(0, 150)), "truncated");
  refuses(65, write_file("none.stl", "solid none\nendsolid none\n"), "");
  refuses(65, write_file("cut.gltf", std::string(gltf_document).substr(0, 400)), "");
  refuses(65, write_file("cut.dae", std::string(collada_document).substr(0, 900)), "");
  refuses(65, write_file("cut.fbx", std::string(fbx_document).substr(0, 700)), "");
  refuses(65, write_file("rubbish.fbx", "rubbish"), "");
  refuses(65, write_file("rubbish.glb", "rubbish"), "");
}
