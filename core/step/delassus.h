// The compliance of a growing set of contacts: W = J A^-1 J^T, how far each contact's force moves every other one. It
// is called the Delassus operator (Acary & Brogliato 2008, Numerical Methods for Nonsmooth Dynamical Systems).
//
// Contacts push each other through the bodies that they have in common alone, so W is a sum over bodies of small dense
// matrices of the points at which contacts push the body.
#pragma once

#include <vector>

#include "core/contact/contact_support.h"
#include "core/contact/gauss_seidel.h"
#include "core/step/workspace.h"

namespace umax {

/// Of one body: three world directions per point at which a contact pushes it.
struct BodyDelassus {
  std::vector<Support> points;
  MatrixXd W;                       // [m/N] 3 #P x 3 #P
  std::vector<HalfColumns> halves;  // L^-1 J^T, of the points as they came
};

struct Delassus {
  struct Side {  // of a contact
    int body = 0, point = 0;
    double sign = 1;  // of the contact's force on the body
  };
  std::vector<BodyDelassus> bodies;
  std::vector<Side> sides;         // of the first contact, of the second, ...: each has one or two
  std::vector<int> first_side{0};  // #C + 1
};

/// Adds those of the contacts that are not in it yet (they are the last ones), against the present factors.
void extend(const Model& model, const Workspace::Data& workspace, const std::vector<Contact>& contacts,
            Delassus& delassus);

/// What contacts' forces (3 #C) are at the points of each body.
std::vector<VectorXd> at_points(const Delassus& delassus, const VectorXd& forces);

/// Motions of the contacts, 3 #C, where the nodes move by A^-1 b: J A^-1 b from y = L^-1 b (solve_forward()).
VectorXd contact_motions(const Model& model, const Workspace::Data& workspace, const Delassus& delassus,
                         const VectorXd& y);

/// y += L^-1 J^T f, for the contacts' forces f (3 #C).
void add_forces(const Model& model, const Workspace::Data& workspace, const Delassus& delassus, const VectorXd& forces,
                VectorXd& y);

/// Calls visit(side) for each body that the contact pushes.
template <class Visit>
void for_each_side(const Delassus& delassus, int contact, const Visit& visit) {
  for (int s = delassus.first_side[contact]; s < delassus.first_side[contact + 1]; ++s) visit(delassus.sides[s]);
}

/// How a contact moves under another one's force [m/N]: a block of W.
Matrix3d compliance(const Delassus& delassus, int to, int from);

/// W as one matrix, 3 #C x 3 #C.
MatrixXd dense(const Delassus& delassus);

}  // namespace umax
