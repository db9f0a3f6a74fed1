// Cameras from glTF and USD text, against places that are known, and files that are none.
#include <cmath>
#include <cstring>
#include <numbers>
#include <optional>

#include "core/base/error.h"
#include "embedding/cameras/moving_camera.h"
#include "tests/embedding/camera_files.h"
#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"

using namespace umax;
using namespace umax::testing;

namespace {

constexpr double half_turn = std::numbers::pi;

void check_gltf_motion(const MovingCamera& camera) {
  CHECK(camera.name == "shot");
  CHECK(camera.start == Approx(0.5));
  const CameraPlace first = camera.at(0.5), middle = camera.at(1.5), last = camera.at(9);
  CHECK((first.position - Vector3d(2, 14, 6)).norm() < 1e-6);
  CHECK((first.forward - Vector3d(0, 0, -1)).norm() < 1e-6);
  CHECK((middle.position - Vector3d(6, 14, 6)).norm() < 1e-6);
  CHECK((middle.forward - Vector3d(-std::sqrt(0.5), 0, -std::sqrt(0.5))).norm() < 1e-6);
  CHECK((last.position - Vector3d(10, 14, 6)).norm() < 1e-6);
  CHECK((last.forward - Vector3d(-1, 0, 0)).norm() < 1e-6);
  CHECK((last.up - Vector3d(0, 1, 0)).norm() < 1e-6);
  CHECK(first.vertical_fov_degrees == Approx(0.5 * 180 / half_turn));
}

template <class Function>
std::optional<Fault> fault_of(const Function& function) {
  try {
    function();
    return std::nullopt;
  } catch (const Error& error) {
    return error.fault();
  }
}

std::optional<Fault> fault_of_camera(const TemporaryFolder& folder, const std::string& text,
                                     const std::string& name = "") {
  const auto path = folder / "camera";
  make_file(path, text);
  return fault_of([&] { (void)read_moving_camera(path, name); });
}

}  // namespace

TEST_CASE("a camera of glTF goes where its nodes and animations say") {
  const TemporaryFolder folder;
  make_file(folder / "embedded.gltf", gltf_text(data_uri(animation_bytes())));
  check_gltf_motion(read_moving_camera(folder / "embedded.gltf", ""));
  check_gltf_motion(read_moving_camera(folder / "embedded.gltf", "lens"));
  make_file(folder / "shot.bin", animation_bytes());
  make_file(folder / "beside.gltf", gltf_text(R"("uri":"shot.bin",)"));
  check_gltf_motion(read_moving_camera(folder / "beside.gltf", "shot"));
  make_file(folder / "one.glb", glb(gltf_text(""), animation_bytes()));
  check_gltf_motion(read_moving_camera(folder / "one.glb", ""));

  make_file(folder / "steps.gltf", gltf_text(data_uri(animation_bytes()), "STEP"));
  CHECK((read_moving_camera(folder / "steps.gltf", "").at(2.4).position - Vector3d(2, 14, 6)).norm() < 1e-6);
}

TEST_CASE("splines of glTF have their tangents") {
  const TemporaryFolder folder;
  // in, value, out of each key: from 0 to 1 on x with slopes 3 and 0, through 2 s
  const std::string bytes = floats({0, 2, 0, 0, 0, 0, 0, 0, 3, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0});
  std::string text = gltf_text(data_uri(bytes), "CUBICSPLINE");
  text.replace(text.find(R"("byteOffset":8,"componentType":5126,"count":2)"), 45,
               R"("byteOffset":8,"componentType":5126,"count":6)");
  text.replace(text.find(R"(,{"sampler":1,"target":{"node":1,"path":"rotation"}})"), 52, "");
  make_file(folder / "spline.gltf", text);
  const MovingCamera camera = read_moving_camera(folder / "spline.gltf", "");
  CHECK(camera.at(0).position.x() == Approx(0).margin(1e-9));
  CHECK(camera.at(2).position.x() == Approx(2));
  // 3 at the start, of 2 s: s^3 - 2 s^2 + s is 1/8 in the middle
  CHECK(camera.at(1).position.x() == Approx(2 * (0.5 + 2 * 3 * 0.125)));
  CHECK((camera.at(1e-6).position.x() - camera.at(0).position.x()) / 1e-6 == Approx(6).epsilon(1e-3));
}

