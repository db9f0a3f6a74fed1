// Files that end or never end the library that reads them: the program says so and goes on.
#include <cstdlib>

#include "core/base/error.h"
#include "embedding/foreign_files/foreign_file.h"
#include "embedding/mesh_files/foreign_mesh.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/mesh_record/mesh_record.h"
#include "tests/embedding/mesh_files.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"
#include "tests/support/failure.h"
#include "tests/support/replaced.h"

using namespace umax;
using namespace umax::testing;
using umax::test::contains;
using umax::test::failure_of;
using umax::test::replaced;

namespace {

/// A geometry and a model of one number: the library follows the one where it means the other.
std::string colliding_fbx() {
  std::string text = replaced(fbx_document, "Model: 200", "Model: 100");
  text = replaced(text, "\"OO\",200,0", "\"OO\",100,0");
  return replaced(text, "\"OO\",100,200", "\"OO\",100,100");
}

/// Nodes each of which holds the next one twice: 2^n triangles in a file of a few kilobytes.
std::string doubling_gltf(int depth) {
  std::string nodes = "\"nodes\":[";
  for (int i = 1; i < depth; ++i) nodes += "{\"children\":[" + std::to_string(i) + "," + std::to_string(i) + "]},";
  std::string text = replaced(gltf_document, "{\"nodes\":[0,1]}", "{\"nodes\":[0]}");
  return replaced(text, "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"translation\":[10,0,0]}]", nodes + "{\"mesh\":0}]");
}

std::string record_of(const MeshFile& file) {
  std::string bytes;
  put_mesh_record(file, [&](std::string_view piece) { bytes += piece; });
  return bytes;
}

MeshFile full_file() {
  MeshFile file;
  file.mesh = make_sphere(1, 1);
  const Eigen::Index count = file.mesh.num_triangles();
  file.mesh.normals.resize(0, 3);
  file.mesh.texture_coordinates = TextureCoordinates::Random(3 * count, 2);
  file.mesh.colors = Points::Random(file.mesh.num_vertices(), 3).cwiseAbs();
  for (Eigen::Index t = 0; t < count; ++t) file.mesh.materials.push_back(int(t % 2));
  file.unit = 0.01;
  file.up = "-z";
  file.materials = {{.name = "a", .color = Vector3d(1, 0.5, 0), .texture = "/x/y.png"},
                    {.name = "b", .texture_tint = Vector3d(1, 0, 1), .embedded_texture = 0}};
  file.embedded_textures = {std::string("a\0b", 3)};
  file.notes = {"one", "", "three"};
  file.num_parts = 7;
  return file;
}

struct Variable {
  explicit Variable(const char* name, const std::string& value) : name_(name) { ::setenv(name, value.c_str(), 1); }
  ~Variable() { ::unsetenv(name_); }
  const char* name_;
};

}  // namespace

TEST_CASE("a mesh is the same through its record, which is refused when a byte is missing") {
  const MeshFile file = full_file();
  const std::string bytes = record_of(file);
  const auto read = read_mesh_record(bytes, "x");
  REQUIRE(read);
  CHECK(record_of(*read) == bytes);
  CHECK(read->mesh.positions == file.mesh.positions);
  CHECK(read->mesh.triangles == file.mesh.triangles);
  CHECK(read->mesh.texture_coordinates == file.mesh.texture_coordinates);
  CHECK(read->mesh.colors == file.mesh.colors);
  CHECK(read->mesh.materials == file.mesh.materials);
  CHECK(read->materials[1].embedded_texture == 0);
  CHECK(read->embedded_textures == file.embedded_textures);
  CHECK(*read->unit == 0.01);
  CHECK(*read->up == "-z");
  CHECK(read->notes == file.notes);
  CHECK(read->num_parts == 7);
  for (std::size_t size = 0; size < bytes.size(); size += size < 200 ? 1 : 97)
    CHECK(!read_mesh_record(bytes.substr(0, size), "x"));
}

TEST_CASE("records that a failing program left behind are refused or read, and never believed beyond their bytes") {
  const std::string bytes = record_of(full_file());
  int refused = 0, read = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at)
    for (const char bits : {'\x01', '\x80', '\xff'}) {
      std::string spoilt = bytes;
      spoilt[at] = char(spoilt[at] ^ bits);
      try {
        read_mesh_record(spoilt, "x") ? ++read : ++refused;
      } catch (const Error&) {
        ++refused;
      }
    }
  CHECK(refused > 30);
  CHECK(read > 1000);
}

TEST_CASE("errors pass through a record with the file's name") {
  std::string bytes;
  put_error_record(Error(Fault::bad_data, {"there", "is bad", "7", "mend it"}),
                   [&](std::string_view piece) { bytes += piece; });
  const auto failure = failure_of([&] { read_mesh_record(bytes, "here.fbx"); });
  CHECK(failure.code == 65);
  CHECK(failure.message == "here.fbx: is bad, got 7; mend it");
}

