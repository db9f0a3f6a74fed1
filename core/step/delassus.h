// The compliance of a growing set of contacts: W = J A^-1 J^T, how far each contact's force moves every other one. It
// is called the Delassus operator (Acary & Brogliato 2008, Numerical Methods for Nonsmooth Dynamical Systems).
#pragma once

#include <vector>

#include "core/contact/contact_support.h"
#include "core/linear/direct/sparse_cholesky.h"

namespace umax {

/// Three world directions per contact. W is the Delassus operator of the contacts so far.
struct Delassus {
  MatrixXd W;     // [m/N] 3 #C x 3 #C
  MatrixXd half;  // L^-1 J^T; rows: the unknowns eliminated last, while all contacts are there, or all unknowns
  bool in_last = true;
};

/// Adds those of the contacts that are not in it yet (they are the last ones), against the present factor.
void extend(const Model& model, const SparseCholesky& cholesky, const std::vector<Contact>& contacts,
            Delassus& delassus);

}  // namespace umax
