// Materials and textures of users' mesh files, and files of foreign formats that need more than their library can.
#include "core/base/error.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/mesh_report.h"
#include "tests/embedding/mesh_file_checks.h"
#include "tests/embedding/mesh_files.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"

using namespace umax;
using namespace umax::testing;
using umax::test::replaced;

namespace {

/// Three triangles of three materials; the second has a texture, the third no texture coordinates.
const char* const three_materials = R"(mtllib three.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 2 0 0
vt 0 0
vt 1 0
vt 1 1
usemtl red
f 1/1 2/2 3/3
usemtl picture
f 1/1 3/2 4/3
f 2 5 3
usemtl nowhere
f 1/1 3/2 4/3
)";

}  // namespace

TEST_CASE("OBJ: several materials keep their colours and textures, and what is missing is noted") {
  write_file("three.mtl",
             "newmtl unused\nKd 0 1 0\nmap_Kd unused.png\nnewmtl red\nKd 1 0 0\nnewmtl picture\nKd 0 0 0\nmap_Kd "
             "images\\here.png\nnewmtl plain\n");
  write_file("here.png", "not looked at");
  const MeshFile file = load_mesh(write_file("three.obj", three_materials));
  REQUIRE(file.materials.size() == 4);
  CHECK(file.mesh.materials == std::vector<int>{0, 1, 2, 3});
  CHECK(file.materials[0].color == Vector3d(1, 0, 0));
  CHECK(file.materials[1].texture.filename() == "here.png");  // found by its name, without its folder
  CHECK(file.materials[1].texture_tint == Vector3d(1, 1, 1));
  CHECK(!file.materials[2].has_texture());  // its triangle has no texture coordinates
  CHECK(file.materials[2].name == "picture");
  CHECK(!file.materials[3].has_color());
  CHECK(file.notes.empty());

  write_file("three.mtl", "newmtl red\nKd 1 0 0\nnewmtl picture\nKd 0 0 1\nmap_Kd gone.png\n");
  const MeshFile gone = load_mesh(write_file("three.obj", three_materials));
  CHECK(notes_say(gone, "gone.png"));
  CHECK(gone.materials[1].color == Vector3d(0, 0, 1));
  const MeshFile bare = load_mesh(write_file("bare.obj", replaced(three_materials, "three.mtl", "gone.mtl")));
  CHECK(notes_say(bare, "gone.mtl"));
  CHECK(bare.materials.empty());
  CHECK(bare.mesh.materials.empty());
}

TEST_CASE("glTF: base colours, textures inside the file and beside it, and no scene to show") {
  const std::string gltf = gltf_document;
  const MeshFile none = load_mesh(write_file("none.gltf", gltf));
  CHECK(none.materials.empty());

  std::string painted = replaced(gltf, "\"mode\":4}]",
                                 "\"mode\":4,\"material\":0},{\"attributes\":{\"POSITION\":1},"
                                 "\"indices\":0,\"material\":1}]");
  painted = replaced(painted, "\"buffers\"", R"("materials":[{"name":"red","pbrMetallicRoughness":{"baseColorFactor":
[1,0.25,0,1]}},{"name":"blue","pbrMetallicRoughness":{"baseColorFactor":[0,0,1,1]}}],"buffers")");
  const MeshFile two = load_mesh(write_file("two.gltf", painted));
  REQUIRE(two.materials.size() == 2);
  CHECK(two.materials[0].color == Vector3d(1, 0.25, 0));  // linear, as it stands there
  CHECK(two.materials[1].color == Vector3d(0, 0, 1));
  CHECK(two.mesh.materials == std::vector<int>{0, 1, 0, 1});

  std::string pictured = replaced(painted, "\"baseColorFactor\":\n[1,0.25,0,1]", "\"baseColorTexture\":{\"index\":0}");
  pictured =
      replaced(pictured, "\"materials\"", R"("textures":[{"source":0}],"images":[{"uri":"a%20b.png"}],"materials")");
  pictured = replaced(pictured, "{\"POSITION\":1}", "{\"POSITION\":1,\"TEXCOORD_0\":2}");
  pictured = replaced(pictured, "\"max\":[1,1,0]}]",
                      "\"max\":[1,1,0]},{\"bufferView\":1,\"componentType\":5126,"
                      "\"count\":3,\"type\":\"VEC2\"}]");
  write_file("a b.png", "x");
  const MeshFile beside = load_mesh(write_file("beside.gltf", pictured));
  REQUIRE(beside.materials.size() == 2);
  CHECK(beside.materials[0].texture.filename() == "a b.png");

  const std::string no_default = replaced(gltf, "\"scene\":0,", ""),
                    no_scenes = replaced(no_default, "\"scenes\":[{\"nodes\":[0,1]}],\n", "");
  for (const std::string& less : {no_default, no_scenes}) {
    const MeshFile file = load_mesh(write_file("less.gltf", less));
    CHECK(file.mesh.num_triangles() == 2);
    CHECK(file.mesh.positions.col(0).maxCoeff() == 11);
  }
  const std::string meshes =
      replaced(no_scenes, "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[10,0,0]}],\n", "");
  const MeshFile alone = load_mesh(write_file("meshes.gltf", meshes));
  CHECK(alone.mesh.num_triangles() == 1);
}

