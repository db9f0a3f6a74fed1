// What contacts' compliance on multigrids is made of: the points' shares in each level's nodes, the inverse of the last level
// between those that contacts touch, and of few contacts of one body the whole matrix.
#include <Eigen/Cholesky>
#include <algorithm>
#include <map>

#include "core/base/parallel.h"
#include "core/step/bpx_contact_compliance.h"

namespace umax {
namespace {

constexpr std::size_t most_dense = 100;  // contacts whose compliance is one dense matrix

using Share = BpxContactCompliance::Share;

// a point's cell and node weights on one level
struct Place {
  Vector3i cell;
  Vector8d weights;
};

Place coarser(const Place& fine, const Vector3i& factor) {
  Place coarse{fine.cell.cwiseQuotient(factor), Vector8d::Zero()};
  for (int n = 0; n < 8; ++n) {
    const Vector3i at = fine.cell + corner(n) - coarse.cell.cwiseProduct(factor);  // 0 ... factor
    for (int m = 0; m < 8; ++m) coarse.weights[m] += fine.weights[n] * coarse_weight(at, factor, m);
  }
  return coarse;
}

// numbers for slots as they come
class Numbering {
 public:
  int of(int slot) {
    const auto [found, added] = numbers_.emplace(slot, int(slots_.size()));
    if (added) slots_.push_back(slot);
    return found->second;
  }
  const std::vector<int>& slots() const { return slots_; }

