// How far an iteration goes along its step.
#include "core/problem/step_length.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

constexpr double cell = 0.1;  // [m]
constexpr int edge = 10;      // cells of the block

int node_at(int i, int j, int k) {
  return (i * (edge + 1) + j) * (edge + 1) + k;
}

// all nodes alike [cells], and one of them by this much more
VectorXd spike(const Model& model, const Vector3d& all, int node, const Vector3d& more) {
  VectorXd step(3 * model.num_nodes());
  for (Eigen::Index i = 0; i < model.num_nodes(); ++i) step.segment<3>(3 * i) = cell * all;
  step.segment<3>(3 * node) += cell * more;
  return step;
}

}  // namespace

TEST_CASE("a node that a step moves far beyond its neighbours does not hold up the others") {
  Body block = test::make_block({edge, edge, edge}, Vector3d::Zero(), cell);
  const int fixed = node_at(5, 5, 6);
  block.fixed_nodes = {fixed};
  const Model model = make_model({block}, {});
  const int moved = node_at(5, 5, 5);
  const VectorXd step = spike(model, {0, 0, 0}, moved, {1.5, 0, 0});
  const double share = max_step_fraction(model, step);
  REQUIRE(share < 0.2);
  VectorXd eased = step;
  limit_distortion(model, eased);
  CHECK(max_step_fraction(model, eased) > 0.9);
  CHECK(eased[3 * moved] > share * step[3 * moved]);  // as far as the whole step's share, at least
  CHECK(eased.segment<3>(3 * fixed).isZero(0));
  const int far = node_at(10, 10, 10);
  CHECK(eased.segment<3>(3 * far) == step.segment<3>(3 * far));
}

TEST_CASE("a node is eased towards its neighbours alike, wherever the body goes with them") {
  const Model model = make_model({test::make_block({edge, edge, edge}, Vector3d::Zero(), cell)}, {});
  const int moved = node_at(5, 5, 5);
  const Vector3d all(3, -4, 1);
  VectorXd resting = spike(model, {0, 0, 0}, moved, {1.5, 0, 0}), moving = spike(model, all, moved, {1.5, 0, 0});
  limit_distortion(model, resting);
  limit_distortion(model, moving);
  CHECK(max_step_fraction(model, moving) > 0.9);
  double difference = 0;  // [cells]
  for (Eigen::Index i = 0; i < model.num_nodes(); ++i)
    difference = std::max(difference, ((moving - resting).segment<3>(3 * i) - cell * all).norm() / cell);
  CHECK(difference <= 1e-9);
}

TEST_CASE("a step that distorts no hex much is left as it is, however far it goes") {
  const Model model = make_model({test::make_block({edge, edge, edge}, Vector3d::Zero(), cell)}, {});
  const VectorXd step = spike(model, {30, 0, -40}, node_at(5, 5, 5), {0, 0.2, 0});
  REQUIRE(max_step_fraction(model, step) == 1);
  VectorXd eased = step;
  limit_distortion(model, eased);
  CHECK(eased == step);
  CHECK(largest_move(model, step) == Approx(50).epsilon(1e-3));
}

TEST_CASE("a step that distorts many hexes is left to be cut as a whole") {
  const Model model = make_model({test::make_block({edge, edge, edge}, Vector3d::Zero(), cell)}, {});
  VectorXd step = VectorXd::Zero(3 * model.num_nodes());
  for (Eigen::Index i = 0; i < model.num_nodes(); ++i) step[3 * i] = 2 * model.rest_positions(i, 0);
  REQUIRE(max_step_fraction(model, step) == Approx(0.2));
  VectorXd eased = step;
  limit_distortion(model, eased);
  CHECK(eased == step);
}

