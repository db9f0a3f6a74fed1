#include "core/step/delassus.h"

#include <utility>

#include "core/base/parallel.h"
#include "core/problem/step_problem.h"

namespace umax {
namespace {

constexpr Eigen::Index points_per_block = 64;  // of a body alone; several bodies are the work of several threads anyway

// J^T of the body's points `first` ... `end` - 1, its rows in elimination order
std::vector<SparseEntry> point_columns(const Model& model, const Model::BodyRange& body, const SystemMatrix& matrix,
                                       const std::vector<Support>& points, Eigen::Index first, Eigen::Index end) {
  std::vector<SparseEntry> entries;
  for (Eigen::Index i = first; i < end; ++i) {
    const Support& point = points[std::size_t(i)];
    for (int n = 0; n < 8; ++n) {
      const int node = model.hexes(point.hex, n);
      if (model.node_fixed[node]) continue;
      for (int axis = 0; axis < 3; ++axis)
        entries.push_back(
            {3 * matrix.ranks[node - body.first_node] + axis, 3 * int(i - first) + axis, point.weights[n]});
    }
  }
  return entries;
}

// The columns of new points, some points at a time, and their products with all columns.
void extend(const Model& model, const Model::BodyRange& body, const DirectSystem& system, BodyDelassus& delassus) {
  const Eigen::Index known = delassus.W.cols() / 3, count = Eigen::Index(delassus.points.size());
  if (known == count) return;
  const std::size_t num_known = delassus.halves.size();
  const Eigen::Index at_a_time = model.bodies.size() == 1 ? points_per_block : count;
  delassus.halves.resize(num_known + std::size_t((count - known + at_a_time - 1) / at_a_time));
  parallel_blocks(count - known, at_a_time, [&](Eigen::Index begin, Eigen::Index end) {
    delassus.halves[num_known + std::size_t(begin / at_a_time)] = half_solve(
        system.cholesky.columns(),
        point_columns(model, body, *system.matrix, delassus.points, known + begin, known + end), 3 * (end - begin));
  });

  struct Pair {
    std::size_t a = 0, b = 0;                      // of halves
    Eigen::Index first_row = 0, first_column = 0;  // of their block of W
  };
  std::vector<Pair> pairs;
  Eigen::Index first_column = 0;
  for (std::size_t b = 0; b < delassus.halves.size(); first_column += delassus.halves[b++].count) {
    if (b < num_known) continue;
    Eigen::Index first_row = 0;
    for (std::size_t a = 0; a <= b; first_row += delassus.halves[a++].count)
      pairs.push_back({a, b, first_row, first_column});
  }
  delassus.W.conservativeResize(3 * count, 3 * count);
  parallel_blocks(Eigen::Index(pairs.size()), 1, [&](Eigen::Index i, Eigen::Index) {
    const auto& [a, b, row, column] = pairs[std::size_t(i)];
    const MatrixXd block = a == b ? products(delassus.halves[b]) : products(delassus.halves[a], delassus.halves[b]);
    delassus.W.block(row, column, block.rows(), block.cols()) = block;
    if (a != b) delassus.W.block(column, row, block.cols(), block.rows()) = block.transpose();
  });
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
