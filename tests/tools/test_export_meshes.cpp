// umax export: what the mesh file has, exports have: all its vertices in its order, its materials and textures.
#include "embedding/mesh_files/mesh_io.h"
#include "tests/support/failure.h"
#include "tests/tools/exported_block.h"

using namespace umax;
using namespace umax::exported_block;
namespace fs = std::filesystem;

TEST_CASE("a texture is copied beside the mesh that has it") {
  const TemporaryFolder folder;
  make_file(folder / "quad.obj",
            "mtllib quad.mtl\nv 0 0 0\nv 0.4 0 0\nv 0 0.4 0\nv 0 0 0.4\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m\n"
            "f 1/1 3/2 2/3\nf 1/1 2/2 4/3\nf 2/1 3/2 4/3\nf 3/1 1/2 4/3\n");
  fs::copy_file(fs::path(UMAX_SOURCE_DIR) / "tests/golden/raster_heat_map.png", folder / "skin.png");
  make_file(folder / "quad.mtl", "newmtl m\nmap_Kd skin.png\n");
  const std::string scene =
      write_scene(folder, "[clip]\nframes = 2\n[body.quad]\nmesh = \"quad.obj\"\ncage.cells = [2, 2, 2]\n").string();
  const std::string run = (folder / "run").string();
  REQUIRE(exit_code_of({"simulate", scene, "-o", run, "--quiet", "--export", "mdd", "--export", "obj"}) == 0);
  CHECK(read_file(folder / "run/export/quad.png") == read_file(folder / "skin.png"));
  CHECK(load_mesh(folder / "run/export/quad.obj").materials.at(0).texture == folder / "run/export/quad.png");
  CHECK(load_mesh(folder / "run/export/quad/0002.obj").materials.at(0).texture == folder / "run/export/quad/quad.png");
}

namespace {

/// A cube of 0.4 m whose file has vertices of no triangle before, between and behind its own.
const std::string loose_cube =
    "v 0 0 0\nv -0.2 -0.2 -0.2\nv 0.2 -0.2 -0.2\nv 0.2 0.2 -0.2\nv -0.2 0.2 -0.2\nv 3 0.5 0\nv -0.2 -0.2 0.2\n"
    "v 0.2 -0.2 0.2\nv 0.2 0.2 0.2\nv -0.2 0.2 0.2\nv 0 0.7 0\nf 2 4 3\nf 2 5 4\nf 7 8 9\nf 7 9 10\nf 2 3 8\nf 2 8 7\n"
    "f 5 10 9\nf 5 9 4\nf 2 7 10\nf 2 10 5\nf 3 4 9\nf 3 9 8\n";
const std::vector<int> loose_places{0, 5, 10};

const std::string spinning_cube = R"([clip]
frames = 10
gravity = [0, 0, 0]
[body.cube]
mesh = "cube.obj"
position = [1, 2, 3]
rotation = [0, 0, 30]
velocity = [1, 0, 0]
spin = [0, 0, 200]
cage.cells = [2, 2, 2]
material.young = "10 MPa"
)";

}  // namespace

TEST_CASE("a cache fits a mesh with vertices of no triangle: all are there, in the file's order, and go along") {
  const TemporaryFolder folder;
  make_file(folder / "cube.obj", loose_cube);
  const std::string scene = write_scene(folder, spinning_cube).string(), run = (folder / "run").string();
  REQUIRE(exit_code_of({"simulate", scene, "-o", run, "--quiet", "--export", "pc2", "--export", "ply"}) == 0);
  const fs::path cache = folder / "run/export/cube.pc2";
  const FloatPoints first = read_pc2(cache, 0), last = read_pc2(cache, 9);
  REQUIRE(first.rows() == 11);

  // at rest: the file's vertices, turned and moved
  const Eigen::RowVector3f centre(1, 2, 3);
  CHECK((first.row(0) - centre).norm() < 1e-6f);
  const float cosine = std::cos(float(EIGEN_PI) / 6), sine = 0.5f;
  const Eigen::RowVector3f far(3 * cosine - 0.5f * sine, 3 * sine + 0.5f * cosine, 0);
  CHECK((first.row(5) - centre - far).norm() < 1e-6f);
  CHECK((first.row(10) - centre - Eigen::RowVector3f(-0.7f * sine, 0.7f * cosine, 0)).norm() < 1e-6f);

  // a stiff body turns as a rigid one: so do they
  const float turn = float(EIGEN_PI) / 180 * 200 * 9 / 60, moved = 9 / 60.0f;
  for (Eigen::Index v = 0; v < 11; ++v) {
    const Eigen::RowVector3f at = first.row(v) - centre;
    const Eigen::RowVector3f wanted(std::cos(turn) * at.x() - std::sin(turn) * at.y(),
                                    std::sin(turn) * at.x() + std::cos(turn) * at.y(), at.z());
    CHECK((last.row(v) - centre - Eigen::RowVector3f(moved, 0, 0) - wanted).norm() < 0.02f * (1 + at.norm()));
  }
  CHECK((last.row(5) - first.row(5)).norm() > 1);

  // the meshes beside it have them, too
  for (const char* file : {"run/export/cube.obj", "run/export/cube/0001.ply"}) {
    const MeshFile mesh = load_mesh(folder / file);
    CHECK(mesh.vertex_in_file == std::vector<int>{1, 2, 3, 4, 6, 7, 8, 9});
    CHECK(mesh.mesh.triangles == load_mesh(folder / "cube.obj").mesh.triangles);
    for (Eigen::Index i = 0; i < 3; ++i)
      CHECK((mesh.loose_vertices.row(i).cast<float>() - first.row(loose_places[std::size_t(i)])).norm() < 1e-6f);
  }
}

