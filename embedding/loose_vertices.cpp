#include "embedding/loose_vertices.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/parallel.h"
#include "core/element/rotation.h"
#include "embedding/embedding.h"

namespace umax {
namespace {

/// #E x 3 mean of each hex's nodes.
Points centres_of(const Hexes& hexes, const Points& nodes) {
  Points centres = Points::Zero(hexes.rows(), 3);
  for (Eigen::Index e = 0; e < hexes.rows(); ++e)
    for (int n = 0; n < 8; ++n) centres.row(e) += nodes.row(hexes(e, n)) / 8;
  return centres;
}

/// Hexes in the order of their centres along the axis on which these lie farthest apart.
class NearestHex {
 public:
  explicit NearestHex(const Points& centres) : centres_(centres), order_(std::size_t(centres.rows())) {
    (centres.colwise().maxCoeff() - centres.colwise().minCoeff()).maxCoeff(&axis_);
    std::iota(order_.begin(), order_.end(), 0);
    std::sort(order_.begin(), order_.end(),
              [&](int a, int b) { return key(a) < key(b) || (key(a) == key(b) && a < b); });
  }

  /// Goes away from the point in both directions, as long as what comes can be nearer than what was found.
  int find(const Vector3d& point) const {
    const auto above = std::lower_bound(order_.begin(), order_.end(), point[axis_],
                                        [&](int hex, double value) { return key(hex) < value; });
    Best best;
    for (auto hex = above; hex != order_.end() && may_be_nearer(*hex, point, best); ++hex) try_hex(*hex, point, best);
    for (auto hex = above; hex != order_.begin() && may_be_nearer(*(hex - 1), point, best); --hex)
      try_hex(*(hex - 1), point, best);
    return best.hex;
  }

 private:
  struct Best {
    int hex = std::numeric_limits<int>::max();
    double squared = std::numeric_limits<double>::infinity();
  };

  double key(int hex) const { return centres_(hex, axis_); }

  bool may_be_nearer(int hex, const Vector3d& point, const Best& best) const {
    const double along = key(hex) - point[axis_];
    return along * along <= best.squared;
  }

  void try_hex(int hex, const Vector3d& point, Best& best) const {
    const double squared = (centres_.row(hex).transpose() - point).squaredNorm();
    if (squared < best.squared || (squared == best.squared && hex < best.hex)) best = {hex, squared};
  }

  const Points& centres_;
  std::vector<int> order_;
  int axis_ = 0;
};

/// Derivative of the position by the hex's own coordinates, at its centre.
Matrix3d edges_at_centre(const Hexes& hexes, int hex, const Points& nodes) {
  Matrix3d edges = Matrix3d::Zero();
  for (int n = 0; n < 8; ++n)
    for (int axis = 0; axis < 3; ++axis)
      edges.col(axis) += ((n >> (2 - axis) & 1) ? 0.25 : -0.25) * nodes.row(hexes(hex, n)).transpose();
  return edges;
}

Points rows_of(const Points& points, const std::vector<Eigen::Index>& rows) {
  Points out(Eigen::Index(rows.size()), 3);
  for (std::size_t i = 0; i < rows.size(); ++i) out.row(Eigen::Index(i)) = points.row(rows[i]);
  return out;
}

}  // namespace

LooseVertices tie_loose_vertices(const Points& points, const Lattice& lattice) {
  LooseVertices loose;
  const VectorXi hex = find_hexes(points, lattice);
  for (Eigen::Index p = 0; p < points.rows(); ++p) (hex[p] >= 0 ? loose.inside : loose.outside).push_back(p);
  loose.embedded = embed_points(rows_of(points, loose.inside), lattice);

  const Points centres = centres_of(lattice.hexes, lattice.rest_positions);
  const NearestHex search(centres);
  loose.offset = rows_of(points, loose.outside);
  loose.nearest_hex.resize(loose.outside.size());
  parallel_blocks(loose.offset.rows(), 256, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      const int nearest = search.find(loose.offset.row(i));
      loose.nearest_hex[std::size_t(i)] = nearest;
      loose.offset.row(i) -= centres.row(nearest);
    }
  });
  return loose;
}

Points deform_loose_vertices(const LooseVertices& loose, const Lattice& lattice, const Points& nodes) {
  Points out(loose.size(), 3);
  const Points embedded = deform_points(loose.embedded, lattice.hexes, nodes);
  for (std::size_t i = 0; i < loose.inside.size(); ++i) out.row(loose.inside[i]) = embedded.row(Eigen::Index(i));

  parallel_blocks(loose.offset.rows(), 256, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      const int hex = loose.nearest_hex[std::size_t(i)];
      Vector3d centre = Vector3d::Zero();
      for (int n = 0; n < 8; ++n) centre += nodes.row(lattice.hexes(hex, n)).transpose() / 8;
      const Matrix3d gradient = edges_at_centre(lattice.hexes, hex, nodes) *
                                edges_at_centre(lattice.hexes, hex, lattice.rest_positions).inverse();
      const Vector3d at = centre + polar_rotation(gradient) * loose.offset.row(i).transpose();
      out.row(loose.outside[std::size_t(i)]) = at.transpose();
    }
  });
  return out;
}

}  // namespace umax