 private:
  std::map<int, int> numbers_;
  std::vector<int> slots_;
};

// (A + G C^-1 G^T)^-1 = A^-1 - A^-1 G S^-1 G^T A^-1,  S = C + G^T A^-1 G, between nodes of the last level. G: terms of no
// group, as the springs of held contacts take no part in what a contact's whole force does.
MatrixXd last_inverse(const Multigrid& multigrid, const SaddlePointMultigrid& terms, const std::vector<int>& slots) {
  constexpr Eigen::Index columns_per_task = 24;
  const std::vector<int>& all = multigrid.dense_slots;
  const auto is_free = [&](int slot) { return multigrid.levels.back().matrix.diagonal[slot] > 0; };
  const auto rows = 3 * Eigen::Index(all.size()), columns = 3 * Eigen::Index(slots.size());
  std::vector<Eigen::Index> first_rows;  // of the slots
  for (const int slot : slots) first_rows.push_back(3 * (std::lower_bound(all.begin(), all.end(), slot) - all.begin()));
  MatrixXd half = MatrixXd::Zero(rows, columns);  // L^-1 at the slots' columns, which are zero before their own rows
  parallel_blocks(columns, columns_per_task, [&](Eigen::Index begin, Eigen::Index end) {
    Eigen::Index first = rows;
    for (Eigen::Index slot = begin / 3; slot < end / 3; ++slot) {
      if (!is_free(slots[std::size_t(slot)])) continue;
      half.block<3, 3>(first_rows[std::size_t(slot)], 3 * slot).setIdentity();
      first = std::min(first, first_rows[std::size_t(slot)]);
    }
    solve_lower(multigrid.dense, half.middleCols(begin, end - begin), first);
  });
  const auto square_of = [&](const MatrixXd& factors) {
    MatrixXd square(columns, columns);
    parallel_blocks(columns, columns_per_task, [&](Eigen::Index begin, Eigen::Index end) {
      square.middleCols(begin, end - begin).noalias() = factors.transpose() * factors.middleCols(begin, end - begin);
    });
    return square;
  };
  MatrixXd inverse = square_of(half);
  if (!terms.has_dense) return inverse;
  const SaddlePointLevel& level = terms.levels.back();
  std::vector<int> single;
  for (int t = 0; t < int(level.terms.groups.size()); ++t)
    if (level.terms.groups[t] == 0) single.push_back(t);
  if (single.empty()) return inverse;
  const MatrixXd half_responses = terms.half_responses(Eigen::all, single);
  MatrixXd S = level.own(single).cast<double>().asDiagonal();
  S.selfadjointView<Eigen::Lower>().rankUpdate(half_responses.transpose());
  MatrixXd through_terms = half_responses.transpose() * half;
  Eigen::LLT<MatrixXd>(S).matrixL().solveInPlace(through_terms);
  inverse -= square_of(through_terms);
  return inverse;
}

// The points that contacts have, without what depends on their bodies' grids.
void add_points(const Model& model, const std::vector<Contact>& contacts, std::vector<Support>& supports,
                BpxContactCompliance& compliance) {
  compliance.first_point.push_back(0);
  for (const Contact& contact : contacts) {
    for_each_support(contact, [&](const Support& support, double sign) {
      compliance.points.push_back(
          {.shares = {}, .body = model.hex_body[support.hex], .sign = sign, .last = {}, .last_motion = {}});
      supports.push_back(support);
    });
    compliance.first_point.push_back(int(compliance.points.size()));
  }
}

void add_body(const Model& model, int body, const BodyGrid& grid, const std::vector<Support>& supports,
              BpxContactCompliance& compliance) {
  const std::vector<MultigridLevel>& levels = grid.multigrid.levels;
  const std::size_t num_single = levels.size() - (grid.multigrid.has_dense ? 1 : 0);
  std::vector<Numbering> numberings(levels.size());
  std::vector<int> of_body;
  for (std::size_t p = 0; p < supports.size(); ++p)
    if (compliance.points[p].body == body) of_body.push_back(int(p));
  for (const int p : of_body) {
    BpxContactCompliance::Point& point = compliance.points[p];
    const Eigen::Index cell = supports[p].hex - model.bodies[body].first_hex;
    Place place{model.bodies[body].cells.row(cell).transpose() - levels.front().lattice().first_cell,
                supports[p].weights};
    for (std::size_t l = 0; l < levels.size(); ++l) {
      if (l > 0) place = coarser(place, levels[l - 1].factor);
      Share share;
      share.weights = place.weights;
      for (int n = 0; n < 8; ++n)
        share.nodes[n] = numberings[l].of(slot_of(levels[l].lattice(), place.cell + corner(n)));
      if (l < num_single)
        point.shares.push_back(share);
      else
        point.last = share;
    }
  }
  for (std::size_t l = 0; l < num_single; ++l) {
    const int first = int(compliance.inverses.size());
    for (const int slot : numberings[l].slots())
      compliance.inverses.push_back(inverse_block(levels[l].inverse, slot).cast<double>());
    for (const int i : of_body)
      for (int& node : compliance.points[i].shares[l].nodes) node += first;
  }
  if (!grid.multigrid.has_dense) return;
  const MatrixXd last = last_inverse(grid.multigrid, grid.terms, numberings.back().slots());
  compliance.last_rows[body] = last.rows();
  for (const int i : of_body) {
    BpxContactCompliance::Point& point = compliance.points[i];
    point.last_motion = MatrixXd::Zero(last.rows(), 3);
    for (int n = 0; n < 8; ++n)
      point.last_motion += point.last.weights[n] * last.middleCols<3>(3 * point.last.nodes[n]);
  }
}

Matrix3d own_block(const BpxContactCompliance& compliance, const BpxContactCompliance::Point& point) {
  Matrix3d sum = Matrix3d::Zero();
  for (const Share& share : point.shares)
    for (int n = 0; n < 8; ++n) sum += share.weights[n] * share.weights[n] * compliance.inverses[share.nodes[n]];
  if (point.last_motion.size() > 0)
    for (int n = 0; n < 8; ++n) sum += point.last.weights[n] * point.last_motion.middleRows<3>(3 * point.last.nodes[n]);
  return sum;
}

// how point a moves under a force at point b of the same body
Matrix3d coupling(const BpxContactCompliance& compliance, const BpxContactCompliance::Point& a,
                  const BpxContactCompliance::Point& b) {
  Matrix3d sum = Matrix3d::Zero();
  for (std::size_t l = 0; l < a.shares.size(); ++l)
    for (int m = 0; m < 8; ++m)
      for (int n = 0; n < 8; ++n)
        if (a.shares[l].nodes[m] == b.shares[l].nodes[n])
          sum += a.shares[l].weights[m] * b.shares[l].weights[n] * compliance.inverses[a.shares[l].nodes[m]];
  if (b.last_motion.size() > 0)
    for (int m = 0; m < 8; ++m) sum += a.last.weights[m] * b.last_motion.middleRows<3>(3 * a.last.nodes[m]);
  return sum;
}

Matrix3d contact_block(const BpxContactCompliance& compliance, int contact) {
  const int first = compliance.first_point[contact];
  const BpxContactCompliance::Point& a = compliance.points[first];
  Matrix3d sum = own_block(compliance, a);
  if (compliance.first_point[contact + 1] == first + 1) return sum;
  const BpxContactCompliance::Point& b = compliance.points[first + 1];
  sum += own_block(compliance, b);
  if (a.body == b.body) {
    const Matrix3d both = coupling(compliance, a, b);
    sum -= both + both.transpose();
  }
  return sum;
}

// B between all contacts, which have one body
MatrixXd dense_matrix(const BpxContactCompliance& compliance) {
  struct Lever {  // of a contact, at a node
    int contact = 0;
    double weight = 0;
  };
  const int count = int(compliance.blocks.size());
  std::vector<std::vector<Lever>> of_nodes(compliance.inverses.size()),
      of_last(std::size_t(compliance.last_rows[0] / 3));
  const auto add_levers = [](int contact, double sign, const Share& share, std::vector<std::vector<Lever>>& levers) {
    for (int n = 0; n < 8; ++n) levers[share.nodes[n]].push_back({contact, sign * share.weights[n]});
  };
  const auto for_each_point = [&](int contact, const auto& visit) {
    for (int p = compliance.first_point[contact]; p < compliance.first_point[contact + 1]; ++p)
      visit(compliance.points[p]);
  };
  for (int i = 0; i < count; ++i)
    for_each_point(i, [&](const BpxContactCompliance::Point& point) {
      for (const Share& share : point.shares) add_levers(i, point.sign, share, of_nodes);
      if (point.last_motion.size() > 0) add_levers(i, point.sign, point.last, of_last);
    });
  MatrixXd matrix = MatrixXd::Zero(3 * count, 3 * count);
  constexpr Eigen::Index grain = 8;  // contacts per task
  parallel_blocks(count, grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (int i = int(begin); i < int(end); ++i) {
      auto columns = matrix.middleCols<3>(3 * i);  // how all move under a force at contact i
      for_each_point(i, [&](const BpxContactCompliance::Point& point) {
        for (const Share& share : point.shares)
          for (int n = 0; n < 8; ++n) {
            const Matrix3d motion = point.sign * share.weights[n] * compliance.inverses[share.nodes[n]];
            for (const Lever& lever : of_nodes[share.nodes[n]])
              columns.middleRows<3>(3 * lever.contact) += lever.weight * motion;
          }
        for (std::size_t node = 0; 3 * Eigen::Index(node) < point.last_motion.rows(); ++node) {
          const Matrix3d motion = point.sign * point.last_motion.middleRows<3>(3 * Eigen::Index(node));
          for (const Lever& lever : of_last[node]) columns.middleRows<3>(3 * lever.contact) += lever.weight * motion;
        }
      });
    }
  });
  return 0.5 * (matrix + matrix.transpose());
}

}  // namespace

BpxContactCompliance make_bpx_contact_compliance(const Model& model, const MultigridSystem& system,
                                                 const std::vector<Contact>& contacts) {
  BpxContactCompliance compliance;
  std::vector<Support> supports;
  add_points(model, contacts, supports, compliance);
  compliance.last_rows.assign(system.bodies.size(), 0);
  for (std::size_t body = 0; body < system.bodies.size(); ++body)
    add_body(model, int(body), system.bodies[body], supports, compliance);
  for (int i = 0; i < int(contacts.size()); ++i) compliance.blocks.push_back(contact_block(compliance, i));
  if (system.bodies.size() == 1 && contacts.size() <= most_dense) compliance.dense = dense_matrix(compliance);
  return compliance;
}

}  // namespace umax