TEST_CASE("steps along the last one are stretched where they creep, cut where they go to and fro") {
  const VectorXd before = VectorXd::LinSpaced(30, -1, 2);
  CHECK(correction(before, {}) == 1);
  const VectorXd none = VectorXd::Zero(before.size());  // of a body that is held as a whole
  CHECK(correction(none, {none}) == 1);
  CHECK(correction(before, {none}) == 1);
  CHECK(correction(0.5 * before, {before}) == Approx(2.0));
  CHECK(correction(-0.9 * before, {before}) == Approx(1 / 1.9));
  CHECK(correction(0.3 * before, {before}) == 1);            // falls fast by itself
  CHECK(correction(1.2 * before, {before}) == Approx(8.0));  // bounded
  VectorXd across = before.reverse();
  CHECK(correction(across, {before}) == 1);
}

TEST_CASE("a step of which half or more was taken, or that was extended, tells the next one's length exactly") {
  const double taken = GENERATE(0.5, 0.9, 1.5, 4.0), overshoot = GENERATE(1.9, 0.5);  // each step over the error
  CAPTURE(taken, overshoot);
  const VectorXd error = VectorXd::LinSpaced(30, -1, 2), left = (1 - overshoot * taken) * error;
  CHECK(correction(-overshoot * left, taken_step(-overshoot * error, taken)) == Approx(1 / overshoot));
  CHECK(correction(-overshoot * left, taken_step(-overshoot * error, 0.4)) == 1);
}

TEST_CASE("a slide into a buckled shape is followed step after step, as far as hexes bear it") {
  const Model model = make_model({test::make_block({2, 2, 2}, Vector3d::Zero(), cell)}, {});
  VectorXd step = VectorXd::Zero(3 * model.num_nodes());
  for (Eigen::Index i = 0; i < model.num_nodes(); ++i) step[3 * i] = 0.1 * model.rest_positions(i, 1);
  REQUIRE(max_step_fraction(model, step) == 1);
  const double most = max_step_fraction(model, 8 * step);
  REQUIRE(most < 1);
  const std::vector<double> residuals{1, 0.5};
  for (const double before : {1.0, 4.0})  // the matrix takes a negative curvature of -0.25 for 1
    CHECK(step_factors(model, (1 + 0.25 * before) * step, 1, false, residuals, {taken_step(step, before)})[0] ==
          Approx(8 * max_step_fraction(model, 8 * (1 + 0.25 * before) * step)));
}

TEST_CASE("steps to and fro are cut where easing has left nearly all of them bearable") {
  const Model model = make_model({test::make_block({2, 2, 2}, Vector3d::Zero(), cell)}, {});
  const VectorXd before = VectorXd::LinSpaced(3 * model.num_nodes(), -0.01 * cell, 0.01 * cell);
  const TakenStep last = taken_step(before, 0.99);
  const std::vector<double> stuck{8, 4, 2, 1, 1, 1, 1, 1, 0.9};
  const std::vector<double> falling{8, 4, 2, 1, 0.1};
  CHECK(step_factors(model, -before, 0.99, false, falling, {last})[0] == Approx(0.99 / 2));  // along the line
  CHECK(step_factors(model, -0.3 * before, 0.99, false, stuck, {last})[0] == 0.5);
  CHECK(step_factors(model, -before, 0.6, false, stuck, {last})[0] == 0.6);
  CHECK(step_factors(model, 0.5 * before, 1, false, stuck, {last})[0] == Approx(0.99 / 0.5));
}

TEST_CASE("of bodies in one solve those whose steps go to and fro take a part of theirs, the others all") {
  const Model model = make_model(
      {test::make_block({2, 2, 2}, Vector3d::Zero(), cell), test::make_block({2, 2, 2}, Vector3d(1, 0, 0), cell)}, {});
  const double taken = GENERATE(1.0, 0.5);  // of the last step
  const Eigen::Index half = 3 * model.bodies[0].num_nodes;
  const VectorXd before = VectorXd::LinSpaced(2 * half, -0.01 * cell, 0.01 * cell);
  VectorXd step = before;
  step.head(half) *= -1;         // what was taken was twice too much
  step.tail(half) *= 1 - taken;  // of a body whose matrix is right
  const std::vector<double> stuck{8, 4, 2, 1, 1, 1, 1, 1, 0.9};
  const VectorXd factors =
      step_factors(model, step, 1, false, stuck, taken_steps(model, before, VectorXd::Constant(2, taken)));
  CHECK(factors[0] == Approx(taken / 2));
  CHECK(factors[1] == Approx(1));
}

