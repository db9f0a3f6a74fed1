#include "tests/fuzz/seeds.h"

#include "core/model/model.h"
#include "render/image/image_codecs.h"
#include "scenes/builtin_scenes.h"
#include "scenes/resolved_scene.h"
#include "scenes/scene_file.h"
#include "tests/embedding/camera_files.h"
#include "tests/embedding/hex_files.h"
#include "tests/embedding/mesh_files.h"
#include "tests/support/jpeg_file.h"
#include "tools/setup/pull_file.h"
#include "tools/setup/state_file.h"

namespace umax::fuzz {
namespace {

using testing::raw;

void add_scenes(std::vector<Seed>& list) {
  for (const BuiltinScene& scene : builtin_scenes())
    list.push_back({"scene", scene.name + ".toml", std::string(scene.text)});
  // every key with its default
  list.push_back({"scene", "resolved.toml", resolved_toml(parse_scene({.text = R"(
[body.b]
shape = "sphere"
radius = "10 cm"
position = [0, 1, 0]
material.preset = "rubber"
material.young = { keys = [[0, "500 kPa"], ["0.5 s", 1e6]], interpolation = "smooth" }
limit.stretch = "20 %"
fixed = [{ min = [-1, -1, -1], max = [1, 1, 1] }]
[obstacle.ground]
shape = "plane"
position = { keys = [[0, [0, 0, 0]], [1, [0, 0.1, 0]]], interpolation = "hold" }
[probe.p]
body = "b"
point = [0, 1, 0]
[light.sun]
[camera]
)"}))});
  int number = 0;
  for (const char* text : {"500 kPa", "-1.5e3 kg/m^3", "20 %", "0.5 turn/s", "+.5 J/cm^3", "9.81 m/s^2", "1 / s"})
    list.push_back({"quantity", std::to_string(number++), text});
  list.push_back({"presets", "own.toml", R"([gel]
description = "soft"
source = "a table"
material.young = "40 kPa"
material.poisson = 0.45
material.density = "1000 kg/m^3"
limit.stretch = "30 %"
)"});
}

State sample_state() {
  State state{.time = 0.3,
              .step = 12,
              .been_feasible = true,
              .positions = {},
              .velocities = {},
              .limit_multipliers = {},
              .contacts = {}};
  state.positions = state.velocities = Points::Constant(4, 3, 0.25);
  state.limit_multipliers = VectorXd::Constant(2, 1.5);
  state.contacts = {{.point = {ContactKind::vertex, 7}, .obstacle = 0, .hex = 3, .impulse = {0.1, 1e-17, -3}},
                    {.point = {ContactKind::obstacle_edge, 3}, .obstacle = 2, .hex = 5, .impulse = {1, 2, 3}}};
  return state;
}

void add_data(std::vector<Seed>& list) {
  const std::string state = encode_state(sample_state(), Digest(64, 'a'));
  list.push_back({"state", "whole", state});
  list.push_back({"state", "body", state.substr(0, state.size() - 64)});
  Model model;
  model.bodies.resize(1);
  model.bodies[0].name = "bar";
  Pull pull{.body = "bar", .hex = 0, .stiffness = 10, .place = {0, 1, 0}};
  pull.weights.setConstant(0.125);
  const std::string pulls = encode_pulls({{3, {pull}}}, model);
  list.push_back({"state", "pulls", pulls.substr(0, pulls.size() - 64)});
  list.push_back({"measurements", "stress.csv",
                  "# rubber\nstrain [%],stress [kPa],lateral strain [%],remark\n0,0,0,\n10,50,-4.5,\n20,110,-8,\"a, "
                  "\"\"b\"\"\"\n30,180,-12,\n40,260,-15,\n"});
  list.push_back({"measurements", "force.csv",
                  "Displacement [mm],Force [N]\r\n0,0\r\n1,2.5\r\n2,5.5\r\n3,n/a\r\n4,12\r\n5,16\r\n6,21\r\n"});
  list.push_back({"measurements", "ratio.csv", "stretch,stress_MPa\n1,0\n1.1,0.1\n1.2,0.22\n1.3,0.35\n1.5,0.8\n"});
}

void add_meshes(std::vector<Seed>& list) {
  using namespace testing;
  list.push_back({"mesh", "a.obj", obj_document});
  list.push_back({"mesh", "a.ply", ply_document});
  list.push_back({"mesh", "a.off", off_document});
  list.push_back({"mesh", "a.stl", stl_document});
  list.push_back({"mesh", "binary.stl", binary_stl()});
  std::string ply =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n";
  for (const float number : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) ply += raw(number);
  list.push_back({"mesh", "strip.ply", ply + raw(3) + raw(0) + raw(1) + raw(2)});
  std::string off = "OFF BINARY\n" + raw(3, true) + raw(1, true) + raw(0, true);
  for (const float number : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) off += raw(number, true);
  off += raw(3, true) + raw(0, true) + raw(1, true) + raw(2, true) + raw(0, true);
  list.push_back({"mesh", "binary.off", off});

  const HexDocument hexes = document_of(make_box_lattice({2, 1, 1}, {0, 0, 0}, {1, 1, 1}));
  list.push_back({"hexes", "1.msh", gmsh_1(hexes)});
  for (const bool binary : {false, true}) {
    const std::string kind = binary ? "-binary" : "";
    list.push_back({"hexes", "2" + kind + ".msh", gmsh_2(hexes, binary)});
    list.push_back({"hexes", "4.0" + kind + ".msh", gmsh_4_0(hexes, binary)});
    list.push_back({"hexes", "4.1" + kind + ".msh", gmsh_4(hexes, binary)});
    for (const int version : {2, 5})
      list.push_back({"hexes", std::to_string(version) + kind + ".vtk", vtk_legacy(hexes, version, binary)});
  }
  list.push_back({"hexes", "a.vtu", vtu(hexes, {})});
  list.push_back({"hexes", "binary.vtu", vtu(hexes, {.format = "binary", .compressed = true})});
  list.push_back({"hexes", "raw.vtu", vtu(hexes, {.format = "appended", .encoding = "raw", .long_headers = true})});
  list.push_back({"hexes", "appended.vtu", vtu(hexes, {.format = "appended", .big_endian = true})});
}

void add_moving(std::vector<Seed>& list) {
  using namespace testing;
  std::string pc2 = std::string("POINTCACHE2\0", 12) + raw(1) + raw(2) + raw(0.f) + raw(0.04f) + raw(3);
  std::string mdd = raw(3, true) + raw(2, true) + raw(0.f, true) + raw(0.04f, true) + raw(0.08f, true);
  for (int i = 0; i < 3 * 2 * 3; ++i) pc2 += raw(float(i)), mdd += raw(float(i), true);
  list.push_back({"cache", "a.pc2", pc2});
  list.push_back({"cache", "a.mdd", mdd});
  list.push_back({"camera", "a.usda", usda});
  list.push_back({"camera", "a.gltf", gltf_text(data_uri(animation_bytes()))});
  list.push_back({"camera", "steps.gltf", gltf_text(data_uri(animation_bytes()), "STEP")});
  list.push_back({"camera", "a.glb", glb(gltf_text(""), animation_bytes())});
  list.push_back({"messages", "all", R"({"wish":"play"}
{"wish":"set","key":1,"value":0.25}
{"wish":"grab","body":0,"vertex":3,"place":[0.1,2,-3e-1]}
{"wish":"move","place":[1,2,3]}
{"wish":"step"}
{"wish":"slower","value":4}
{"wish":"show","frame":2}
{"wish":"place","obstacle":0,"place":[0,0.5,0]}
{"wish":"release"}
{"wish":"restart"}
{"wish":"lines"}
)"});
}

void add_pictures(std::vector<Seed>& list) {
  for (const int channels : {1, 3, 4}) {
    const std::string name = std::to_string(channels);
    Image8 codes(5, 3, channels);
    Image values(5, 3, channels);
    for (std::size_t i = 0; i < codes.values.size(); ++i) {
      codes.values[i] = std::uint8_t(37 * i);
      values.values[i] = 0.1f * float(i);
    }
    list.push_back({"picture", name + ".png", encode_png(codes)});
    list.push_back({"picture", name + ".exr", codec::encode_exr({{"", values}, {"Z", Image(5, 3, 1)}}, {}, "seed")});
    test::JpegSample jpeg{.width = 5, .height = 3, .channels = channels, .values = codes.values};
    jpeg.progressive = channels == 3;
    list.push_back({"picture", name + ".jpg", test::jpeg_bytes(jpeg)});
  }
  std::string hdr = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 8\n";
  for (int row = 0; row < 2; ++row) {
    hdr += std::string("\x02\x02\x00\x08", 4);
    for (const int value : {10, 20, 30, 129})
      hdr += std::string("\x86", 1) + char(value) + std::string("\x02\x07\x09", 3);
  }
  list.push_back({"picture", "a.hdr", hdr});
}

}  // namespace

std::vector<Seed> seeds() {
  std::vector<Seed> list;
  add_scenes(list);
  add_data(list);
  add_meshes(list);
  add_moving(list);
  add_pictures(list);
  return list;
}

}  // namespace umax::fuzz
