// Contact of embedded surfaces with obstacles and with each other: which points touch, where, how deep.
//
// Unilateral constraint   g_i(x) >= 0
// Linearised              g_i + n . J_i dx >= 0
//
// g_i: signed distance of surface point i to what it touches at the step's end [m];  n: unit normal out of that [-]
// dx:  change of the node positions [m];  J_i: the 8 trilinear weights of the point in its hex, and less those of the
//      touched place in its own hex, where a body is touched [-]
//
// All surface vertices are candidates, and sample points along the obstacles' edges against the body's surface. For the
// solve they are clustered: the deepest one per hex and obstacle or touched body joins the working set, again and
// again, until none of the others lies deeper than the tolerance.
#pragma once

#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "core/contact/encounters.h"
#include "core/contact/vertex_clusters.h"
#include "core/model/model.h"

namespace umax {

/// A point of a body that rides in a hex, by the weights of its nodes.
struct Support {
  int hex = 0;
  Vector8d weights = Vector8d::Zero();
};

/// One contact constraint of the working set. Its nodes: core/contact/contact_support.h.
struct Contact {
  ContactPoint point;
  int obstacle = -1;                            // index into Model::obstacles; -1: a body is touched
  Support support;                              // where on the body that the point belongs to
  Support other;                                // what it touches, where a body is touched
  Vector3d normal = Vector3d::UnitY();          // world, out of what is touched
  double gap = 0;                               // [m] to be kept >= 0: distance and the depth still allowed
  double friction = 0;                          // [-]
  Vector3d obstacle_motion = Vector3d::Zero();  // [m] of the touched obstacle point during the step
  Vector3d position = Vector3d::Zero();         // [m] world, of the point against what is touched, when gap was taken
  Vector3d force = Vector3d::Zero();            // [N] world, on the body; the other body has it reversed
  Vector3d turn = Vector3d::Zero();  // [-] the last one of the normal out of a touched body between iterates,
  int turns_back = 0;                // and how often one undid that before it; often: the plane is kept

