#include "core/step/newton_system.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/step/delassus.h"

namespace umax {
namespace {

constexpr double negligible_direction = 1e-9;  // share of a contact's stiffness
constexpr Eigen::Index nodes_per_block = 512;

enum class Elasticity {
  exact,     // the Hessian as it is: may be indefinite
  definite,  // warped stiffness where the exact one is not positive definite by itself
};

// is the hex's matrix with its share of the inertia positive definite?
bool is_definite(const StepProblem& problem, Eigen::Index e, const Matrix24d& element) {
  const Model& model = *problem.model;
  Matrix24d shifted = element;
  for (int n = 0; n < 8; ++n) {
    const int node = model.hexes(e, n);
    const double share =
        model.node_mass[node] / (model.corner_starts[node + 1] - model.corner_starts[node]) / (problem.h * problem.h);
    for (int axis = 0; axis < 3; ++axis) shifted(3 * n + axis, 3 * n + axis) += share;
  }
  return Eigen::LLT<Matrix24d>(shifted).info() == Eigen::Success;
}

// elasticity and limits of one element; terms: of all limits
void elastic_matrix(const StepProblem& problem, const Evaluation& evaluation, const std::vector<LimitTerms>& terms,
                    Eigen::Index e, bool exact, Matrix24d& element) {
  const Model& model = *problem.model;
  const SolverOptions& solver = problem.options->solver;
  const HexShape& shape = model.shapes[model.hex_shape[e]];
  const Matrix8x3d& h = shape.rotation_gradients[int(solver.rotation)];
  const CorotatedHex& hex = evaluation.hexes[e];
  const auto hessian = [&](const Matrix24d& K) -> Matrix24d {
    return exact ? exact_hessian(K, problem.materials.young[e], h, hex)
                 : warped_hessian(K, problem.materials.young[e], hex);
  };
  element = hessian(shape.stiffness);
  const int first = model.limit_starts[e], end = model.limit_starts[e + 1];
  bool stiffened = false;
  for (int l = first; l < end; ++l) {  // the whole's comes first: the element is nothing but elastic yet
    if (terms[l].stiffening <= 0) continue;
    if (model.limits[l].form >= 0)
      stiffened = true;
    else if (solver.energy == EnergyMeasure::true_energy)
      element *= 1 + terms[l].stiffening;
    else
      element += terms[l].stiffening * hessian(measured_stiffness(shape, solver.energy));
  }
  if (stiffened) {  // a Hessian is linear in its form: one for all
    Matrix24d sum = Matrix24d::Zero();
    for (int l = first; l < end; ++l)
      if (model.limits[l].form >= 0 && terms[l].stiffening > 0)
        sum += terms[l].stiffening * model.limit_forms[model.limits[l].form];
    element += hessian(sum);
  }
  for (int l = first; l < end; ++l)
    if (terms[l].rank_one > 0) {
      const Vector24d G = evaluation.limit_gradient(model, l);
      element.noalias() += terms[l].rank_one * G * G.transpose();
    }
}

void element_matrix(const StepProblem& problem, const Evaluation& evaluation, const std::vector<LimitTerms>& terms,
                    Eigen::Index e, Elasticity elasticity, Matrix24d& element) {
  const Model& model = *problem.model;
  elastic_matrix(problem, evaluation, terms, e, true, element);
  if (elasticity == Elasticity::definite && !is_definite(problem, e, element))
    elastic_matrix(problem, evaluation, terms, e, false, element);
  add_spring_hessian(problem.pins, e, element);
  if (problem.damping_stiffness[e] > 0) {
    CorotatedHex start;
    start.rotation = problem.rotations_t0[e];
    element += problem.damping_stiffness[e] / problem.h *
               warped_hessian(model.shapes[model.hex_shape[e]].stiffness, problem.materials.young[e], start);
  }
}

// J^T stiffness J of a point against an obstacle
void add_contact_matrix(const Contact& contact, const Matrix3d& stiffness, Matrix24d& element) {
  const Vector8d& weights = contact.support.weights;
  for (int m = 0; m < 8; ++m)
    for (int n = 0; n < 8; ++n) element.block<3, 3>(3 * m, 3 * n) += weights[m] * weights[n] * stiffness;
}

// Indices of the contacts with obstacles, whose stiffness joins the matrix; no lists where none does. Contacts of two
// hexes have no place in its pattern.
std::vector<std::vector<int>> contacts_by_hex(const Model& model, const Iterate& iterate, const Linearisation& at) {
  std::vector<std::vector<int>> in_hex(at.contacts.empty() ? 0 : model.num_hexes());
  for (std::size_t i = 0; i < at.contacts.size(); ++i)
    if (!iterate.contacts[i].between_bodies()) in_hex[iterate.contacts[i].support.hex].push_back(int(i));
  return in_hex;
}

// x becomes (A + J^T S J)^-1 b of x = A^-1 b, for the stiffness S of contacts between bodies (Woodbury):
//   x - A^-1 J^T T (1 + T W T)^-1 T J x,   W = J A^-1 J^T,  T T = S
void add_body_contacts(const StepProblem& problem, const Linearisation& at, const Iterate& iterate,
                       const Workspace::Data& workspace, VectorXd& x) {
  const Model& model = *problem.model;
  std::vector<Contact> between;
  std::vector<Matrix3d> roots;
  for (std::size_t i = 0; i < at.contacts.size(); ++i) {
    if (!iterate.contacts[i].between_bodies() || at.contacts[i].stiffness.isZero(0)) continue;
    between.push_back(iterate.contacts[i]);
    const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(at.contacts[i].stiffness);
    roots.push_back(eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
                    eigen.eigenvectors().transpose());
  }
  if (between.empty()) return;
  Delassus delassus;
  extend(model, workspace, between, delassus);
  const MatrixXd W = dense(delassus);
  MatrixXd T = MatrixXd::Zero(W.rows(), W.cols());
  VectorXd motion(W.rows());
  for (std::size_t i = 0; i < between.size(); ++i) {
    const Eigen::Index row = 3 * Eigen::Index(i);
    T.block<3, 3>(row, row) = roots[i];
    motion.segment<3>(row) = roots[i] * contact_motion(model, between[i], x);
  }
  const MatrixXd system = MatrixXd::Identity(W.rows(), W.cols()) + T * W * T;
  const VectorXd forces = T * system.llt().solve(motion);
  VectorXd push = VectorXd::Zero(x.size());
  for (std::size_t i = 0; i < between.size(); ++i)
    spread(model, between[i], forces.segment<3>(3 * Eigen::Index(i)), push);
  clear_fixed(model, push);
  solve(model, workspace, push);
  x -= push;
}

// The contact's stiffness as terms g g^T, one for each direction that it has; their offsets are what the contact pushes
// beyond the force that is known. Two bodies that touch get a term each: (J1 - J2)^T S (J1 - J2) is no more than twice
// J1^T S J1 + J2^T S J2, which makes the steps of a search shorter and keeps them downhill.
void append_contact_terms(const Contact& contact, const ContactTerms& at, const Vector3d& known,
                          std::vector<RankOneTerm>& terms) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> eigen(at.stiffness);
  const double share = contact.between_bodies() ? 2 : 1;
  for (int i = 0; i < 3; ++i) {
    const double stiffness = share * eigen.eigenvalues()[i];
    if (!(stiffness > share * negligible_direction * eigen.eigenvalues()[2])) continue;
    const Vector3d direction = eigen.eigenvectors().col(i);
    for_each_support(contact, [&](const Support& support, double) {
      RankOneTerm term = spring_term(support, direction, stiffness);
      if (!contact.between_bodies()) term.offset = -direction.dot(at.force - known) / std::sqrt(stiffness);
      terms.push_back(term);
    });
  }
}

// The limit's rank-one term; its offset is what the limit pushes beyond its multiplier.
RankOneTerm limit_term(const StepProblem& problem, const Iterate& iterate, const LimitTerms& at, Eigen::Index l) {
  const Model& model = *problem.model;
  const double known =
      model.limits[l].kind == LimitKind::hard ? iterate.multipliers[l] / problem.materials.limits[l] : 0;
  const double root = std::sqrt(at.rank_one);
  return {model.limits[l].hex, root * iterate.evaluation.limit_gradient(model, l), (at.force - known) / root};
}

// Factors a body's matrix; in_hex: contacts by hex. Returns the number of factorisations.
int factorize_body(const StepProblem& problem, const Linearisation& at, Iterate& iterate,
                   const std::vector<std::vector<int>>& in_hex, int b, Workspace::Data& workspace) {
  const Model::BodyRange& body = problem.model->bodies[b];
  const double h = problem.h;
  const VectorXd mass = (problem.model->node_mass.segment(body.first_node, body.num_nodes).array() *
                         (1 / (h * h) + problem.damping_mass.segment(body.first_node, body.num_nodes).array() / h))
                            .matrix();
  SystemMatrix& matrix = body_matrix(*problem.model, b, workspace);
  const auto try_with = [&](Elasticity elasticity) {
    reset(matrix);
    add_mass(mass, 1, matrix);
    add_elements(matrix, [&](Eigen::Index of_body, Matrix24d& element) {
      const Eigen::Index e = body.first_hex + of_body;
      element_matrix(problem, iterate.evaluation, at.limits, e, elasticity, element);
      if (!in_hex.empty())
        for (const int i : in_hex[e]) add_contact_matrix(iterate.contacts[i], at.contacts[i].stiffness, element);
    });
    return workspace.bodies[b].cholesky.factorize(matrix);
  };
  if (!iterate.indefinite[b] && try_with(Elasticity::exact)) return 1;
  const int attempts = iterate.indefinite[b] ? 1 : 2;
  iterate.indefinite[b] = 1;
  try_with(Elasticity::definite);
  return attempts;
}

// [cells] that a body's nodes may have moved, and share of its hexes' stiffness that limits may have changed, since its
// matrix was factored: a step with that factor leaves no more than such a share of what a new one would have mended.
constexpr double alike_positions = 1e-3, alike_stiffening = 1e-2;

// Would the body's matrix be nearly what its factor was made for?
bool is_factored(const StepProblem& problem, const Linearisation& at, const Iterate& iterate, int b) {
  const Model& model = *problem.model;
  const Model::BodyRange& body = model.bodies[b];
  const FactoredAt& known = iterate.factored[b];
  if (known.positions.rows() == 0) return false;
  const auto moves = iterate.positions.middleRows(body.first_node, body.num_nodes) - known.positions;
  if (moves.rowwise().norm().maxCoeff() > alike_positions * body.cell_size) return false;
  const int first = model.limit_starts[body.first_hex];
  for (std::size_t l = 0; l < known.limits.size(); ++l) {
    const LimitTerms &now = at.limits[first + l], &then = known.limits[l];
    if (std::abs(now.rank_one - then.rank_one) > alike_stiffening * std::min(now.rank_one, then.rank_one)) return false;
    if (std::abs(now.stiffening - then.stiffening) > alike_stiffening * (1 + then.stiffening)) return false;
  }
  return true;
}

FactoredAt factored_at(const StepProblem& problem, const Linearisation& at, const Iterate& iterate, int b) {
  const Model& model = *problem.model;
  const Model::BodyRange& body = model.bodies[b];
  const auto first = at.limits.begin() + model.limit_starts[body.first_hex],
             end = at.limits.begin() + model.limit_starts[body.first_hex + body.num_hexes];
  return {iterate.positions.middleRows(body.first_node, body.num_nodes), {first, end}};
}

}  // namespace

