#include "embedding/surface/contact_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "embedding/surface/topology.h"
#include "embedding/surface/winding.h"
#include "embedding/surface/winding_sides.h"

namespace umax {
namespace {

constexpr double largest_cap = 0.02;       // [-] of the area of a part, holes that count as closed
constexpr double small_share = 1 / 256.0;  // [-] of the largest extent: longest edge of triangles that stay whole
constexpr int most_cuts = 64;              // of an edge
constexpr double most_pieces = 4e6;        // of all triangles: where they would be more, larger ones stay whole
constexpr double most_pieces_each = 16;    // on average, that may come to these

enum class Border : char { none, as_it_is, turned };

double area_of(const Points& positions, const Triangles& triangles, Eigen::Index t) {
  const Vector3d a = positions.row(triangles(t, 0)), b = positions.row(triangles(t, 1)),
                 c = positions.row(triangles(t, 2));
  return 0.5 * (b - a).cross(c - a).norm();
}

// the triangles, caps among them, of the parts that are closed but for small holes; none without area
Triangles closed_parts(const ClosedSurface& surface, Eigen::Index num_caps) {
  const Triangles& all = surface.triangles;
  std::vector<int> own(std::size_t(surface.positions.rows()));
  std::iota(own.begin(), own.end(), 0);
  const auto [part, num_parts] = triangle_components(all, own);
  std::vector<double> area(std::size_t(num_parts), 0), cap_area(area), triangle_area(std::size_t(all.rows()));
  for (Eigen::Index t = 0; t < all.rows(); ++t) {
    triangle_area[t] = area_of(surface.positions, all, t);
    (t < all.rows() - num_caps ? area : cap_area)[part[t]] += triangle_area[t];
  }
  Triangles closed(all.rows(), 3);
  Eigen::Index count = 0;
  for (Eigen::Index t = 0; t < all.rows(); ++t)
    if (triangle_area[t] > 0 && cap_area[part[t]] <= largest_cap * area[part[t]]) closed.row(count++) = all.row(t);
  closed.conservativeResize(count, 3);
  return closed;
}

// A triangle cut into n^2 equal ones. Corners are counted from one edge to the opposite corner, row by row.
class Cut {
 public:
  Cut(const Points& positions, const Triangles& triangles, int t, int n)
      : a_(positions.row(triangles(t, 0))),
        b_(positions.row(triangles(t, 1))),
        c_(positions.row(triangles(t, 2))),
        n_(n) {}

  int num_pieces() const { return n_ * n_; }
  int num_corners() const { return (n_ + 1) * (n_ + 2) / 2; }

  /// In row r, of 2 (n - r) - 1 pieces: those that point up are even, those that point down odd.
  Vector3i piece(int index) const {
    int row = 0;
    for (; index >= 2 * (n_ - row) - 1; ++row) index -= 2 * (n_ - row) - 1;
    const int k = index / 2;
    if (index % 2 == 0) return {corner_at(row, k), corner_at(row, k + 1), corner_at(row + 1, k)};
    return {corner_at(row, k + 1), corner_at(row + 1, k + 1), corner_at(row + 1, k)};
  }

  Vector3d corner(int index) const {
    int row = 0;
    for (; index > n_ - row; ++row) index -= n_ - row + 1;
    // weights that are the same bits from both triangles at an edge
    return double(n_ - row - index) / n_ * a_ + double(index) / n_ * b_ + double(row) / n_ * c_;
  }

  Vector3d centre(int index) const {
    const Vector3i corners = piece(index);
    return (corner(corners[0]) + corner(corners[1]) + corner(corners[2])) / 3;
  }

 private:
  int corner_at(int row, int k) const { return row * (n_ + 1) - row * (row - 1) / 2 + k; }

  Vector3d a_, b_, c_;
  int n_;
};

Border border_between(const WindingSides& sides) {
  if ((sides.behind != 0) == (sides.front != 0)) return Border::none;
  return sides.behind != 0 ? Border::as_it_is : Border::turned;
}

// What becomes of a triangle.
struct Decision {
  Border whole = Border::none;
  bool is_mixed = false;       // not all of it borders the outside alike
  std::vector<Border> pieces;  // of its cut; empty: it stays whole, or goes
};

class Triage {
 public:
  Triage(const Points& positions, const Triangles& triangles)
      : positions_(positions), triangles_(triangles), finder_(positions, triangles) {
    Eigen::AlignedBox3d box;
    for (const int corner : triangles.reshaped()) box.extend(positions.row(corner).transpose());
    small_ = small_share * box.sizes().maxCoeff();
    while (num_pieces() > most_pieces + most_pieces_each * double(triangles.rows())) small_ *= 2;
  }

  /// Into how many pieces an edge is cut, for the pieces to be small.
  int cuts(int t) const {
    const Vector3d a = positions_.row(triangles_(t, 0)), b = positions_.row(triangles_(t, 1)),
                   c = positions_.row(triangles_(t, 2));
    const double longest = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
    return int(std::clamp(std::ceil(longest / small_), 1.0, double(most_cuts)));
  }