TEST_CASE("a step that only restores constraints is neither extended nor cut for what the ones before did") {
  const Model model = make_model({test::make_block({2, 2, 2}, Vector3d::Zero(), cell)}, {});
  const VectorXd before = VectorXd::LinSpaced(3 * model.num_nodes(), -0.01 * cell, 0.01 * cell);
  const TakenStep last = taken_step(before, 0.99);
  const std::vector<double> stuck{8, 4, 2, 1, 1, 1, 1, 1, 0.9};
  for (const double share : {-1.0, -0.3, 0.5, 1.2})
    CHECK(step_factors(model, share * before, 0.99, true, stuck, {last})[0] == 0.99);
}

TEST_CASE("an iteration goes to and fro where it undoes its last step and its residual hardly falls") {
  const VectorXd before = VectorXd::LinSpaced(30, -1, 2);
  const VectorXd back = -0.3 * before, on = 0.3 * before;
  const std::vector<double> stuck{8, 4, 2, 1, 1, 1, 1, 1, 0.9}, falling{8, 4, 2, 1, 1, 1, 1, 1, 0.4},
      young(stuck.begin() + 1, stuck.end());
  CHECK(goes_to_and_fro(stuck, back, {before}));
  CHECK_FALSE(goes_to_and_fro(stuck, on, {before}));
  CHECK_FALSE(goes_to_and_fro(stuck, back, {}));
  CHECK_FALSE(goes_to_and_fro(falling, back, {before}));
  CHECK_FALSE(goes_to_and_fro(young, back, {before}));
  // in a circle of three iterates, whatever part of it the last one is
  std::vector<double> circle(4, 1.0);
  for (int round = 0; round < 3; ++round) circle.insert(circle.end(), {0.26, 0.12, 0.05});
  for (int part = 0; part < 3; ++part) {
    CHECK(goes_to_and_fro(circle, back, {before}));
    circle.push_back(circle[circle.size() - 3]);
  }
}

TEST_CASE("half steps are taken where large ones have not got on for long, whole ones elsewhere") {
  const Model model = make_model({test::make_block({2, 2, 2}, Vector3d::Zero(), cell)}, {});
  const VectorXd step = VectorXd::Constant(3 * model.num_nodes(), 0.2 * cell), small = 0.5 * step;  // 0.35, 0.17 cells
  const std::vector<double> landing{1, 0.5, 0.2, 0.1}, wandering{0.05, 0.2, 0.1, 0.3, 0.1, 0.07, 0.1, 0.2, 0.06},
      falling{0.05, 0.2, 0.1, 0.3, 0.1, 0.07, 0.05, 0.04, 0.02};
  const auto after_landing = [&](const std::vector<double>& residuals) {
    std::vector<double> all = landing;
    all.insert(all.end(), residuals.begin(), residuals.end());
    return all;
  };
  CHECK(stagnates(after_landing(wandering)));
  CHECK_FALSE(stagnates(after_landing(falling)));
  CHECK_FALSE(stagnates(wandering));  // may still be looking for its contacts
  CHECK(step_factors(model, step, 1, false, after_landing(wandering), {})[0] == 0.5);
  CHECK(step_factors(model, small, 1, false, after_landing(wandering), {})[0] == 1);  // may have begun to slide
  CHECK(step_factors(model, step, 1, false, after_landing(falling), {})[0] == 1);
  CHECK(step_factors(model, step, 1, true, after_landing(wandering), {})[0] == 1);  // only constraints are to be met
  CHECK(step_factors(model, step, 0.3, false, after_landing(wandering), {})[0] == 0.3);
  const TakenStep creeping = taken_step(2 * step, 1);
  CHECK(step_factors(model, step, 1, false, after_landing(wandering), {creeping})[0] == Approx(2.0));
}