void set_up_multigrid(const StepProblem& problem, const Linearisation& at, const Iterate& iterate,
                      const std::vector<RankOneTerm>& further, Workspace::Data& workspace) {
  const Model& model = *problem.model;
  VectorXd stiffening = VectorXd::Zero(model.num_hexes());
  std::vector<RankOneTerm> terms;
  for (std::size_t l = 0; l < at.limits.size(); ++l) {
    stiffening[model.limits[l].hex] += at.limits[l].stiffening;
    if (at.limits[l].rank_one > 0) terms.push_back(limit_term(problem, iterate, at.limits[l], Eigen::Index(l)));
  }
  for (std::size_t i = 0; i < at.contacts.size(); ++i)
    append_contact_terms(iterate.contacts[i], at.contacts[i], iterate.contacts[i].force, terms);
  terms.insert(terms.end(), further.begin(), further.end());
  set_up(problem, iterate.positions, stiffening, terms, multigrid_system(model, workspace));
}

RankOneTerm spring_term(const Support& support, const Vector3d& direction, double stiffness) {
  RankOneTerm term;
  term.hex = support.hex;
  for (int n = 0; n < 8; ++n) term.vector.segment<3>(3 * n) = support.weights[n] * std::sqrt(stiffness) * direction;
  return term;
}

