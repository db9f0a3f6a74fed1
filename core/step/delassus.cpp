#include "core/step/delassus.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/problem/step_problem.h"

namespace umax {
namespace {

constexpr Eigen::Index columns_per_block = 48;

bool is_last(const Model& model, const Model::BodyRange& body, const SparseCholesky& cholesky, const Support& point) {
  for (int n = 0; n < 8; ++n)
    if (cholesky.last_row(model.hexes(point.hex, n) - body.first_node) < 0) return false;
  return true;
}

// L^-1 J^T of the body's points from `first` on; row(node): of the node's first unknown
template <class Row>
MatrixXd point_columns(const Model& model, const std::vector<Support>& points, std::size_t first, Eigen::Index rows,
                       const Row& row) {
  MatrixXd columns = MatrixXd::Zero(rows, 3 * Eigen::Index(points.size() - first));
  for (std::size_t i = first; i < points.size(); ++i)
    for (int n = 0; n < 8; ++n) {
      const int node = model.hexes(points[i].hex, n);
      if (model.node_fixed[node]) continue;
      for (int axis = 0; axis < 3; ++axis)
        columns(row(node) + axis, 3 * Eigen::Index(i - first) + axis) += points[i].weights[n];
    }
  return columns;
}

MatrixXd half_columns(const Model& model, const Model::BodyRange& body, const SparseCholesky& cholesky,
                      const std::vector<Support>& points, std::size_t first, bool in_last) {
  const Eigen::Index rows = in_last ? cholesky.num_last() : 3 * Eigen::Index(body.num_nodes);
  MatrixXd columns = point_columns(model, points, first, rows, [&](int node) {
    return in_last ? cholesky.last_row(node - body.first_node) : 3 * (node - body.first_node);
  });
  if (in_last)
    cholesky.half_solve_last(columns);
  else
    cholesky.half_solve(columns);
  return columns;
}

void extend(const Model& model, const Model::BodyRange& body, const SparseCholesky& cholesky, BodyDelassus& delassus) {
  Eigen::Index known = delassus.half.cols();
  const Eigen::Index size = 3 * Eigen::Index(delassus.points.size());
  if (known == size) return;
  const bool in_last =
      delassus.in_last && std::all_of(delassus.points.begin() + known / 3, delassus.points.end(),
                                      [&](const Support& point) { return is_last(model, body, cholesky, point); });
  if (delassus.in_last && !in_last) known = 0;  // the rows change: once more, all of them
  delassus.in_last = in_last;

  const MatrixXd added = half_columns(model, body, cholesky, delassus.points, std::size_t(known / 3), in_last);
  delassus.half.conservativeResize(added.rows(), size);
  delassus.half.rightCols(size - known) = added;
  delassus.W.conservativeResize(size, size);
  parallel_blocks(size - known, columns_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    delassus.W.middleCols(known + begin, end - begin).noalias() =
        delassus.half.transpose() * added.middleCols(begin, end - begin);
  });
  delassus.W.bottomLeftCorner(size - known, known) = delassus.W.topRightCorner(known, size - known).transpose();
}

// how the contact moves under its own force
Matrix3d own_block(const Delassus& delassus, int contact) {
  Matrix3d block = Matrix3d::Zero();
  for (int a = delassus.first_side[contact]; a < delassus.first_side[contact + 1]; ++a)
    for (int b = delassus.first_side[contact]; b < delassus.first_side[contact + 1]; ++b) {
      const Delassus::Side &to = delassus.sides[a], &from = delassus.sides[b];
      if (to.body == from.body)
        block += to.sign * from.sign * delassus.bodies[to.body].W.block<3, 3>(3 * to.point, 3 * from.point);
    }
  return block;
}

// forces at the points of each body
std::vector<VectorXd> on_points(const Delassus& delassus, const VectorXd& forces) {
  std::vector<VectorXd> on(delassus.bodies.size());
  for (std::size_t b = 0; b < on.size(); ++b) on[b].setZero(delassus.bodies[b].W.rows());
  for (std::size_t i = 0; i + 1 < delassus.first_side.size(); ++i)
    for (int s = delassus.first_side[i]; s < delassus.first_side[i + 1]; ++s)
      on[delassus.sides[s].body].segment<3>(3 * delassus.sides[s].point) =
          delassus.sides[s].sign * forces.segment<3>(3 * Eigen::Index(i));
  return on;
}

// Motions of the points of each body under the forces, with the q of contacts at their first points.
std::vector<VectorXd> motions_of_points(const Delassus& delassus, const VectorXd& q, const VectorXd& forces) {
  const std::vector<VectorXd> on = on_points(delassus, forces);
  std::vector<VectorXd> added(on.size()), motions(on.size());
  for (std::size_t b = 0; b < on.size(); ++b) added[b].setZero(on[b].size());
  for (std::size_t i = 0; i + 1 < delassus.first_side.size(); ++i) {
    const Delassus::Side& side = delassus.sides[delassus.first_side[i]];
    added[side.body].segment<3>(3 * side.point) = q.segment<3>(3 * Eigen::Index(i));
  }
  for (std::size_t b = 0; b < on.size(); ++b) motions[b] = delassus.bodies[b].W * on[b] + added[b];
  return motions;
}

}  // namespace

