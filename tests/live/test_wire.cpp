#include "tools/live/wire.h"

#include <cstring>

#include "embedding/surface/normals.h"
#include "tests/live/live_scenes.h"
#include "tests/support/catch.h"

using namespace umax;
using namespace umax::test;

namespace {

template <class T>
T at(const std::string& bytes, std::size_t place) {
  T value;
  std::memcpy(&value, bytes.data() + place, sizeof value);
  return value;
}

/// What the page's shader makes of a vertex: place, and cofactors times the normal.
struct Carried {
  Vector3d place, normal;
};
Carried carry(const std::string& body, const Points& nodes, std::uint32_t vertex) {
  const auto num_hexes = at<std::uint32_t>(body, 12);
  const std::size_t start = 20 + 32 * std::size_t(num_hexes) + 16 * std::size_t(vertex);
  const auto hex = at<std::uint32_t>(body, start);
  Vector3d s, n;
  for (int k = 0; k < 3; ++k) {
    s[k] = at<std::uint16_t>(body, start + 4 + 2 * std::size_t(k)) / 65535.0;
    n[k] = at<std::int8_t>(body, start + 12 + std::size_t(k)) / 127.0;
  }
  Vector3d place = Vector3d::Zero();
  Matrix3d J = Matrix3d::Zero();
  for (int node = 0; node < 8; ++node) {
    double w[3], dw[3];
    for (int axis = 0; axis < 3; ++axis) {
      const bool high = node >> (2 - axis) & 1;
      w[axis] = high ? s[axis] : 1 - s[axis];
      dw[axis] = high ? 1 : -1;
    }
    const Vector3d x =
        nodes.row(at<std::uint32_t>(body, 20 + 32 * std::size_t(hex) + 4 * std::size_t(node))).transpose();
    place += w[0] * w[1] * w[2] * x;
    J += x * Eigen::RowVector3d(dw[0] * w[1] * w[2], w[0] * dw[1] * w[2], w[0] * w[1] * dw[2]);
  }
  const Vector3d a = J.col(0), b = J.col(1), c = J.col(2);
  return {place, (n[0] * b.cross(c) + n[1] * c.cross(a) + n[2] * a.cross(b)).normalized()};
}

}  // namespace

TEST_CASE("the page's shader puts vertices where the program puts them, with the normals of the surface") {
  const TemporaryFolder folder;
  make_file(folder / "ball.toml",
            "[body.ball]\nshape = \"sphere\"\nradius = 0.5\nposition = [0, 2, 0]\ncage.cells = 60\n");
  Session session(load_scene((folder / "ball.toml").string(), {}));
  const std::string body = encode_body(session.simulation, 0);
  REQUIRE(body.substr(0, 4) == "UMXB");
  // sheared, stretched and turned: the normals of a linear map are known
  Matrix3d A;
  A << 1.2, 0.3, 0, -0.2, 0.8, 0.1, 0.4, 0, 1.1;
  const Points nodes = session.simulation.model.rest_positions * A.transpose();
  TriangleMesh rest = session.simulation.bodies[0].shape.mesh, now = rest;
  compute_normals(rest);
  deform(*session.simulation.bodies[0].embedding, session.simulation.model.hexes, nodes, now);
  const Matrix3d cofactors = A.determinant() * A.inverse().transpose();
  REQUIRE(at<std::uint32_t>(body, 4) == std::uint32_t(now.num_vertices()));
  double farthest = 0, most_turned = 0;
  for (Eigen::Index v = 0; v < now.num_vertices(); ++v) {
    const Carried carried = carry(body, nodes, std::uint32_t(v));
    farthest = std::max(farthest, (carried.place - now.positions.row(v).transpose()).norm());
    const Vector3d wanted = (cofactors * rest.normals.row(v).transpose()).normalized();
    most_turned = std::max(most_turned, (carried.normal - wanted).norm());
  }
  CHECK(farthest < 1e-5);
  CHECK(most_turned < 0.02);
}

TEST_CASE("a picture holds every node to a thirty-thousandth of its body's size, and says how the step went") {
  const TemporaryFolder folder;
  Session session(live_scene(folder, "[body.far]\nshape = \"box\"\nposition = [900, 3, 0]\ncage.cells = [1, 1, 1]\n"));
  for (int i = 0; i < 30; ++i) step(session);
  const std::string frame =
      encode_frame(session, session.state, session.last, {.number = 77, .plays = true, .rate = 1});
  const auto header = at<FrameHeader>(frame, 0);
  CHECK(header.number == 77);
  CHECK(header.step == 30);
  CHECK(header.frame == 16);
  CHECK((header.flags & flag_plays) != 0);
  CHECK(header.status == std::uint8_t(session.last.status));
  CHECK(double(header.max_ratio) == Approx(session.last.max_energy_ratio));
  CHECK(header.limits_active == session.last.limits_active);
  const Points places = decode_places(frame, session.simulation.model);
  for (const Model::BodyRange& body : session.simulation.model.bodies) {
    const auto wanted = session.state.positions.middleRows(body.first_node, body.num_nodes);
    const double size = (wanted.colwise().maxCoeff() - wanted.colwise().minCoeff()).maxCoeff();
    // and what a float of its box can hold
    const double exact = size / 30000 + 2e-7 * wanted.cwiseAbs().maxCoeff();
    CHECK((places.middleRows(body.first_node, body.num_nodes) - wanted).cwiseAbs().maxCoeff() < exact);
  }
}

TEST_CASE("pictures tell the highest hexes of heat maps truly") {
  const TemporaryFolder folder;
  Session session(live_scene(folder));
  for (int i = 0; i < 40; ++i) step(session);
  const std::string frame = encode_frame(session, session.state, session.last, {});
  const std::size_t heat = sizeof(FrameHeader) + 24 + 6 * 27 + 2;
  const VectorXd ratios = energy_ratios(session.simulation.model, session.simulation.options.solver, session.state);
  for (int e = 0; e < 8; ++e)
    CHECK(at<std::uint8_t>(frame, heat + std::size_t(e)) == std::uint8_t(std::lround(200 * ratios[e])));
}
