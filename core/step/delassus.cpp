#include "core/step/delassus.h"

#include <utility>

#include "core/base/parallel.h"
#include "core/problem/step_problem.h"

namespace umax {
namespace {

// J^T of the body's points from `first` on, its rows in elimination order
std::vector<SparseEntry> point_columns(const Model& model, const Model::BodyRange& body, const SystemMatrix& matrix,
                                       const std::vector<Support>& points, std::size_t first) {
  std::vector<SparseEntry> entries;
  for (std::size_t i = first; i < points.size(); ++i)
    for (int n = 0; n < 8; ++n) {
      const int node = model.hexes(points[i].hex, n);
      if (model.node_fixed[node]) continue;
      for (int axis = 0; axis < 3; ++axis)
        entries.push_back(
            {3 * matrix.ranks[node - body.first_node] + axis, 3 * int(i - first) + axis, points[i].weights[n]});
    }
  return entries;
}

void extend(const Model& model, const Model::BodyRange& body, const DirectSystem& system, BodyDelassus& delassus) {
  const Eigen::Index known = delassus.W.cols(), size = 3 * Eigen::Index(delassus.points.size());
  if (known == size) return;
  const std::vector<SparseEntry> entries =
      point_columns(model, body, *system.matrix, delassus.points, std::size_t(known / 3));
  HalfColumns added = half_solve(system.cholesky.columns(), entries, size - known);
  delassus.W.conservativeResize(size, size);
  Eigen::Index first = 0;
  for (const HalfColumns& half : delassus.halves) {
    delassus.W.block(first, known, half.count, added.count) = products(half, added);
    first += half.count;
  }
  delassus.W.bottomRightCorner(added.count, added.count) = products(added);
  delassus.W.bottomLeftCorner(added.count, known) = delassus.W.topRightCorner(known, added.count).transpose();
  delassus.halves.push_back(std::move(added));
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
  parallel_blocks(Eigen::Index(model.bodies.size()), 1, [&](Eigen::Index b, Eigen::Index) {
    extend(model, model.bodies[std::size_t(b)], workspace.bodies[std::size_t(b)], delassus.bodies[std::size_t(b)]);
  });
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

}  // namespace umax