TEST_CASE("a camera of USD goes where its prims and samples say, in metres with y up") {
  const TemporaryFolder folder;
  make_file(folder / "shot.usda", usda);
  const MovingCamera camera = read_moving_camera(folder / "shot.usda", "");
  CHECK(camera.name == "shot");
  CHECK(camera.start == Approx(0.5));
  // at the pivot nothing turns; z up becomes y up
  const CameraPlace first = camera.at(0.5), last = camera.at(1.5);
  CHECK((first.position - Vector3d(1, 0, 0)).norm() < 1e-9);
  // x then z by 90 degrees: (x, y, z) becomes (z, x, y) in the file, which is (z, y, -x) here
  CHECK((first.forward - Vector3d(-1, 0, 0)).norm() < 1e-9);
  CHECK((first.up - Vector3d(0, 1, 0)).norm() < 1e-9);
  CHECK((last.position - Vector3d(1, 2, 0)).norm() < 1e-9);
  CHECK((camera.at(1).position - Vector3d(1, 1, 0)).norm() < 1e-9);
  CHECK(first.vertical_fov_degrees == Approx(2 * std::atan(0.25) * 180 / half_turn));
  CHECK(last.vertical_fov_degrees == Approx(2 * std::atan(0.125) * 180 / half_turn));
  CHECK(read_moving_camera(folder / "shot.usda", "root").name == "shot");
}

TEST_CASE("files without the camera that is meant are told apart") {
  const TemporaryFolder folder;
  CHECK(fault_of([&] { (void)read_moving_camera(folder / "absent.glb", ""); }) == Fault::not_found);
  const std::string good = gltf_text(data_uri(animation_bytes()));
  CHECK_FALSE(fault_of_camera(folder, good));
  CHECK(fault_of_camera(folder, good, "Bob") == Fault::bad_data);
  CHECK(fault_of_camera(folder, "") == Fault::bad_data);
  CHECK(fault_of_camera(folder, "solid mesh") == Fault::bad_data);
  CHECK(fault_of_camera(folder, R"({"asset":{"version":"2.0"}})") == Fault::bad_data);
  CHECK(fault_of_camera(folder, "PXR-USDC\0\0\0") == Fault::bad_data);
  CHECK(fault_of_camera(folder, "#usda 1.0\n") == Fault::bad_data);
  const auto changed = [](std::string text, const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  const std::vector<std::pair<std::string, std::string>> of_gltf{
      {"\"perspective\",", "\"orthographic\","},
      {"0.5,\"znear", "0,\"znear"},
      {"\"children\":[1]", "\"children\":[7]"},
      {"\"children\":[1]", "\"children\":[0,1]"},
      {"\"count\":2,\"type\":\"VEC3\"", "\"count\":200000000000,\"type\":\"VEC3\""},
      {"\"count\":2,\"type\":\"SCALAR\"", "\"count\":1,\"type\":\"SCALAR\""},
      {"\"camera\":0", "\"camera\":5"},
      {"[9,9,9]", "\"here\""},
      {"\"scale\":[2,2,2]", "\"scale\":[2,2]"},
      {"\"scale\":[2,2,2]", "\"scale\":[0,0,0]"}};
  for (const auto& [from, to] : of_gltf) {
    CAPTURE(from, to);
    CHECK(fault_of_camera(folder, changed(good, from, to)) == Fault::bad_data);
  }
  const std::vector<std::pair<std::string, std::string>> of_usda{{"\"perspective\"", "\"orthographic\""},
                                                                 {"10: 50,", "10: (50, 1),"},
                                                                 {"[\"xformOp:translate\"]", "[\"xformOp:nowhere\"]"},
                                                                 {"(90, 0, 90)", "(90, 0)"},
                                                                 {"timeCodesPerSecond = 20", "timeCodesPerSecond = 0"},
                                                                 {"verticalAperture = 25", "verticalAperture = 0"},
                                                                 {"rotateXYZ", "rotateXQZ"}};
  for (const auto& [from, to] : of_usda) {
    CAPTURE(from, to);
    CHECK(fault_of_camera(folder, changed(usda, from, to)) == Fault::bad_data);
  }
}

TEST_CASE("cameras of cut and spoilt files are errors, or cameras") {
  const TemporaryFolder folder;
  for (const std::string& whole :
       {std::string(usda), gltf_text(data_uri(animation_bytes())), glb(gltf_text(""), animation_bytes())}) {
    for (std::size_t size = 0; size < whole.size(); size += 5) {
      const auto fault = fault_of_camera(folder, whole.substr(0, size));
      CHECK((!fault || fault == Fault::bad_data || fault == Fault::not_found));
    }
    for (std::size_t at = 0; at < whole.size(); at += 3) {
      std::string spoilt = whole;
      spoilt[at] = char(spoilt[at] ^ 0x11);
      const auto fault = fault_of_camera(folder, spoilt);
      CHECK((!fault || fault == Fault::bad_data || fault == Fault::not_found));
    }
  }
  const std::string deep(100000, '(');
  CHECK(fault_of_camera(folder, "#usda 1.0\ndef Camera \"a\" { float focalLength = " + deep) == Fault::bad_data);
  std::string nested = "#usda 1.0\n";
  for (int i = 0; i < 100000; ++i) nested += "def \"a\" {";
  CHECK(fault_of_camera(folder, nested) == Fault::bad_data);
}
