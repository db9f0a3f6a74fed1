// How far each contact point moves under every contact's force, nearly: the compliance J A^-1 J^T of contacts with
// the inverse B of the BPX preconditioner in place of A^-1 (Bramble, Pasciak & Xu 1990, Parallel multilevel
// preconditioners, Math. Comp. 55):
//
//   B = sum over levels of P D^-1 P^T,   on the last one P A^-1 P^T
//
// A contact's force moves eight nodes on each level and no more, so that a Gauss-Seidel sweep over thousands of
// contacts costs next to nothing, where a Delassus matrix could not even be stored. Up to a factor it is the Delassus
// matrix; responses that were measured make it exact along their forces, in the manner of BFGS (Nocedal & Wright
// 2006, Numerical Optimization, ch. 6):
//
//   W = B - B S (S^T B S)^-1 S^T B + Y (S^T Y)^-1 Y^T,    S: forces, Y: what they did
#pragma once

#include <array>
#include <vector>

#include "core/contact/contact.h"
#include "core/contact/gauss_seidel.h"
#include "core/step/multigrid_system.h"

namespace umax {

struct BpxContactCompliance {
  struct Share {  // of a contact's point, on one level
    std::array<int, 8> nodes{};
    Vector8d weights = Vector8d::Zero();
  };
  struct Point {
    std::vector<Share> shares;  // on levels whose nodes move one by one
    int body = 0;
    double sign = 1;       // of the contact's force on it
    Share last;            // on the last level, whose nodes move together:
    MatrixXd last_motion;  // of its touched nodes (3 each) under a force at the point
  };
  std::vector<Point> points;            // of the first contact, of the second, ...: each has one or two
  std::vector<int> first_point;         // #C + 1
  std::vector<Matrix3d> inverses;       // D^-1 of the nodes that contacts touch, of all levels
  std::vector<Eigen::Index> last_rows;  // per body: 3 for each touched node of its last level
  std::vector<Matrix3d> blocks;         // per contact: its own motion under its own force, of B
  MatrixXd forces, responses;           // S, Y: a column for each measurement
  MatrixXd factors;                     // B S beside Y
  MatrixXd middle;                      // so that W = B + factors middle factors^T
  MatrixXd dense;                       // B as one matrix, of few contacts of one body; empty: others
};

BpxContactCompliance make_bpx_contact_compliance(const Model& model, const MultigridSystem& system,
                                                 const std::vector<Contact>& contacts);

/// The motions W f of contact points under forces f (3 per contact).
VectorXd apply(const BpxContactCompliance& compliance, const VectorXd& forces);

/// Makes W f the response.
void learn(const VectorXd& forces, const VectorXd& response, BpxContactCompliance& compliance);

/// Adds a contact's change of force to its bodies'.
void add_changes(const BpxContactCompliance& compliance, int contact, const Vector3d& change, const Vector3d& force,
                 ForceChanges& changes);

/// Contact forces for W: improves them in place, by projected Gauss-Seidel, of few contacts of one body by what
/// core/step/contact_forces.h has beside it. Returns the sweeps.
int solve_contacts(const BpxContactCompliance& compliance, const std::vector<ContactRow>& rows, const VectorXd& q,
                   const GaussSeidelOptions& options, VectorXd& forces);

}  // namespace umax
