// How far an iteration goes along its step: beyond a fifth of a cell of distortion, what is linear in it says little.
#pragma once

#include <vector>

#include "core/model/model.h"

namespace umax {

/// Largest node displacement [cells of its body] of a step of 3 #N [m].
double largest_move(const Model& model, const VectorXd& step);

/// max_step_fraction() of each body: #B.
VectorXd step_fractions(const Model& model, const VectorXd& step);

/// Share of a step of 3 #N [m] that moves no node of a hex by more than a fifth of a cell relative to the hex. However
/// far bodies move as a whole.
double max_step_fraction(const Model& model, const VectorXd& step);

/// Where a step of 3 #N [m] distorts a few hexes by more than that, moves their nodes towards the hexes' mean motions,
/// so that they do not hold up all others. Where it does so to many, they are left to max_step_fraction().
void limit_distortion(const Model& model, VectorXd& step);

/// A body's part of a step [m] and how much of it was taken; empty: there is none to compare the next one with.
struct TakenStep {
  VectorXd step;
  double factor = 1;
};

/// Empty where a step was cut to less than a half: the next one says nothing of the iteration then.
TakenStep taken_step(VectorXd step, double factor);

/// Of each body, with a step of 3 #N [m] and the shares of it that were taken (#B).
std::vector<TakenStep> taken_steps(const Model& model, const VectorXd& step, const VectorXd& shares);

/// Aitken's factor on a step along the one before: their ratio tells the true curvature along them. The multigrids'
/// matrix, which lacks what turning hexes do to forces, is too soft for such a motion under tension (the steps go to
/// and fro) and too stiff under compression (they creep, or slide into a buckled shape). 1 elsewhere, and where before
/// is empty.
double correction(const VectorXd& step, const TakenStep& before);

/// Does an iteration hardly get on, and undo in part what the one before did? Then hexes in a knot turn to and fro
/// between two places, and half a step lets them go. residuals: of all iterates so far.
bool goes_to_and_fro(const std::vector<double>& residuals, const VectorXd& step, const TakenStep& before);

/// Has an iteration not got on for long? Then whole large steps, each a little too long for what is linear in it, lead
/// from one buckled shape to another, and half steps into the nearest. Small ones leave a saddle: half of them would
/// stay there. residuals: of all iterates so far.
bool stagnates(const std::vector<double>& residuals);

/// How much of its part of a step of 3 #N [m] each body takes (#B): the bearable share; where that is nearly all of it and
/// forces are missing at the iterate (it is not balanced), corrected. before: of each body; empty: of none.
VectorXd step_factors(const Model& model, const VectorXd& step, double bearable, bool balanced,
                      const std::vector<double>& residuals, const std::vector<TakenStep>& before);

}  // namespace umax