NewtonStep multigrid_step(const Model& model, const Linearisation& at, const MultigridSystem& system) {
  LinearSolution solution = solution_of(model, system);
  NewtonStep newton{std::move(solution.x), VectorXd::Zero(Eigen::Index(at.limits.size()))};
  Eigen::Index term = 0;
  for (std::size_t l = 0; l < at.limits.size(); ++l)
    if (at.limits[l].rank_one > 0)
      newton.limit_change[Eigen::Index(l)] = solution.products[term++] / std::sqrt(at.limits[l].rank_one);
  return newton;
}

VectorXd newton_step(const StepProblem& problem, const Linearisation& at, const VectorXd& slope, double accuracy,
                     Iterate& iterate, Workspace::Data& workspace, StepReport& report) {
  if (problem.plan.is_multigrid()) {
    set_up_multigrid(problem, at, iterate, {}, workspace);
    begin(*problem.model, workspace.multigrid->offset_force - slope, *workspace.multigrid);
    report.linear_iterations += improve({.tolerance = accuracy}, *workspace.multigrid).iterations;
    return solution_of(*problem.model, *workspace.multigrid).x;
  }
  report.factorisations += factorize(problem, at, iterate, workspace);
  VectorXd step = -slope;
  solve(*problem.model, workspace, step);
  add_body_contacts(problem, at, iterate, workspace, step);
  return step;
}