  bool between_bodies() const { return obstacle < 0; }
};

/// Where vertices were when they were last outside what they touch: at the last iterate, or before.
struct LastApart {
  LastApart() = default;
  /// All are outside at the positions, which are copied.
  explicit LastApart(const Points& positions) : latest(std::make_shared<const Points>(positions)) {}
  std::shared_ptr<const Points> latest;  // #N x 3 [m]
  // of the vertices of a hex in a body, if one was inside at the last iterate
  std::map<std::pair<int, int>, std::shared_ptr<const Points>> before;
  const Points& of(int hex, int body) const {
    const auto found = before.find({hex, body});
    return *(found == before.end() ? latest : found->second);
  }
};

/// A contact of the point, which the hex holds, in no place yet: update_contacts() gives it one.
Contact make_contact(const Model& model, const ContactPoint& point, int obstacle, int hex);

/// The same of a vertex against a body's surface, which the other hex belongs to. Its normal is zero until
/// place_surface_contacts() finds a place for it.
Contact make_surface_contact(const Model& model, int vertex, int hex, int other_hex);

/// Sample points along an obstacle's edges and corners, in its own frame.
struct EdgePoints {
  Points positions;                               // #P x 3 [m]
  Points normals;                                 // #P x 3 unit, mean of the faces that meet there
  std::shared_ptr<const EdgeRiders> riders = {};  // that these are, on triangles that move; null: they stay
};

/// What detection needs that never changes during a run.
struct ContactGeometry {
  std::vector<int> hex_starts;    // #E + 1 into hex_points
  std::vector<int> hex_points;    // surface vertices by hex
  std::vector<EdgePoints> edges;  // per obstacle
  TouchableBodies touchable;
  VertexClusters clusters;
};
ContactGeometry make_contact_geometry(const Model& model);

/// Of the model's part_of() some bodies (ascending), taken over from the model's own.
ContactGeometry part_of(const Model& model, const ContactGeometry& geometry, const Model& part,
                        const std::vector<int>& bodies);

/// The one way out of a body for all vertices of another that start the step deep inside it: each one's nearest might be
/// any.
struct WayOut {
  Vector3d direction{0, 1, 0};  // world, unit
  Eigen::AlignedBox3d where;    // around those that start deep
};

/// Bodies that start a step deep inside each other.
struct DeepStart {
  std::map<std::pair<int, int>, WayOut> ways_out;  // of the first body's vertices out of the second
  std::vector<Contact> contacts;                   // without force, of the deepest vertex of each hex
};

struct Clearances;

/// What detection needs during one step.
struct ContactStep {
  const Model* model = nullptr;
  const ContactGeometry* geometry = nullptr;
  std::vector<ObstacleAt> obstacles_t0, obstacles_t1;
  std::vector<double> deformations;  // per obstacle [m] that a vertex of it moves by itself in the step, at most
  Points positions_t0;               // #N x 3 [m]
  std::vector<std::vector<Eigen::AlignedBox3d>> boxes_t0;  // of the nodes of TouchableBodies::trees there
  std::vector<double> recovery;            // per body [m] by which a start in penetration is pushed out in this step
  bool surfaces_touch = true;              // false: obstacles alone are touched
  std::shared_ptr<Clearances> clearances;  // what searches remember; never decides what they find
  DeepStart deep_start;                    // of bodies
};
/// expected: #N x 3 [m] where nodes go if nothing holds them. gravity: [m/s^2] its size. known: what searches remember of
/// the step before, which this one goes on from; null: nothing.
ContactStep begin_contact_step(const Model& model, const ContactGeometry& geometry, const Points& positions_t0,
                               const Points& expected, double time_t0, double time_step, double gravity,
                               std::shared_ptr<Clearances> known = nullptr);

/// Depths [m] that a vertex may have at the end of the step, by how deep it was at the start.
struct AllowedDepth {
  double deep = 0;     // of a start beyond the tolerance: pushed out at a bounded speed, not at once
  double shallow = 0;  // of a start within it: left as it is, since pushing it out would do work, up to a share
};
/// recovery: [m] by which a vertex is pushed out in the step.
AllowedDepth allowed_depth(double depth, double tolerance, double recovery);

/// Depth [m] below which a vertex of the hex counts as touching, not as penetrating: a thousandth of its body's cells.
double tolerance_depth(const Model& model, int hex);

/// Refreshes gap, normal, weights and obstacle_motion of the contacts at the given positions.
void update_contacts(const ContactStep& step, const LastApart& apart, const Points& positions,
                     std::vector<Contact>& contacts);

/// Refreshes the gaps along the normals that the contacts have; normals and places stay.
void follow_contacts(const ContactStep& step, const Points& positions, std::vector<Contact>& contacts);
void follow(const Model& model, const Points& positions, Contact& contact);

/// Appends, for each hex and obstacle, the deepest point with gap < -share * tolerance_depth that is not yet in the set.
/// share 0: every touching hex. Returns the number added.
int add_obstacle_contacts(const ContactStep& step, const Points& positions, double share,
                          std::vector<Contact>& contacts);

/// The same for each hex and touched body, by surface_candidates().
int add_surface_contacts(const ContactStep& step, const LastApart& apart, const Points& positions, double share,
                         std::vector<Contact>& contacts);

/// Both.
int add_contacts(const ContactStep& step, const LastApart& apart, const Points& positions, double share,
                 std::vector<Contact>& contacts);

/// The hexes with surface vertices that are within a margin [cells of their body] of an obstacle at the step's end.
std::vector<int> hexes_near_obstacles(const ContactStep& step, const Points& positions, double margin);

/// The deepest surface vertex in an obstacle at the given time [m], 0 if none penetrates.
double max_penetration(const Model& model, const ContactGeometry& geometry, const Points& positions, double time);

/// Position of a point of a body.
Vector3d embedded_position(const Model& model, const Points& positions, const Support& support);

}  // namespace umax