TEST_CASE("velocities of vertices of no triangle are what they move by") {
  const TemporaryFolder folder;
  make_file(folder / "cube.obj", loose_cube);
  const Simulation simulation = set_up(load_scene(write_scene(folder, spinning_cube).string(), {}));
  const ExportOptions options{.format = ExportFormat::ply};
  const ExportedThing thing = things_to_export(simulation, options).at(0);
  const SurfaceFrame frame = sample(simulation, thing, options, 1, rest_state(simulation.model));
  const Vector3d spin(0, 0, double(EIGEN_PI) / 180 * 200), centre(1, 2, 3);
  for (Eigen::Index v = 0; v < 11; ++v) {
    const Vector3d wanted = Vector3d(1, 0, 0) + spin.cross(frame.positions.row(v).cast<double>().transpose() - centre);
    CHECK((frame.velocities.row(v).cast<double>().transpose() - wanted).norm() < 1e-5);
    CHECK(std::abs(frame.normals.row(v).norm() - 1) < 1e-5f);
  }
}

TEST_CASE("a vertex of no triangle whose coordinates are no numbers ends no export") {
  const TemporaryFolder folder;
  make_file(folder / "cube.off",
            "OFF\n5 4 0\n0 0 0\nnan 0 0\n0.4 0 0\n0 0.4 0\n0 0 0.4\n3 0 3 2\n3 0 2 4\n3 2 3 4\n3 3 0 4\n");
  std::string text = spinning_cube;
  text.replace(text.find("cube.obj"), 8, "cube.off");
  const std::string scene = write_scene(folder, text).string(), run = (folder / "run").string();
  REQUIRE(exit_code_of({"simulate", scene, "-o", run, "--frames", "1-2", "--quiet", "--export", "pc2"}) == 0);
  CHECK(read_pc2(folder / "run/export/cube.pc2", 1).allFinite());
}

namespace {

/// A tetrahedron whose faces have three materials, one of them twice and not side by side.
void write_patchwork(const TemporaryFolder& folder) {
  make_file(
      folder / "patch.obj",
      "mtllib patch.mtl\nv 0 0 0\nv 0.4 0 0\nv 0 0.4 0\nv 0 0 0.4\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red-paint\n"
      "f 1/1 3/2 2/3\nusemtl skin\nf 1/1 2/2 4/3\nusemtl red-paint\nf 2/1 3/2 4/3\nusemtl plate\nf 3/1 1/2 4/3\n");
  make_file(folder / "patch.mtl",
            "newmtl red-paint\nKd 1 0 0\nnewmtl skin\nmap_Kd skin.png\nnewmtl plate\nKd 1 1 1\nmap_Kd plate.png\n");
  const fs::path golden = fs::path(UMAX_SOURCE_DIR) / "tests/golden";
  fs::copy_file(golden / "raster_heat_map.png", folder / "skin.png");
  fs::copy_file(golden / "raster_heat_map.png", folder / "plate.png");
}

}  // namespace

TEST_CASE("several materials of a body keep their triangles, colours and textures") {
  const TemporaryFolder folder;
  write_patchwork(folder);
  const std::string scene =
      write_scene(folder, "[clip]\nframes = 2\n[body.patch]\nmesh = \"patch.obj\"\ncage.cells = [2, 2, 2]\n").string();
  const std::string run = (folder / "run").string();
  REQUIRE(exit_code_of({"simulate", scene, "-o", run, "--quiet", "--export", "pc2", "--export", "obj", "--export",
                        "gltf", "--export", "usd"}) == 0);
  const fs::path exports = folder / "run/export";
  for (const char* file : {"patch.obj", "patch/0002.obj"}) {
    CAPTURE(file);
    const MeshFile mesh = load_mesh(exports / file);
    REQUIRE(mesh.materials.size() == 3);
    CHECK(mesh.mesh.materials == std::vector<int>{0, 1, 0, 2});
    CHECK(mesh.materials[0].name == "red-paint");
    REQUIRE(mesh.materials[0].color);
    CHECK((*mesh.materials[0].color - Vector3d(1, 0, 0)).norm() < 1e-6);
    CHECK(mesh.materials[1].texture.filename() == "patch.png");
    CHECK(mesh.materials[2].texture.filename() == "patch.2.png");
    CHECK(read_file(mesh.materials[2].texture) == read_file(folder / "plate.png"));
  }
  const MeshFile gltf = load_mesh(exports / "patch.gltf");
  REQUIRE(gltf.materials.size() == 3);
  CHECK(gltf.mesh.materials == std::vector<int>{0, 0, 1, 2});  // a part for each
  CHECK(gltf.materials[2].has_texture());

  const std::string usd = read_file(exports / "patch.usda");
  CHECK(test::contains(usd, "int[] indices = [0, 2]\n"));
  CHECK(test::contains(usd, "rel material:binding = </patch/red_paint>"));
  CHECK(test::contains(usd, "def Material \"plate\""));
  CHECK(test::contains(usd, "asset inputs:file = @./patch.2.png@"));
}

TEST_CASE("names of materials are plain, and none is there twice") {
  CHECK(material_names({"a b", "a_b", "", "K\"{}", "a b"}) ==
        std::vector<std::string>{"a_b", "a_b_2", "material", "K___", "a_b_3"});
}