TEST_CASE("glTF compressed by Draco is read") {
  // the quad and the triangle, quantised to 14 bits by Draco's own encoder
  const std::string gltf = R"({"asset":{"version":"2.0"},"extensionsUsed":["KHR_draco_mesh_compression"],
"extensionsRequired":["KHR_draco_mesh_compression"],"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],
"meshes":[{"primitives":[{"attributes":{"POSITION":1},"indices":0,"mode":4,"extensions":{"KHR_draco_mesh_compression":
{"bufferView":0,"attributes":{"POSITION":0}}}}]}],"buffers":[{"byteLength":98,"uri":"data:application/octet-stream;base64,)"
                           "RFJBQ08CAgEBAAAABQMAAwEAAn8A/wERAf8AAAEACQMAAAIBAQEADwPNDCvNDGkmAxhQnfj//38A4P8HAACA////"
                           R"(BwAAwP8HAAAAAAD/PwAAAAAAAAAAAAAAAAAAAAAAQA4="}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":98}],"accessors":[{"componentType":5123,"count":9,"type":"SCALAR"},
{"componentType":5126,"count":5,"type":"VEC3","min":[0,0,0],"max":[2,1,0]}]})";
  // indices of 16 bits, and of 32, which the library that reads glTF cannot decode
  for (const char* kind : {"5123", "5125"}) {
    const MeshFile file = load_mesh(write_file("draco.gltf", replaced(gltf, "5123", kind)));
    CHECK(file.mesh.num_vertices() == 5);
    CHECK(file.mesh.num_triangles() == 3);
    CHECK(report_mesh(file.mesh).area == Approx(1.5).epsilon(1e-3));
    CHECK(report_mesh(file.mesh).num_inconsistent_edges == 0);
  }
  check_refused(write_file("draco.gltf", replaced(replaced(gltf, "5123", "5125"), "RFJBQ08C", "RFJBQ08D")),
                {"not a sound gltf file"});
  check_refused(
      write_file("draco.gltf", replaced(replaced(gltf, "5123", "5125"), "\"byteLength\":98}]", "\"byteLength\":60}]")),
      {"not a sound gltf file"});
  check_refused(write_file("draco.gltf", replaced(gltf, "RFJBQ08C", "RFJBQ08D")), {"not a sound gltf file"});
}

TEST_CASE("FBX of a version before 7 is told apart from a damaged file, with what to do") {
  const std::string text = replaced(replaced(fbx_document, "FBX 7.3.0", "FBX 6.1.0"), "7300", "6100");
  check_refused(write_file("old.fbx", text), {"FBX 6.1", "save it as FBX 2011"});
  std::string binary("Kaydara FBX Binary  \0\x1a\0", 23);
  binary += raw(std::uint32_t(6100), false) + std::string(100, '\0');
  check_refused(write_file("old.fbx", binary), {"FBX 6.1", "save it as FBX 2011"});
}
