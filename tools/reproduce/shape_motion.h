// Kinetic energy split by what it does to a body's shape: move it, squash it, or run through it as waves.
//
//   v           = v_rigid + v_affine + v_waves
//   1/2 <v, v>  = 1/2 <v_rigid, v_rigid> + 1/2 <v_affine, v_affine> + 1/2 <v_waves, v_waves>
//
//   v_rigid:  t + w x r
//   v_affine: t + L r (L: any 3 x 3) for what is left of v
//   v_waves:  what remains then
// Each is the least squares fit in the inner product of the lumped node masses m_i [kg]
//   <a, b> = sum_i m_i a_i . b_i
// so that the three are orthogonal in it.  v_i: node velocities [m/s];  r: place about the centre of mass [m]
#pragma once

#include "core/model/model.h"

namespace umax {

struct ShapeMotion {
  double rigid = 0;   // [J] translation and rotation
  double affine = 0;  // [J] stretch and shear that are the same everywhere: a squash
  double waves = 0;   // [J] all other changes of shape
  double total() const { return rigid + affine + waves; }
};

/// Of one of the model's bodies in a state. Fixed nodes count, as nodes that do not move. A body with no extent in some
/// direction has fewer affine motions; what they would have fitted is waves.
ShapeMotion shape_motion(const Model& model, const Model::BodyRange& body, const State& state);

}  // namespace umax
