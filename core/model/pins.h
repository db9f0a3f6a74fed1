// Pins: points of a body that are told where to go, by keyframes or by a mesh that another program has animated.
//
// Exact points of a hex are conditions on its eight nodes,   W x = d,   reduced to an independent set by a QR
// decomposition with column pivoting, W P = Q R. Where they leave the hex no freedom (rank 8) its nodes are driven:
//
//   x = x' + (W^T W + e)^-1 W^T (d - W x')
//
// over all such hexes; where they leave some, each independent condition is held by a spring that is a million times
// stiffer than the hex, along the singular vectors v of R, towards   v.x' + u.(d - W x') / s.   A limit is harder than any
// spring: where it wins it is put aside (core/step/pinned_model.h).
//
// W: #P x 8 trilinear weights;  d: where the points go [m];  u, s, v: singular triples of W, s beyond rounding
// x': the rigid motion that fits the points best (of each connected part of an animated mesh), applied to the nodes at
//     rest [m]: exact where the motion is rigid, however thin the set of points is in the hex
// e: a millionth of the largest diagonal entry of W^T W: what points hardly say is left to x'
#pragma once

#include <Eigen/Geometry>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "core/base/track.h"
#include "core/model/embedded_points.h"
#include "core/model/mesh_motion.h"

namespace umax {

/// Where points go that are at X at rest: to R(t) (X - pivot) + pivot + position(t), or along with an animated mesh.
struct PinMotion {
  Track<Vector3d> position{Vector3d(0, 0, 0)};          // [m] by how much they are moved
  Track<Vector3d> rotation_degrees{Vector3d(0, 0, 0)};  // about world X, then Y, then Z
  Vector3d pivot{0, 0, 0};                              // [m] world
  std::shared_ptr<const MeshMotion> mesh = {};          // world [m]; null: keyframes
  Triangles corners;                                    // #P x 3 vertices of the mesh that a point rides on
  Points shares;                                        // #P x 3 [-] of these vertices in it
  double preroll = 0;                                   // [s] before time 0 in which it begins, from rest
};

struct Pin {
  std::string name;
  EmbeddedPoints points;  // #P in the body's hexes, counted from its first
  Points rest;            // #P x 3 [m] where they are at rest
  VectorXi part;          // #P which rigid motion describes a point best: the connected part of the mesh, from 0 on
  VectorXd stiffness;     // #P [N/m] of a spring; infinity: exact
  PinMotion motion;
  double from = -std::numeric_limits<double>::infinity(), until = std::numeric_limits<double>::infinity();  // [s]

  bool is_active(double time) const { return time >= from && time <= until; }
};

/// Where a pin's points go at a time [s]: #P x 3 [m].
Points targets_at(const Pin& pin, double time);

/// A condition on the nodes of a hex, weights.x = place, held by a spring.
struct PinSpring {
  int hex = 0;                          // of the body
  Vector8d weights = Vector8d::Zero();  // of its nodes
  double stiffness = 0;                 // [N/m] where it is not exact
  Vector3d place = Vector3d::Zero();    // [m]
  bool is_exact = false;                // of points that are to be where they are told, whatever it takes
};

/// What pins ask of a body at an instant.
struct PinDemands {
  std::vector<int> nodes;          // of the body, ascending: those that have no freedom left
  Points places;                   // of these [m]
  std::vector<PinSpring> springs;  // by hex, ascending
};

struct PinConditions;

/// The pins of one body.
class BodyPins {
 public:
  /// rest_nodes: #N x 3 [m]; hexes: #E x 8 of these, of the body alone.
  BodyPins(std::vector<Pin> pins, const Points& rest_nodes, const Hexes& hexes);
  /// The same, but that one of the pins is moved otherwise: what follows from where they hold is shared.
  BodyPins(const BodyPins& same, std::size_t pin, const Track<Vector3d>& position);
  ~BodyPins();

  const std::vector<Pin>& pins() const { return pins_; }

  /// Which pins are active at a time.
  std::vector<char> active_at(double time) const;

  /// The nodes that the active pins leave no freedom (ascending), and whether others are held by springs.
  std::vector<int> driven_nodes(const std::vector<char>& active) const;
  bool has_springs(const std::vector<char>& active) const;

  /// Whether springs hold nodes while all pins are active, or one of them alone.
  bool ever_has_springs() const;

  PinDemands demands_at(double time) const;

  /// The farthest that an exact point of a pin will be from where it should go [m] at a time, the body's springs being
  /// at rest; of the pins that are active then.
  double residual_at(double time) const;

 private:
  const PinConditions& conditions_of(const std::vector<char>& active) const;

  std::vector<Pin> pins_;
  Points rest_nodes_;
  Hexes hexes_;
  struct Memory;
  std::shared_ptr<Memory> memory_;
};

}  // namespace umax
