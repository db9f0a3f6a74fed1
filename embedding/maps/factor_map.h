// Factors on a value of a body, hex by hex: from numbers in space, or from the colours of a painted surface.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "core/base/triangle_mesh.h"
#include "core/model/lattice.h"
#include "core/model/obstacle.h"
#include "embedding/maps/vdb_grid.h"

namespace umax {

inline constexpr double least_factor = 0.01, largest_factor = 1000;  // [-] others are clamped

/// Factors that stand for 0 (black) and 1 (white); linear between, the ends beyond.
struct FactorRange {
  double black = 0.1, white = 1;
};

struct HexFactors {
  VectorXd factors;               // #E [-] 1 for hexes that the map does not reach
  int num_outside = 0;            // hexes that the map does not reach
  int num_clamped = 0;            // hexes whose value lay beyond the ends
  double least = 1, largest = 1;  // [-] value of a hex in the map, before it was clamped; a factor without a range
};

/// What a grid is in each hex: the mean over the part of the hex that is in the solid and in the grid's active voxels.
struct GridMeans {
  MatrixXd values;            // #E x num_columns, as of VdbGrid::sample()
  std::vector<char> reached;  // #E whether there is such a part
};

/// file_from_world: from the lattice's coordinates to the grid's. solid: signed distances in the lattice's coordinates;
/// null: hexes are all solid. Throws Error (bad_data) when the grid reaches no hex.
GridMeans means_of_grid(const VdbGrid& grid, const Eigen::Affine3d& file_from_world, const Lattice& lattice,
                        const SampledDistance* solid, Eigen::Index num_columns);

/// The means of a grid's numbers as factors; hexes that it does not reach are outside. Without a range the numbers are
/// the factors. Throws as means_of_grid() does.
HexFactors factors_from_grid(const VdbGrid& grid, const Eigen::Affine3d& file_from_world, const Lattice& lattice,
                             const SampledDistance* solid, const std::optional<FactorRange>& range);

/// Means, by area, of the luminance (Rec. 709) of the painted mesh's colours over its part in each hex. Hexes that only
/// the body's own surface touches are outside; those within, which no surface touches, take the mean of their
/// neighbours', layer by layer inwards. Throws Error (bad_data) for a mesh without colours, colours that are negative
/// or not finite, and paint that touches no hex.
HexFactors factors_from_paint(const TriangleMesh& painted, const TriangleMesh& surface, const Lattice& lattice,
                              const FactorRange& range);

struct HexDirections {
  Points directions;    // #E x 3 unit vectors in the lattice's coordinates
  int num_outside = 0;  // hexes without a direction in the grid
};

/// The principal direction of the mean of f f^T in each hex, so that opposite vectors mean the same; `uniform` (not
/// zero) for hexes that the grid does not reach, where it holds zero vectors only, and where no direction prevails.
/// Throws as means_of_grid() does.
HexDirections directions_from_grid(const VdbGrid& grid, const Eigen::Affine3d& file_from_world, const Lattice& lattice,
                                   const SampledDistance* solid, const Vector3d& uniform);

}  // namespace umax
