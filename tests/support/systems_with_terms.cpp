#include "tests/support/systems_with_terms.h"

#include <cmath>

#include "core/linear/bricks/hadamard_hex.h"
#include "tests/support/begun_step.h"
#include "tests/support/hex_samples.h"

namespace umax::test {

std::vector<RankOneTerm> random_terms(const Model& model, double least, double most) {
  Random random(7);
  std::vector<RankOneTerm> terms;
  for (int hex = 0; hex < int(model.num_hexes()); hex += 3) {
    RankOneTerm term;
    term.hex = hex;
    const double size = std::sqrt(least * std::pow(most / least, double(hex) / double(model.num_hexes())));
    for (int i = 0; i < 24; ++i) term.vector[i] = size * random.uniform(-1, 1);
    terms.push_back(term);
  }
  return terms;
}

std::vector<RankOneTerm> strain_terms(const Model& model) {
  std::vector<RankOneTerm> terms;
  for (int hex = 0; hex < int(model.num_hexes()); ++hex) {
    RankOneTerm term{hex, Vector24d::Zero(), 0};
    for (int n = 0; n < 8; ++n) term.vector[3 * n + 2] = n & 1 ? 1e4 : -1e4;
    terms.push_back(term);
  }
  return terms;
}

VectorXd dense_term(const Model& model, const RankOneTerm& term) {
  VectorXd g = VectorXd::Zero(3 * model.num_nodes());
  for (int n = 0; n < 8; ++n) g.segment<3>(3 * model.hexes(term.hex, n)) = term.vector.segment<3>(3 * n);
  return g;
}

MultigridSystem system_at_rest(const Model& model, const std::vector<RankOneTerm>& terms) {
  const BegunStep begun(model);
  MultigridSystem system = make_multigrid_system(model);
  set_up(begun.problem, begun.state.positions, VectorXd::Zero(model.num_hexes()), terms, system);
  return system;
}

void leave_unfactored(BodyGrid& grid) {
  for (std::size_t depth = 0; depth < grid.terms.levels.size(); ++depth) {
    SaddlePointLevel& of_terms = grid.terms.levels[depth];
    const MultigridLevel& level = grid.multigrid.levels[depth];
    const auto damping = float(1.9 / largest_jacobi_eigenvalue(level.shape));  // as in smoothing steps
    set_up(level, of_terms.terms, of_terms.own, damping, of_terms.complement, 0);
  }
}

Solved solve_on(const Model& model, const SaddlePointOptions& options, MultigridSystem& system) {
  const SaddlePointReport report = improve(options, system);
  return {solution_of(model, system), report};
}

Solved solve_from_rest(const Model& model, const VectorXd& b, const SaddlePointOptions& options,
                       MultigridSystem& system) {
  begin(model, b, system);
  return solve_on(model, options, system);
}

}  // namespace umax::test
