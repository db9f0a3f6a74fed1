// What the physics does in parallel, for the thread sanitizer to look at: it ends the program with exit code 66 at the first
// race that it sees. One is planted, which it must find, or it would find no other.
#include <tbb/global_control.h>

#include "core/base/parallel.h"
#include "embedding/embedding.h"
#include "embedding/surface/shapes.h"
#include "tests/support/bodies.h"
#include "tests/support/catch.h"
#include "tests/support/touchable.h"

using namespace umax;

namespace {

/// Whether limits and contacts were there together in one of the steps.
bool steps(const Model& model, const StepOptions& options, int count) {
  State state = rest_state(model);
  bool acted = false;
  test::simulate(model, options, count, state, [&](const StepReport& report, const State&) {
    acted |= report.limits_active > 0 && report.contacts > 0;
  });
  return acted;
}

Model thrown_sphere() {
  Body body = test::make_sphere(6, {0, 1.02, 0}, 2000);
  body.velocity = {1, -4, 0};
  body.spin = {0, 0, 2};
  test::limit_energy(body, 20);
  return make_model({body}, {test::make_ground(0.5)});
}

bool impact(SolverMethod method, LinearSolver linear) {
  StepOptions options{.time_step = 0.01};
  options.solver.method = method;
  options.solver.linear = linear;
  options.solver.tolerance = 1e-2;
  return steps(thrown_sphere(), options, 5);
}

}  // namespace

TEST_CASE("a race that is planted", "[.planted]") {
  long long sum = 0;  // to which every block adds without asking
  parallel_blocks(1000, 10, [&](Eigen::Index begin, Eigen::Index end) { sum += end - begin; });
  CHECK(sum > 0);
}

TEST_CASE("an impact by the paper's method") {
  CHECK(impact(SolverMethod::paper, LinearSolver::direct));
}

TEST_CASE("an impact with stored factors") {
  CHECK(impact(SolverMethod::exact, LinearSolver::direct));
}

TEST_CASE("an impact on multigrids") {
  CHECK(impact(SolverMethod::exact, LinearSolver::multigrid));
}

TEST_CASE("two balls that meet over the ground") {
  Body left = test::touchable_ball("left", 3, {-0.31, 0.31, 0}, 0.3);
  Body right = test::touchable_ball("right", 3, {0.31, 0.31, 0.02}, 0.3);
  left.velocity = {3, -1, 0};
  right.velocity = {-3, -1, 0};
  for (Body* body : {&left, &right}) test::limit_energy(*body, 0.5);
  StepOptions options{.time_step = 0.01};
  options.solver.tolerance = 1e-2;
  CHECK(steps(make_model({left, right}, {test::make_ground(0.5)}), options, 5));
}

TEST_CASE("a surface of many vertices on a cage of many hexes") {
  // what is sorted by TBB itself, whose threads the sanitizer misunderstands, is done by one
  const tbb::global_control control(tbb::global_control::max_allowed_parallelism, 1);
  const Lattice lattice = make_box_lattice({8, 8, 8}, {-1.01, -1.01, -1.01}, Vector3d::Constant(2.02 / 8));
  TriangleMesh mesh = umax::make_sphere(1, 5);
  const Embedding embedding = embed(mesh, lattice);
  deform(embedding, lattice.hexes, 1.5 * lattice.rest_positions, mesh);
  CHECK(mesh.positions.rows() > 2000);
}