std::vector<LimitTerms> limit_terms(const StepProblem& problem, const Iterate& iterate, double relative_penalty) {
  std::vector<LimitTerms> terms(problem.materials.limits.size());
  for (Eigen::Index l = 0; l < problem.materials.limits.size(); ++l) {
    const double energy = iterate.evaluation.energy[l], limit = problem.materials.limits[l];
    terms[l] = problem.model->limits[l].kind == LimitKind::hard
                   ? hard_limit_terms(energy, limit, iterate.multipliers[l], relative_penalty * limit)
                   : soft_limit_terms(energy, limit, {});
  }
  return terms;
}

int factorize(const StepProblem& problem, const Linearisation& at, Iterate& iterate, Workspace::Data& workspace) {
  const Model& model = *problem.model;
  const std::vector<std::vector<int>> in_hex = contacts_by_hex(model, iterate, at);
  iterate.indefinite.resize(model.bodies.size(), 0);
  iterate.factored.resize(model.bodies.size());
  const bool may_keep = at.contacts.empty() && model.bodies.size() > 1;
  std::vector<int> made(model.bodies.size(), 0);
  parallel_blocks(Eigen::Index(model.bodies.size()), 1, [&](Eigen::Index i, Eigen::Index) {
    const int b = int(i);
    if (may_keep && is_factored(problem, at, iterate, b)) return;
    made[b] = factorize_body(problem, at, iterate, in_hex, b, workspace);
    iterate.factored[b] = may_keep ? factored_at(problem, at, iterate, b) : FactoredAt{};
  });
  return *std::max_element(made.begin(), made.end());
}

VectorXd gradient(const StepProblem& problem, const Iterate& iterate, const Linearisation& at) {
  const Model& model = *problem.model;
  VectorXd factors(Eigen::Index(at.limits.size()));
  for (std::size_t l = 0; l < at.limits.size(); ++l) factors[Eigen::Index(l)] = at.limits[l].force;
  VectorXd sum(3 * model.num_nodes());
  parallel_blocks(model.num_nodes(), nodes_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index node = begin; node < end; ++node)
      sum.segment<3>(3 * node) = inertia_at(problem, iterate.positions, node) +
                                 iterate.evaluation.internal.segment<3>(3 * node) +
                                 limits_at(model, iterate.evaluation, factors, node);
  });
  for (std::size_t i = 0; i < at.contacts.size(); ++i) spread(model, iterate.contacts[i], -at.contacts[i].force, sum);
  clear_fixed(model, sum);
  return sum;
}

}  // namespace umax