  /// A look at up to four points of each triangle is enough where no part lies in another.
  std::vector<Decision> decide() const {
    std::vector<Decision> decisions(std::size_t(triangles_.rows()));
    const auto at_first = [&](int t) { return std::min(2, cuts(t)); };
    const auto where_parts_overlap = [&](int t) { return std::max(2, cuts(t)); };
    std::vector<int> looked_at(decisions.size());
    std::iota(looked_at.begin(), looked_at.end(), 0);
    decide_each(looked_at, at_first, decisions);
    const bool overlaps = std::any_of(decisions.begin(), decisions.end(), [](const Decision& decision) {
      return decision.whole == Border::none || decision.is_mixed;
    });
    if (!overlaps) return decisions;
    std::erase_if(looked_at, [&](int t) { return at_first(t) == where_parts_overlap(t); });
    decide_each(looked_at, where_parts_overlap, decisions);
    return decisions;
  }

 private:
  template <class CutsOf>
  void decide_each(const std::vector<int>& triangles, const CutsOf& cuts_of, std::vector<Decision>& decisions) const {
    constexpr std::size_t queries_at_once = 1 << 20;
    std::vector<SideQuery> queries;
    for (std::size_t i = 0; i < triangles.size();) {
      queries.clear();
      for (; i < triangles.size() && queries.size() < queries_at_once; ++i) {
        const Cut cut(positions_, triangles_, triangles[i], cuts_of(triangles[i]));
        for (int p = 0; p < cut.num_pieces(); ++p) queries.push_back({triangles[i], cut.centre(p)});
      }
      const std::vector<WindingSides> sides = finder_.sides_at(queries);
      for (std::size_t q = 0; q < queries.size();) {
        std::vector<Border> borders;
        const int of = queries[q].triangle;
        for (; q < queries.size() && queries[q].triangle == of; ++q) borders.push_back(border_between(sides[q]));
        decisions[std::size_t(of)] = decision_from(std::move(borders));
      }
    }
  }

  static Decision decision_from(std::vector<Border> borders) {
    constexpr std::size_t pieces_of_a_look = 4;
    Decision decision;
    for (const Border border : borders) {
      decision.is_mixed |= border != borders[0];
      if (decision.whole == Border::none) decision.whole = border;
    }
    if (decision.is_mixed && borders.size() > pieces_of_a_look) decision.pieces = std::move(borders);
    return decision;
  }

  // of all triangles, if they are cut
  double num_pieces() const {
    double count = 0;
    for (int t = 0; t < int(triangles_.rows()); ++t) count += double(cuts(t)) * cuts(t);
    return count;
  }

  const Points& positions_;
  const Triangles& triangles_;
  SideFinder finder_;
  double small_ = 0;  // [m]
};

// The triangles that are kept, and the corners of cuts as they come.
class Collector {
 public:
  explicit Collector(const Points& positions) : num_positions_(int(positions.rows())) {}

  void add(Vector3i triangle, Border border) {
    if (border == Border::none) return;
    if (border == Border::turned) std::swap(triangle[1], triangle[2]);
    triangles_.push_back(triangle);
  }

  void add(const Cut& cut, const std::vector<Border>& borders) {
    std::vector<int> vertices(std::size_t(cut.num_corners()), -1);
    for (int p = 0; p < cut.num_pieces(); ++p) {
      if (borders[std::size_t(p)] == Border::none) continue;
      Vector3i piece = cut.piece(p);
      for (int& corner : piece) {
        int& vertex = vertices[std::size_t(corner)];
        if (vertex < 0) {
          vertex = num_positions_ + int(added_.size());
          added_.push_back(cut.corner(corner));
        }
        corner = vertex;
      }
      add(piece, borders[std::size_t(p)]);
    }
  }

  TriangleMesh mesh(const Points& positions) const {
    TriangleMesh mesh;
    mesh.positions.resize(num_positions_ + Eigen::Index(added_.size()), 3);
    mesh.positions.topRows(num_positions_) = positions;
    for (std::size_t i = 0; i < added_.size(); ++i)
      mesh.positions.row(num_positions_ + Eigen::Index(i)) = added_[i].transpose();
    mesh.triangles.resize(Eigen::Index(triangles_.size()), 3);
    for (std::size_t t = 0; t < triangles_.size(); ++t) mesh.triangles.row(Eigen::Index(t)) = triangles_[t].transpose();
    return mesh;
  }

 private:
  int num_positions_ = 0;
  std::vector<Vector3d> added_;
  std::vector<Vector3i> triangles_;
};

}  // namespace

TriangleMesh contact_surface(const TriangleMesh& mesh) {
  if (mesh.num_triangles() == 0) return {};
  const ClosedSurface surface = close_surface(mesh);
  const Triangles closed = closed_parts(surface, surface.triangles.rows() - mesh.num_triangles());
  if (closed.rows() == 0) return {};
  const Triage triage(surface.positions, closed);
  const std::vector<Decision> decisions = triage.decide();
  Collector collector(surface.positions);
  for (int t = 0; t < int(closed.rows()); ++t) {
    const Decision& decision = decisions[std::size_t(t)];
    if (decision.pieces.empty())
      collector.add(closed.row(t).transpose(), decision.whole);
    else
      collector.add(Cut(surface.positions, closed, t, triage.cuts(t)), decision.pieces);
  }
  TriangleMesh border = collector.mesh(surface.positions);
  return border.num_triangles() > 0 ? border : TriangleMesh{};
}

}  // namespace umax
