#include "core/step/delassus.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/problem/step_problem.h"

namespace umax {
namespace {

constexpr Eigen::Index columns_per_block = 48;

bool is_last(const Model& model, const SparseCholesky& cholesky, const Contact& contact) {
  bool is_last = true;
  for_each_node(model, contact, [&](int node, double) { is_last = is_last && cholesky.last_row(node) >= 0; });
  return is_last;
}

// L^-1 J^T of the contacts from `first` on
MatrixXd half_columns(const Model& model, const SparseCholesky& cholesky, const std::vector<Contact>& contacts,
                      std::size_t first) {
  MatrixXd columns = MatrixXd::Zero(3 * model.num_nodes(), 3 * Eigen::Index(contacts.size() - first));
  for (std::size_t i = first; i < contacts.size(); ++i)
    for (int axis = 0; axis < 3; ++axis)
      spread(model, contacts[i], Vector3d::Unit(axis), columns.col(3 * Eigen::Index(i - first) + axis));
  clear_fixed(model, columns);
  cholesky.half_solve(columns);
  return columns;
}

// the same where all of them ride on unknowns eliminated last
MatrixXd half_columns_last(const Model& model, const SparseCholesky& cholesky, const std::vector<Contact>& contacts,
                           std::size_t first) {
  MatrixXd columns = MatrixXd::Zero(cholesky.num_last(), 3 * Eigen::Index(contacts.size() - first));
  for (std::size_t i = first; i < contacts.size(); ++i)
    for_each_node(model, contacts[i], [&](int node, double weight) {
      if (model.node_fixed[node]) return;
      for (int axis = 0; axis < 3; ++axis)
        columns(cholesky.last_row(node) + axis, 3 * Eigen::Index(i - first) + axis) = weight;
    });
  cholesky.half_solve_last(columns);
  return columns;
}

}  // namespace

void extend(const Model& model, const SparseCholesky& cholesky, const std::vector<Contact>& contacts,
            Delassus& delassus) {
  Eigen::Index known = delassus.half.cols();
  const Eigen::Index size = 3 * Eigen::Index(contacts.size());
  if (known == size) return;
  const bool in_last = delassus.in_last && std::all_of(contacts.begin() + known / 3, contacts.end(),
                                                       [&](const Contact& c) { return is_last(model, cholesky, c); });
  if (delassus.in_last && !in_last) known = 0;  // the rows change: once more, all of them
  delassus.in_last = in_last;

  const MatrixXd added = in_last ? half_columns_last(model, cholesky, contacts, std::size_t(known / 3))
                                 : half_columns(model, cholesky, contacts, std::size_t(known / 3));
  delassus.half.conservativeResize(added.rows(), size);
  delassus.half.rightCols(size - known) = added;
  delassus.W.conservativeResize(size, size);
  parallel_blocks(size - known, columns_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    delassus.W.middleCols(known + begin, end - begin).noalias() =
        delassus.half.transpose() * added.middleCols(begin, end - begin);
  });
  delassus.W.bottomLeftCorner(size - known, known) = delassus.W.topRightCorner(known, size - known).transpose();
}

}  // namespace umax