TEST_CASE("the helper hands over what the library reads in this process, bit for bit") {
  for (const auto& [ending, text] :
       {std::pair<std::string, std::string>{"fbx", fbx_document}, {"dae", collada_document}, {"gltf", gltf_document}}) {
    CAPTURE(ending);
    const auto path = write_file("same." + ending, text);
    CHECK(record_of(read_foreign(path, ending, import_limits(path))) == record_of(read_with_assimp(path, ending)));
  }
}

// another version of the library may find out by itself what is wrong with these files: then it says that
TEST_CASE("a file that crashes the library that reads it is an error with its name, not our end") {
  const auto path = write_file("colliding.fbx", colliding_fbx());
  const auto failure = failure_of([&] { load_mesh(path); });
  CAPTURE(failure.message);
  CHECK(failure.code == 65);
  CHECK(failure.where == path.string());
  CHECK(!failure.remedy.empty());
  // and the next file is read
  CHECK(load_mesh(write_file("good.fbx", fbx_document)).mesh.num_triangles() == 3);
}

TEST_CASE("a file that never ends is ended by the limit of memory or of time") {
  const auto path = write_file("doubling.gltf", doubling_gltf(40));
  for (const ImportLimits& limits :
       {ImportLimits{.memory = 400ll << 20, .seconds = 2}, ImportLimits{.memory = 64ll << 30, .seconds = 1}}) {
    const auto failure = failure_of([&] { read_foreign(path, "gltf", limits); });
    CAPTURE(failure.message);
    CHECK(failure.code == 65);
    CHECK(failure.where == path.string());
  }
}

TEST_CASE("limits grow with the file, and with the buffers beside a glTF") {
  const auto path = write_file("limit.gltf", gltf_document);
  const ImportLimits small = import_limits(path);
  CHECK(small.memory >= 1ll << 30);
  write_file("limit.bin", std::string(10 << 20, 'x'));
  const ImportLimits large = import_limits(path);
  CHECK(large.memory >= small.memory + (640ll << 20));
  CHECK(large.seconds == small.seconds + 10);
}

TEST_CASE("the helper is looked for beside the program, in ../libexec, and where the environment says") {
  const auto places = import_helper_places();
  REQUIRE(places.size() >= 2);
  const auto folder = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  CHECK(places[0] == folder / "umax-import");
  CHECK(places[1] == folder.parent_path() / "libexec/umax/umax-import");

  const auto mesh = write_file("two.fbx", fbx_document);
  const auto other = output_folder() / "elsewhere";
  std::filesystem::copy_file(folder / "umax-import", other, std::filesystem::copy_options::overwrite_existing);
  const Variable named("UMAX_IMPORT", other.string());
  CHECK(import_helper_places()[0] == other);
  CHECK(load_mesh(mesh).mesh.num_triangles() == 3);
}

TEST_CASE("each way in which the helper can end is told apart") {
  const auto mesh = write_file("two.fbx", fbx_document);
  const auto says = [&](const std::string& script, const ImportLimits& limits, int code, const std::string& part) {
    const auto helper = output_folder() / "helper";
    std::filesystem::remove(helper);
    write_file("helper", script);
    std::filesystem::permissions(helper, std::filesystem::perms::owner_all);
    const Variable named("UMAX_IMPORT", helper.string());
    const auto failure = failure_of([&] { read_foreign(mesh, "fbx", limits); });
    CAPTURE(script, failure.message);
    CHECK(failure.code == code);
    CHECK(failure.where == mesh.string());
    CHECK(contains(failure.message, part));
    CHECK(!failure.remedy.empty());
  };
  const ImportLimits limits{.memory = 400ll << 20, .seconds = 20};
  says("#!/bin/sh\nkill -SEGV $$\n", limits, 65, "makes the program that reads it fail, got signal 11");
  says("#!/bin/sh\necho half a record\nkill -ABRT $$\n", limits, 65, "signal 6");
  says("#!/bin/sh\nexit 0\n", limits, 65, "exit code 0");
  says("#!/bin/sh\nexit 71\n", limits, 65, "cannot be read within 400 MiB of memory");
  says("#!/bin/sh\nkill -XCPU $$\n", limits, 65, "cannot be read within 20 s");
  says("#!/bin/sh\nsleep 100\n", {.memory = 400ll << 20, .seconds = 0}, 65, "cannot be read within 0 s");
  says("#!/bin/sh\nexit 64\n", limits, 69, "another version");
  const std::string tell_tuning =
      "#!/bin/sh\ncase \"$GLIBC_TUNABLES\" in glibc.malloc.hugetlb=1) exit 91;; ours) exit 92;; esac\n";
  says(tell_tuning, limits, 65, "exit code 91");
  const Variable tuned("GLIBC_TUNABLES", "ours");
  says(tell_tuning, limits, 65, "exit code 92");
  const auto helper = output_folder() / "helper";
  std::filesystem::remove(helper);
  std::filesystem::permissions(write_file("helper", "no program"), std::filesystem::perms::owner_all);
  const Variable named("UMAX_IMPORT", helper.string());
  const auto failure = failure_of([&] { load_mesh(mesh); });
  CHECK(failure.code == 69);
  CHECK(contains(failure.message, "cannot be started"));
}
