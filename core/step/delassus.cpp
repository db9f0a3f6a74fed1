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

std::vector<VectorXd> at_points(const Delassus& delassus, const VectorXd& forces) {
  std::vector<VectorXd> on(delassus.bodies.size());
  for (std::size_t b = 0; b < on.size(); ++b) on[b].setZero(delassus.bodies[b].W.rows());
  for (int i = 0; i + 1 < int(delassus.first_side.size()); ++i)
    for_each_side(delassus, i, [&](const Delassus::Side& side) {
      on[std::size_t(side.body)].segment<3>(3 * side.point) = side.sign * forces.segment<3>(3 * i);
    });
  return on;
}

VectorXd contact_motions(const Model& model, const Workspace::Data& workspace, const Delassus& delassus,
                         const VectorXd& y) {
  std::vector<VectorXd> of_points(delassus.bodies.size());
  parallel_blocks(Eigen::Index(of_points.size()), 1, [&](Eigen::Index b, Eigen::Index) {
    const Model::BodyRange& body = model.bodies[std::size_t(b)];
    const BodyDelassus& of_body = delassus.bodies[std::size_t(b)];
    VectorXd& motions = of_points[std::size_t(b)];
    motions.resize(3 * Eigen::Index(of_body.points.size()));
    Eigen::Index first = 0;
    for (const HalfColumns& half : of_body.halves) {
      motions.segment(first, half.count) = products(workspace.bodies[std::size_t(b)].cholesky.columns(), half,
                                                    y.segment(3 * body.first_node, 3 * body.num_nodes));
      first += half.count;
    }
  });
  const auto count = Eigen::Index(delassus.first_side.size()) - 1;
  VectorXd motions = VectorXd::Zero(3 * count);
  for (Eigen::Index i = 0; i < count; ++i)
    for_each_side(delassus, int(i), [&](const Delassus::Side& side) {
      motions.segment<3>(3 * i) += side.sign * of_points[std::size_t(side.body)].segment<3>(3 * side.point);
    });
  return motions;
}

void add_forces(const Model& model, const Workspace::Data& workspace, const Delassus& delassus, const VectorXd& forces,
                VectorXd& y) {
  const std::vector<VectorXd> on = at_points(delassus, forces);
  parallel_blocks(Eigen::Index(on.size()), 1, [&](Eigen::Index b, Eigen::Index) {
    const Model::BodyRange& body = model.bodies[std::size_t(b)];
    Eigen::Index first = 0;
    for (const HalfColumns& half : delassus.bodies[std::size_t(b)].halves) {
      add_columns(workspace.bodies[std::size_t(b)].cholesky.columns(), half,
                  on[std::size_t(b)].segment(first, half.count), y.segment(3 * body.first_node, 3 * body.num_nodes));
      first += half.count;
    }
  });
}

Matrix3d compliance(const Delassus& delassus, int to, int from) {
  Matrix3d sum = Matrix3d::Zero();
  for_each_side(delassus, to, [&](const Delassus::Side& a) {
    for_each_side(delassus, from, [&](const Delassus::Side& b) {
      if (a.body == b.body) sum += a.sign * b.sign * delassus.bodies[a.body].W.block<3, 3>(3 * a.point, 3 * b.point);
    });
  });
  return sum;
}

MatrixXd dense(const Delassus& delassus) {
  const int count = int(delassus.first_side.size()) - 1;
  MatrixXd W(3 * count, 3 * count);
  for (int i = 0; i < count; ++i)
    for (int j = 0; j < count; ++j) W.block<3, 3>(3 * i, 3 * j) = compliance(delassus, i, j);
  return W;
}

}  // namespace umax
