#include <cstring>
#include <limits>

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tests/tools/error_code_of.h"
#include "tools/setup/state_file.h"

using namespace umax;

namespace {

Body falling_block(const Vector3i& cells) {
  Body body;
  body.name = "block";
  body.lattice = make_box_lattice(cells, Vector3d(0, 1, 0), Vector3d(0.1, 0.1, 0.1));
  return body;
}

State strange_state(const Model& model) {
  State state = rest_state(model);
  state.time = 0.1 + 0.2;
  state.step = 1234567890123;
  state.been_feasible = true;
  state.positions(0, 0) = -0.0;
  state.velocities(1, 2) = 1e-308;
  state.limit_multipliers.setConstant(model.num_hexes(), 1.0 / 3);
  state.contacts = {{.point = {ContactKind::vertex, 7}, .obstacle = 0, .hex = 3, .impulse = Vector3d(0.1, 1e-17, -3)},
                    {.point = {ContactKind::obstacle_edge, 3}, .obstacle = 2, .hex = 5, .impulse = Vector3d(1, 2, 3)}};
  return state;
}

template <class Matrix>
bool same_bits(const Matrix& a, const Matrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         std::memcmp(a.data(), b.data(), std::size_t(a.size()) * sizeof(double)) == 0;
}

const Digest some_digest(64, 'a');

}  // namespace

TEST_CASE("a state comes back from its file with the same bits") {
  const Model model = make_model({falling_block({2, 3, 1})}, {});
  const State state = strange_state(model);
  Digest digest;
  const State back = decode_state(encode_state(state, some_digest), "x.state", digest);
  CHECK(digest == some_digest);
  CHECK(back.time == state.time);
  CHECK(back.step == state.step);
  CHECK(back.been_feasible);
  CHECK(same_bits(back.positions, state.positions));
  CHECK(same_bits(back.velocities, state.velocities));
  CHECK(same_bits(back.limit_multipliers, state.limit_multipliers));
  REQUIRE(back.contacts.size() == 2);
  CHECK(back.contacts[0].point == state.contacts[0].point);
  CHECK(back.contacts[1].point == state.contacts[1].point);
  CHECK(back.contacts[1].obstacle == 2);
  CHECK(back.contacts[1].hex == 5);
  CHECK(back.contacts[0].impulse == state.contacts[0].impulse);
}

TEST_CASE("edge points of obstacles have numbers below zero in the file") {
  const Model model = make_model({falling_block({2, 3, 1})}, {});
  const std::string bytes = encode_state(strange_state(model), some_digest);
  const std::size_t record = 4 * sizeof(std::int32_t) + 3 * sizeof(double), checksum = 64;
  std::int32_t vertex = 0, edge = 0;
  std::memcpy(&vertex, &bytes[bytes.size() - checksum - 2 * record], sizeof vertex);
  std::memcpy(&edge, &bytes[bytes.size() - checksum - record], sizeof edge);
  CHECK(vertex == 7);
  CHECK(edge == -4);
}

TEST_CASE("the same state gives the same file") {
  const Model model = make_model({falling_block({2, 2, 2})}, {});
  CHECK(encode_state(strange_state(model), some_digest) == encode_state(strange_state(model), some_digest));
}

TEST_CASE("a state that is cut short anywhere is refused") {
  const Model model = make_model({falling_block({1, 1, 1})}, {});
  const std::string bytes = encode_state(strange_state(model), some_digest);
  Digest digest;
  int refused = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size)
    refused += error_code_of([&] { decode_state(std::string_view(bytes).substr(0, size), "x.state", digest); }) == 65;
  CHECK(refused == int(bytes.size()));
}

TEST_CASE("a state with any byte changed is refused") {
  const Model model = make_model({falling_block({1, 1, 1})}, {});
  const std::string bytes = encode_state(strange_state(model), some_digest);
  Digest digest;
  int refused = 0;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    std::string damaged = bytes;
    damaged[i] = char(damaged[i] ^ 0x10);
    refused += error_code_of([&] { decode_state(damaged, "x.state", digest); }) == 65;
  }
  CHECK(refused == int(bytes.size()));
  CHECK(error_code_of([&] { decode_state(bytes + "x", "x.state", digest); }) == 65);
}

TEST_CASE("a state of another model, time step or solver is refused, and its own accepted") {
  const TemporaryFolder folder;
  const Model model = make_model({falling_block({2, 2, 2})}, {});
  const StepOptions options;
  const auto path = folder / "0001.state";
  write_state(path, rest_state(model), model_digest(model, options));
  CHECK(read_state(path, model, model_digest(model, options)).positions == model.rest_positions);

  StepOptions finer = options;
  finer.time_step /= 2;
  CHECK(error_code_of([&] { read_state(path, model, model_digest(model, finer)); }) == 65);
  StepOptions looser = options;
  looser.solver.tolerance *= 2;
  CHECK(error_code_of([&] { read_state(path, model, model_digest(model, looser)); }) == 65);
  Body softer = falling_block({2, 2, 2});
  softer.material.young = 400e3;
  const Model other = make_model({softer}, {});
  CHECK(error_code_of([&] { read_state(path, other, model_digest(other, options)); }) == 65);
  const Model with_ground = make_model({falling_block({2, 2, 2})}, {{.name = "ground", .shape = HalfSpace{}}});
  CHECK(error_code_of([&] { read_state(path, with_ground, model_digest(with_ground, options)); }) == 65);
}

TEST_CASE("a state that is not there is not found") {
  const TemporaryFolder folder;
  const Model model = make_model({falling_block({1, 1, 1})}, {});
  CHECK(error_code_of([&] { read_state(folder / "0001.state", model, some_digest); }) == 66);
}
