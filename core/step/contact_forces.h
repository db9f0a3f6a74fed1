// Forces of frictional contacts whose motions are W f + q (core/step/delassus.h), in the bodies' exact compliance.
//
// Projected Gauss-Seidel (core/contact/gauss_seidel.h) finds which contacts push, stick and slide, but creeps where they
// depend on each other: two thousand sweeps may not settle a pile. So every few sweeps go on from the mean of the last
// ones whose change is least (Anderson's acceleration: Walker and Ni 2011, Anderson acceleration for fixed-point
// iterations), and when little is left a semi-smooth Newton step on all that push is tried (Alart and Curnier 1991, A mixed
// formulation for frictional contact problems prone to Newton like solution methods), and kept if what is left falls. Where
// the sets are right, one step is the solution.
//
// Of many contacts most do not push: sweeps go over those that do, or have to (core/step/contact_part.h), and looks at all others
// now and then tell which have to join.
//
// Contacts that are nearly the same, as vertices of two hexes at one place, pass what they bear together to and fro, a little in
// each sweep, for ten thousand sweeps and more; Newton's matrix is nearly singular there. A proximal term (Rockafellar 1976,
// Monotone operators and the proximal point algorithm) holds forces near those of the iteration before,
//
// w + weight k (f - f_before)   in place of   w
//
// and ends that. What it hides of the motions is a share `weight` of what the iteration around it still changes, and vanishes
// where that ends.
//
// Natural map   n: f_n - max(0, f_n - (w_n + b) / k_n);   t: f_t - disc(f_t - w_t / k_t; mu f_n)
//
// f, w: force [N] and motion [m], n and t their normal and tangential parts;  b: bias [m];  k: compliance of the contact
// itself [m/N];  disc(y; r): nearest point of the disc |y| <= r
#pragma once

#include "core/step/delassus.h"

namespace umax {

/// Improves the forces in place. contacts: #C; q, forces: 3 #C. Sweeps count; Newton steps are not sweeps.
GaussSeidelResult solve_contacts(const Delassus& delassus, const std::vector<ContactRow>& contacts, const VectorXd& q,
                                 const GaussSeidelOptions& options, VectorXd& forces);

}  // namespace umax
