// Projected Gauss-Seidel for energy limits and frictional contacts together.                  [PPO13] Eq. 23, Sect. 5
//
// Motion     w = W z + q
// Contact i  n.w_i + bias_i >= 0  perp  n.z_i >= 0;   |z_t| <= friction n.z and z_t opposes w_t (Coulomb's cone)
// Limit e    w_e >= 0             perp  z_e >= 0
//
// z: the unknowns, 3 world components of force [N] per contact, then one multiplier per limit;  W: #z x #z
// a >= 0  perp  b >= 0:  both hold and a b = 0
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "core/base/types.h"

namespace umax {

struct ContactRow {
  Vector3d normal = Vector3d::UnitY();
  double friction = 0;  // [-]
  double bias = 0;      // as w, [m] or [m/s]: what the normal motion may be short of
};

struct ComplementarityProblem {
  MatrixXd W;  // symmetric, 3 contacts + limits
  VectorXd q;
  std::vector<ContactRow> contacts;  // the first 3 * size() rows
  int num_limits = 0;                // the last rows
};

struct GaussSeidelOptions {
  int max_sweeps = 2000;       // raising it costs time on ill-conditioned problems, helps nothing else
  double tolerance = 1e-6;     // [-] a sweep's largest change relative to the largest unknown of its kind
  bool is_rough = false;       // of many contacts forces near the solution will do: sweeps alone
  double proximal_weight = 0;  // [-] solve_contacts() alone: holds forces near those that it is given
};

struct GaussSeidelResult {
  int sweeps = 0;
  bool converged = false;
};

/// Improves z in place from its start value (warm start; 0 is always admissible).
GaussSeidelResult gauss_seidel(const ComplementarityProblem& problem, const GaussSeidelOptions& options, VectorXd& z);

/// How much contact forces change beside the largest ones, body by body: what is little for a heavy body is much for a light
/// one that it touches.
class ForceChanges {
 public:
  explicit ForceChanges(std::size_t num_bodies) : changes_(num_bodies, 0), sizes_(num_bodies, 0) {}
  /// A contact's on one of its bodies; largest components [N].
  void add(int body, double change, double size) {
    changes_[std::size_t(body)] = std::max(changes_[std::size_t(body)], change);
    sizes_[std::size_t(body)] = std::max(sizes_[std::size_t(body)], size);
  }
  /// Are they no more than this share of what the body bears, on each?
  bool are_within(double share) const {
    for (std::size_t b = 0; b < changes_.size(); ++b)
      if (changes_[b] > share * sizes_[b]) return false;
    return true;
  }
  /// The largest such share of any body.
  double largest() const {
    double share = 0;
    for (std::size_t b = 0; b < changes_.size(); ++b)
      if (changes_[b] > 0) share = std::max(share, changes_[b] / sizes_[b]);
    return share;
  }

 private:
  std::vector<double> changes_, sizes_;
};

/// A contact's own part of W, and by how much its force is changed for a motion.
struct ContactBlock {
  Matrix3d W = Matrix3d::Zero();
  double normal_stiffness = 0, friction_stiffness = 0;
};
ContactBlock make_contact_block(const Matrix3d& W, const Vector3d& normal);

/// The contact's next force: the normal one first, then friction within the new cone. w: its motion with `force`.
Vector3d relaxed_force(const ContactRow& contact, const ContactBlock& block, const Vector3d& w, const Vector3d& force);

/// Nearest point of the disc |t| <= radius in the plane across the normal.
Vector3d project_to_disc(const Vector3d& tangential, double radius);

}  // namespace umax
