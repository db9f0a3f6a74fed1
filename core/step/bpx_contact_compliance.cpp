#include "core/step/bpx_contact_compliance.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/step/contact_forces.h"

namespace umax {
namespace {

constexpr Eigen::Index most_measurements = 8;
constexpr double least_independence = 0.1;  // [-] of a measured force from the others, in the norm of the response

using Share = BpxContactCompliance::Share;

// what moves under the forces so far
struct Motion {
  std::vector<Vector3d> nodes;
  std::vector<VectorXd> last;  // per body
};

Motion at_rest(const BpxContactCompliance& compliance) {
  Motion motion{std::vector<Vector3d>(compliance.inverses.size(), Vector3d::Zero()), {}};
  for (const Eigen::Index rows : compliance.last_rows) motion.last.push_back(VectorXd::Zero(rows));
  return motion;
}

void push_point(const BpxContactCompliance& compliance, const BpxContactCompliance::Point& point, const Vector3d& force,
                Motion& motion) {
  for (const Share& share : point.shares)
    for (int n = 0; n < 8; ++n)
      motion.nodes[share.nodes[n]].noalias() += compliance.inverses[share.nodes[n]] * (share.weights[n] * force);
  if (point.last_motion.size() > 0) motion.last[point.body].noalias() += point.last_motion.lazyProduct(force);
}

Vector3d motion_of_point(const BpxContactCompliance::Point& point, const Motion& motion) {
  Vector3d sum = Vector3d::Zero();
  for (const Share& share : point.shares)
    for (int n = 0; n < 8; ++n) sum += share.weights[n] * motion.nodes[share.nodes[n]];
  if (point.last_motion.size() > 0)
    for (int n = 0; n < 8; ++n)
      sum += point.last.weights[n] * motion.last[point.body].segment<3>(3 * point.last.nodes[n]);
  return sum;
}

void push(const BpxContactCompliance& compliance, int contact, const Vector3d& force, Motion& motion) {
  for (int p = compliance.first_point[contact]; p < compliance.first_point[contact + 1]; ++p)
    push_point(compliance, compliance.points[p], compliance.points[p].sign * force, motion);
}

Vector3d motion_of(const BpxContactCompliance& compliance, int contact, const Motion& motion) {
  Vector3d sum = Vector3d::Zero();
  for (int p = compliance.first_point[contact]; p < compliance.first_point[contact + 1]; ++p)
    sum += compliance.points[p].sign * motion_of_point(compliance.points[p], motion);
  return sum;
}

// J B J^T f
VectorXd apply_unmeasured(const BpxContactCompliance& compliance, const VectorXd& forces) {
  Motion motion = at_rest(compliance);
  const int count = int(compliance.blocks.size());
  for (int i = 0; i < count; ++i) push(compliance, i, forces.segment<3>(3 * i), motion);
  VectorXd motions(forces.size());
  for (int i = 0; i < count; ++i) motions.segment<3>(3 * i) = motion_of(compliance, i, motion);
  return motions;
}

// W of contacts that push one body, each at a point of its own
Delassus delassus_of(const BpxContactCompliance& compliance) {
  Delassus delassus;
  delassus.bodies.resize(1);
  MatrixXd& W = delassus.bodies.front().W;
  W = compliance.dense;
  if (compliance.factors.cols() > 0) W += compliance.factors * compliance.middle * compliance.factors.transpose();
  for (int i = 0; i < int(compliance.blocks.size()); ++i) {
    delassus.sides.push_back({.body = 0, .point = i});
    delassus.first_side.push_back(i + 1);
  }
  return delassus;
}

}  // namespace

void add_changes(const BpxContactCompliance& compliance, int contact, const Vector3d& change, const Vector3d& force,
                 ForceChanges& changes) {
  for (int p = compliance.first_point[contact]; p < compliance.first_point[contact + 1]; ++p)
    changes.add(compliance.points[p].body, change.cwiseAbs().maxCoeff(), force.cwiseAbs().maxCoeff());
}

VectorXd apply(const BpxContactCompliance& compliance, const VectorXd& forces) {
  VectorXd motions = apply_unmeasured(compliance, forces);
  if (compliance.factors.cols() > 0)
    motions += compliance.factors * (compliance.middle * (compliance.factors.transpose() * forces));
  return motions;
}

void learn(const VectorXd& forces, const VectorXd& response, BpxContactCompliance& compliance) {
  const VectorXd assumed = apply_unmeasured(compliance, forces);
  const double met = forces.dot(response), expected = forces.dot(assumed);
  if (!(met > 0 && expected > 0)) return;
  const double size = 1 / std::sqrt(met);  // S^T Y has ones on its diagonal
  Eigen::Index first = compliance.forces.cols() == most_measurements ? 1 : 0;
  const Eigen::Index kept = compliance.forces.cols();
  MatrixXd S(forces.size(), kept + 1), Y(forces.size(), kept + 1), BS(forces.size(), kept + 1);
  if (kept > 0) {
    S.leftCols(kept) = compliance.forces;
    Y.leftCols(kept) = compliance.responses;
    BS.leftCols(kept) = compliance.factors.leftCols(kept);
  }
  S.col(kept) = size * forces;
  Y.col(kept) = size * response;
  BS.col(kept) = size * assumed;
  for (; first <= kept; ++first) {  // without the oldest ones that the others nearly contain
    const Eigen::Index count = kept + 1 - first;
    const auto s = S.rightCols(count), y = Y.rightCols(count), bs = BS.rightCols(count);
    MatrixXd SY = s.transpose() * y, SBS = s.transpose() * bs;
    SY = (0.5 * (SY + SY.transpose())).eval();
    SBS = (0.5 * (SBS + SBS.transpose())).eval();
    const Eigen::LLT<MatrixXd> met_factor(SY), assumed_factor(SBS);
    if (met_factor.info() != Eigen::Success || assumed_factor.info() != Eigen::Success) continue;
    if (MatrixXd(met_factor.matrixL()).diagonal().minCoeff() < least_independence) continue;
    const MatrixXd one = MatrixXd::Identity(count, count);
    compliance.middle = MatrixXd::Zero(2 * count, 2 * count);
    compliance.middle.topLeftCorner(count, count) = -assumed_factor.solve(one);
    compliance.middle.bottomRightCorner(count, count) = met_factor.solve(one);
    compliance.factors.resize(forces.size(), 2 * count);
    compliance.factors << bs, y;
    compliance.forces = s;
    compliance.responses = y;
    return;
  }
}

int solve_contacts(const BpxContactCompliance& compliance, const std::vector<ContactRow>& rows, const VectorXd& q,
                   const GaussSeidelOptions& options, VectorXd& forces) {
  if (compliance.dense.size() > 0) return solve_contacts(delassus_of(compliance), rows, q, options, forces).sweeps;
  const int count = int(rows.size());
  const MatrixXd &factors = compliance.factors, &middle = compliance.middle;
  const bool measured = factors.cols() > 0;
  std::vector<ContactBlock> blocks;
  for (int i = 0; i < count; ++i) {
    Matrix3d block = compliance.blocks[i];
    if (measured) block += factors.middleRows<3>(3 * i) * middle * factors.middleRows<3>(3 * i).transpose();
    blocks.push_back(make_contact_block(block, rows[i].normal));
  }
  Motion motion = at_rest(compliance);
  for (int i = 0; i < count; ++i) push(compliance, i, forces.segment<3>(3 * i), motion);
  VectorXd shares = VectorXd::Zero(factors.cols());  // middle factors^T f
  if (measured) shares = middle * (factors.transpose() * forces);
  int sweeps = 0;
  bool settled = false;
  while (sweeps < options.max_sweeps && !settled) {
    ++sweeps;
    ForceChanges changes(compliance.last_rows.size());
    for (int i = 0; i < count; ++i) {
      const Vector3d old = forces.segment<3>(3 * i);
      Vector3d w = q.segment<3>(3 * i) + motion_of(compliance, i, motion);
      if (measured) w += factors.middleRows<3>(3 * i) * shares;
      const Vector3d next = relaxed_force(rows[i], blocks[i], w, old);
      if (next != old) {
        push(compliance, i, next - old, motion);
        if (measured) shares += middle * (factors.middleRows<3>(3 * i).transpose() * (next - old));
      }
      forces.segment<3>(3 * i) = next;
      add_changes(compliance, i, next - old, next, changes);
    }
    settled = changes.are_within(options.tolerance);
  }
  return sweeps;
}

}  // namespace umax
