// Co-rotational energy and gradient of several hexes at once, a hex in each lane of a vector: what corotate() and
// energy_with_gradient() find one by one (core/element/elastic_energy.h), in a tenth of the time.
#pragma once

#include "core/element/elastic_energy.h"
#include "core/element/hex_batch_kernel.h"

namespace umax {

/// x: 8 x 3 current positions [m] of the hex in a lane, 0 ... most_batched - 1.
void set_nodes(const Matrix8x3d& x, int lane, HexBatch& batch);

/// Fills the batch from the nodes of its first `count` hexes, at least one, all of one shape. What comes out for a hex does
/// not depend on its lane, nor on the others. A hex that is flat, collapsed or inverted is found by itself.
void evaluate(const HexShape& shape, RotationEstimate estimate, int count, HexBatch& batch);

/// warped_product() of the first `count` hexes, all of one shape, in place of their gradients: with the rotations that are
/// set, of the motions [m/s] that are set in place of their nodes.
void set_rotation(const Matrix3d& rotation, int lane, HexBatch& batch);
void multiply_warped(const HexShape& shape, int count, HexBatch& batch);

/// What evaluate() has found of the hex in a lane.
CorotatedHex corotated_hex(const HexBatch& batch, int lane);
Matrix3d rotation_of(const HexBatch& batch, int lane);

/// U [J] and dU/dx [N] of the hex in a lane, for its Young's modulus [Pa].
double elastic_energy(double young, const HexBatch& batch, int lane);
Vector24d elastic_gradient(double young, const HexBatch& batch, int lane);

}  // namespace umax