void extend(const Model& model, const Workspace::Data& workspace, const std::vector<Contact>& contacts,
            Delassus& delassus) {
  delassus.bodies.resize(model.bodies.size());
  for (std::size_t i = delassus.first_side.size() - 1; i < contacts.size(); ++i) {
    for_each_support(contacts[i], [&](const Support& support, double sign) {
      const int body = model.hex_body[support.hex];
      delassus.sides.push_back({body, int(delassus.bodies[body].points.size()), sign});
      delassus.bodies[body].points.push_back(support);
    });
    delassus.first_side.push_back(int(delassus.sides.size()));
  }
  for (std::size_t b = 0; b < model.bodies.size(); ++b)
    extend(model, model.bodies[b], workspace.bodies[b].cholesky, delassus.bodies[b]);
}

MatrixXd dense(const Delassus& delassus) {
  const Eigen::Index size = 3 * Eigen::Index(delassus.first_side.size() - 1);
  MatrixXd W = MatrixXd::Zero(size, size);
  for (Eigen::Index i = 0; 3 * i < size; ++i)
    for (Eigen::Index j = 0; 3 * j < size; ++j)
      for (int a = delassus.first_side[i]; a < delassus.first_side[i + 1]; ++a)
        for (int b = delassus.first_side[j]; b < delassus.first_side[j + 1]; ++b) {
          const Delassus::Side &to = delassus.sides[a], &from = delassus.sides[b];
          if (to.body == from.body)
            W.block<3, 3>(3 * i, 3 * j) +=
                to.sign * from.sign * delassus.bodies[to.body].W.block<3, 3>(3 * to.point, 3 * from.point);
        }
  return W;
}

GaussSeidelResult gauss_seidel(const Delassus& delassus, const std::vector<ContactRow>& contacts, const VectorXd& q,
                               const GaussSeidelOptions& options, VectorXd& forces) {
  const int count = int(contacts.size());
  std::vector<VectorXd> motions = motions_of_points(delassus, q, forces);
  std::vector<ContactBlock> blocks;
  for (int i = 0; i < count; ++i) blocks.push_back(make_contact_block(own_block(delassus, i), contacts[i].normal));
  GaussSeidelResult result;
  while (!result.converged && result.sweeps < options.max_sweeps) {
    ++result.sweeps;
    ForceChanges changes(delassus.bodies.size());
    for (int i = 0; i < count; ++i) {
      const int begin = delassus.first_side[i], end = delassus.first_side[i + 1];
      Vector3d w = Vector3d::Zero();
      for (int s = begin; s < end; ++s)
        w += delassus.sides[s].sign * motions[delassus.sides[s].body].segment<3>(3 * delassus.sides[s].point);
      const Vector3d old = forces.segment<3>(3 * i);
      const Vector3d change = relaxed_force(contacts[i], blocks[i], w, old) - old;
      if (change.squaredNorm() > 0) {
        forces.segment<3>(3 * i) += change;
        for (int s = begin; s < end; ++s) {
          const Delassus::Side& side = delassus.sides[s];
          motions[side.body].noalias() +=
              delassus.bodies[side.body].W.middleCols<3>(3 * side.point) * Vector3d(side.sign * change);
        }
      }
      for (int s = begin; s < end; ++s)
        changes.add(delassus.sides[s].body, change.cwiseAbs().maxCoeff(),
                    forces.segment<3>(3 * i).cwiseAbs().maxCoeff());
    }
    result.converged = changes.are_within(options.tolerance);
  }
  return result;
}

}  // namespace umax
