#include "core/step/contact_newton.h"

#include <Eigen/LU>
#include <Eigen/SparseLU>
#include <algorithm>
#include <functional>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

namespace umax {
namespace {

constexpr int newton_steps = 8;  // a try
// Newton's matrix is dense for few contacts, and where most pairs of them push a body in common; else it is sparse.
constexpr std::size_t most_in_dense = 500, least_in_sparse = 150;  // contacts
constexpr double most_common_pairs = 0.5;  // [-] of all pairs, for a sparse one, and no more than
constexpr double most_pairs = 1e6;
constexpr double kept_compliance = 1e-9;  // [-] of a contact's own, that holds forces which change nothing

// A contact that pushes, in its own frame: the normal first.
struct Pushing {
  int contact = 0;
  Matrix3d frame = Matrix3d::Identity();  // columns n, t1, t2
  bool slides = false;
  Eigen::Vector2d direction{0, 0};  // of friction where it slides
  double radius = 0, share = 0;     // [N] of friction; [-] of it to what friction would be without a bound
  Vector3d right_side = Vector3d::Zero();
};

Pushing classify(const ContactRow& contact, const ContactBlock& block, const Vector3d& w, const Vector3d& force) {
  Pushing pushing;
  const Vector3d t1 = contact.normal.unitOrthogonal();
  pushing.frame << contact.normal, t1, contact.normal.cross(t1);
  const Vector3d local_w = pushing.frame.transpose() * w, local_f = pushing.frame.transpose() * force;
  pushing.right_side = -local_w;
  pushing.right_side[0] -= contact.bias;
  pushing.radius = contact.friction * std::max(0.0, local_f[0]);
  const Eigen::Vector2d y = local_f.tail<2>() - local_w.tail<2>() / block.friction_stiffness;
  const double length = y.norm();
  pushing.slides = length > pushing.radius || contact.friction == 0;
  if (!pushing.slides) return pushing;
  if (length > 0) pushing.direction = y / length, pushing.share = pushing.radius / length;
  pushing.right_side.tail<2>() = -block.friction_stiffness * (local_f.tail<2>() - pushing.radius * pushing.direction);
  return pushing;
}

// the rows of a pushing contact: motions by the change of another one's force, in both frames
Matrix3d rows_of(const Pushing& to, const Matrix3d& motions) {
  Matrix3d rows = motions;
  if (!to.slides) return rows;
  const Eigen::Matrix2d across = Eigen::Matrix2d::Identity() - to.direction * to.direction.transpose();
  rows.bottomRows<2>() = to.share * across * motions.bottomRows<2>();
  return rows;
}

// and what its own force adds to them: by the proximal term, and where it slides
void add_own(const ContactProblem& problem, const Pushing& to, Eigen::Ref<Matrix3d> rows) {
  const ContactRow& contact = problem.contacts[std::size_t(to.contact)];
  const ContactBlock& own = problem.blocks[std::size_t(to.contact)];
  rows += rows_of(to, problem.gives[std::size_t(to.contact)] * Matrix3d::Identity());
  rows(0, 0) += kept_compliance * own.normal_stiffness;
  if (!to.slides) {
    rows.bottomRightCorner<2, 2>().diagonal().array() += kept_compliance * own.friction_stiffness;
    return;
  }
  const Eigen::Matrix2d across = Eigen::Matrix2d::Identity() - to.direction * to.direction.transpose();
  rows.bottomRightCorner<2, 2>() += own.friction_stiffness * (Eigen::Matrix2d::Identity() - to.share * across);
  rows.bottomLeftCorner<2, 1>() -= own.friction_stiffness * contact.friction * to.direction;
}

// the contacts that push; the forces of all others become zero
std::vector<Pushing> find_pushing(const ContactProblem& problem, ContactState& state) {
  std::vector<int> pushing;
  for (int i = 0; i < problem.count(); ++i) {
    const Vector3d w = motion_of(problem, state, i), force = state.forces.segment<3>(3 * i);
    const Vector3d& n = problem.contacts[i].normal;
    const bool pushes = n.dot(force) > (n.dot(w) + problem.contacts[i].bias) / problem.blocks[i].normal_stiffness;
    if (pushes)
      pushing.push_back(i);
    else
      state.forces.segment<3>(3 * i).setZero();
  }
  state.motions = motions_of(problem, state.forces);
  std::vector<Pushing> all;
  for (const int i : pushing) {
    all.push_back(
        classify(problem.contacts[i], problem.blocks[i], motion_of(problem, state, i), state.forces.segment<3>(3 * i)));
    all.back().contact = i;
  }
  return all;
}

Vector3d within_cone(const ContactRow& contact, const Vector3d& force) {
  const double normal = std::max(0.0, contact.normal.dot(force));
  return normal * contact.normal +
         project_to_disc(force - contact.normal.dot(force) * contact.normal, contact.friction * normal);
}

MatrixXd newton_matrix(const ContactProblem& problem, const std::vector<Pushing>& pushing) {
  const auto count = Eigen::Index(pushing.size());
  MatrixXd M(3 * count, 3 * count);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Pushing& to = pushing[std::size_t(i)];
    for (Eigen::Index j = 0; j < count; ++j) {
      const Pushing& from = pushing[std::size_t(j)];
      M.block<3, 3>(3 * i, 3 * j) =
          rows_of(to, to.frame.transpose() * compliance(problem.delassus, to.contact, from.contact) * from.frame);
    }
    add_own(problem, to, M.block<3, 3>(3 * i, 3 * i));
  }
  return M;
}

// The same of many bodies: contacts that have none in common do not depend on each other.
Eigen::SparseMatrix<double> sparse_newton_matrix(const ContactProblem& problem, const std::vector<Pushing>& pushing) {
  const Delassus& delassus = problem.delassus;
  struct Place {
    int number = 0;  // among those that push
    Delassus::Side side;
  };
  std::vector<std::vector<Place>> on_bodies(delassus.bodies.size());
  for (std::size_t i = 0; i < pushing.size(); ++i)
    for_each_side(delassus, pushing[i].contact,
                  [&](const Delassus::Side& side) { on_bodies[side.body].push_back({int(i), side}); });
  std::vector<Eigen::Triplet<double>> entries;
  const auto add = [&](int i, int j, const Matrix3d& block) {
    for (int column = 0; column < 3; ++column)
      for (int row = 0; row < 3; ++row) entries.emplace_back(3 * i + row, 3 * j + column, block(row, column));
  };
  for (std::size_t i = 0; i < pushing.size(); ++i) {
    const Pushing& to = pushing[i];
    for_each_side(delassus, to.contact, [&](const Delassus::Side& side) {
      for (const Place& place : on_bodies[side.body]) {
        const Pushing& from = pushing[std::size_t(place.number)];
        const auto W = delassus.bodies[side.body].W.block<3, 3>(3 * side.point, 3 * place.side.point);
        add(int(i), place.number, rows_of(to, side.sign * place.side.sign * (to.frame.transpose() * W * from.frame)));
      }
    });
    Matrix3d own = Matrix3d::Zero();
    add_own(problem, to, own);
    add(int(i), int(i), own);
  }
  const auto size = 3 * Eigen::Index(pushing.size());
  Eigen::SparseMatrix<double> M(size, size);
  M.setFromTriplets(entries.begin(), entries.end());
  return M;
}

// pairs of contacts, one after the other, that push a body in common
double common_pairs(const ContactProblem& problem, const std::vector<Pushing>& pushing) {
  std::vector<double> on_bodies(problem.delassus.bodies.size(), 0);
  for (const Pushing& contact : pushing)
    for_each_side(problem.delassus, contact.contact, [&](const Delassus::Side& side) { ++on_bodies[side.body]; });
  return std::transform_reduce(on_bodies.begin(), on_bodies.end(), 0.0, std::plus(), [](double n) { return n * n; });
}

// M^-1 right; none where M is too large, or has no inverse
std::optional<VectorXd> solve_newton(const ContactProblem& problem, const std::vector<Pushing>& pushing,
                                     const VectorXd& right) {
  const double pairs = common_pairs(problem, pushing), all = double(pushing.size()) * double(pushing.size());
  std::optional<VectorXd> change;
  if (pushing.size() < least_in_sparse || pairs > most_common_pairs * all) {
    if (pushing.size() <= most_in_dense) change = newton_matrix(problem, pushing).partialPivLu().solve(right);
  } else if (pairs <= most_pairs) {
    const Eigen::SparseLU<Eigen::SparseMatrix<double>> factor(sparse_newton_matrix(problem, pushing));
    if (factor.info() == Eigen::Success) change = factor.solve(right);
  }
  if (change && !change->allFinite()) change.reset();
  return change;
}

// One Newton step on the natural map of all contacts; false where there is none. Forces may leave their cones.
bool newton_step(const ContactProblem& problem, ContactState& state) {
  const std::vector<Pushing> pushing = find_pushing(problem, state);
  if (pushing.empty()) return false;
  VectorXd right(3 * Eigen::Index(pushing.size()));
  for (std::size_t i = 0; i < pushing.size(); ++i) right.segment<3>(3 * Eigen::Index(i)) = pushing[i].right_side;
  const std::optional<VectorXd> change = solve_newton(problem, pushing, right);
  if (!change) return false;
  for (std::size_t i = 0; i < pushing.size(); ++i)
    state.forces.segment<3>(3 * pushing[i].contact) += pushing[i].frame * change->segment<3>(3 * Eigen::Index(i));
  state.motions = motions_of(problem, state.forces);
  return true;
}

// The state with its forces in their cones.
ContactState in_cones(const ContactProblem& problem, ContactState state) {
  for (int i = 0; i < problem.count(); ++i)
    state.forces.segment<3>(3 * i) = within_cone(problem.contacts[i], state.forces.segment<3>(3 * i));
  state.motions = motions_of(problem, state.forces);
  return state;
}

}  // namespace

bool try_newton(const ContactProblem& problem, double tolerance, ContactState& state) {
  ContactState next = state;
  double least = what_is_left(problem, state), before = std::numeric_limits<double>::infinity();
  bool kept = false;
  for (int iteration = 0; iteration < newton_steps && least > tolerance && newton_step(problem, next); ++iteration) {
    ContactState candidate = in_cones(problem, next);
    const double left = what_is_left(problem, candidate);
    if (!(left < before)) break;  // the first may leave more, while sets change
    before = left;
    if (!(left < least)) continue;
    least = left;
    state = std::move(candidate);
    kept = true;
  }
  return kept;
}

}  // namespace umax
