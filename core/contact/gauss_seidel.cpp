#include "core/contact/gauss_seidel.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace umax {
namespace {

// larger eigenvalue of W_ii across the normal: the step size with which the friction update contracts
double tangential_stiffness(const Matrix3d& W, const Vector3d& n) {
  const Vector3d t1 = n.unitOrthogonal(), t2 = n.cross(t1);
  const double a = t1.dot(W * t1), b = t1.dot(W * t2), c = t2.dot(W * t2);
  return 0.5 * (a + c) + std::sqrt(0.25 * (a - c) * (a - c) + b * b);
}

struct LargestChange {
  double change = 0, size = 0;
  void add(double delta, double value) {
    change = std::max(change, std::abs(delta));
    size = std::max(size, std::abs(value));
  }
  bool below(double tolerance) const { return change <= tolerance * size; }
};

}  // namespace

Vector3d project_to_disc(const Vector3d& tangential, double radius) {
  const double length = tangential.norm();
  return length <= radius ? tangential : Vector3d(tangential * (radius / length));
}

ContactBlock make_contact_block(const Matrix3d& W, const Vector3d& normal) {
  return {W, normal.dot(W * normal), tangential_stiffness(W, normal)};
}

Vector3d relaxed_force(const ContactRow& contact, const ContactBlock& block, const Vector3d& w, const Vector3d& force) {
  const Vector3d n = contact.normal;
  const double old_normal = n.dot(force);
  const double normal = std::max(0.0, old_normal - (n.dot(w) + contact.bias) / block.normal_stiffness);
  const Vector3d velocity = w + block.W * n * (normal - old_normal);
  const Vector3d old_tangential = force - old_normal * n;
  const Vector3d sliding = velocity - n.dot(velocity) * n;
  return normal * n + project_to_disc(old_tangential - sliding / block.friction_stiffness, contact.friction * normal);
}

GaussSeidelResult gauss_seidel(const ComplementarityProblem& problem, const GaussSeidelOptions& options, VectorXd& z) {
  const int num_contacts = int(problem.contacts.size()), first_limit = 3 * num_contacts;
  VectorXd w = problem.W * z + problem.q;
  std::vector<ContactBlock> blocks(num_contacts);
  for (int i = 0; i < num_contacts; ++i)
    blocks[i] = make_contact_block(problem.W.block<3, 3>(3 * i, 3 * i), problem.contacts[i].normal);

  GaussSeidelResult result;
  while (!result.converged && result.sweeps < options.max_sweeps) {
    ++result.sweeps;
    LargestChange contact_change, limit_change;
    for (int i = 0; i < num_contacts; ++i) {
      const Vector3d old = z.segment<3>(3 * i);
      const Vector3d change = relaxed_force(problem.contacts[i], blocks[i], w.segment<3>(3 * i), old) - old;
      if (change.squaredNorm() > 0) {
        z.segment<3>(3 * i) += change;
        w.noalias() += problem.W.middleCols<3>(3 * i) * change;
      }
      contact_change.add(change.cwiseAbs().maxCoeff(), z.segment<3>(3 * i).cwiseAbs().maxCoeff());
    }
    for (int row = first_limit; row < first_limit + problem.num_limits; ++row) {
      const double value = std::max(0.0, z[row] - w[row] / problem.W(row, row));
      const double change = value - z[row];
      if (change != 0) {
        z[row] = value;
        w.noalias() += problem.W.col(row) * change;
      }
      limit_change.add(change, value);
    }
    result.converged = contact_change.below(options.tolerance) && limit_change.below(options.tolerance);
  }
  return result;
}

}  // namespace umax
