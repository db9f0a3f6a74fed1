// The simulation's data: what is simulated (Model, constant during a run) and how it is at an instant (State).
#pragma once

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/track.h"
#include "core/base/triangle_mesh.h"
#include "core/element/energy_parts.h"
#include "core/element/hexahedron.h"
#include "core/model/embedded_points.h"
#include "core/model/lattice.h"
#include "core/model/obstacle.h"
#include "core/model/rest_surface.h"

namespace umax {

class BodyPins;

enum class MassModel {
  mesh,     // a hex weighs its filled fraction, at least 5 %
  lattice,  // full cubes, as the paper
};
enum class LimitKind { none, hard, soft };
enum class LimitUnit { energy, density, stretch };  // [J per hex], [J/m^3 of full hex], [-] uniaxial strain

enum class LimitMeasure {
  mean,  // the energy integrated over the hex
  peak,  // V times the largest density at its quadrature points: bending cannot hide behind the mean
};

struct EnergyLimitOptions {
  LimitKind kind = LimitKind::none;
  LimitUnit unit = LimitUnit::stretch;
  Track<double> value{0.2};  // in the unit above; stretch as a fraction, 0.2 for 20 %
  LimitMeasure measure = LimitMeasure::mean;
};

/// Limits on parts of the energy, beside the one on the whole. Stretch: the energy that this uniaxial stretch puts into
/// the part.
struct PartLimitOptions {
  EnergyLimitOptions volumetric, deviatoric, fibre;
  Vector3d fibre_direction{1, 0, 0};  // in the rest shape as it is placed (world axes at time 0); of any length
};

struct MaterialOptions {
  Track<double> young{500e3};  // [Pa]
  double poisson = 0.3;        // [-]
  Track<double> density{500};  // [kg/m^3]
  MassModel mass = MassModel::mesh;
  Track<double> damping_mass{0};       // [1/s] Rayleigh alpha
  Track<double> damping_stiffness{0};  // [s] Rayleigh beta
};

/// The limit on a part of the energy, of a body's two fields.
EnergyLimitOptions& limit_on(EnergyLimitOptions& whole, PartLimitOptions& parts, EnergyPart part);
const EnergyLimitOptions& limit_on(const EnergyLimitOptions& whole, const PartLimitOptions& parts, EnergyPart part);

/// What a body collides with.
enum class ContactWith {
  all,        // bodies, obstacles and itself
  others,     // bodies and obstacles, not itself
  obstacles,  // these alone, as in the paper
  none,
};

/// An exception for two bodies, or for a body with itself (a == b).
struct BodyPair {
  int a = 0, b = 0;                // indices into Model::bodies
  bool touch = true;               // whatever their ContactWith says
  std::optional<double> friction;  // [-] none: the larger of the two
};

/// One body as the caller describes it to make_model().
struct Body {
  std::string name;
  Lattice lattice;  // placed in world coordinates at time 0
  MaterialOptions material;
  EnergyLimitOptions limit;  // on the whole energy
  PartLimitOptions part_limits;
  Track<double> friction{0.5};  // [-]
  ContactWith contact = ContactWith::all;
  Vector3d velocity{0, 0, 0};    // [m/s]
  Vector3d spin{0, 0, 0};        // [rad/s] about world axes through the centre of mass
  std::vector<int> fixed_nodes;  // lattice nodes that stay put
  VectorXd young_factor;         // #E [-] of each hex on Young's modulus; empty: 1
  VectorXd limit_factor;         // #E [-] of each hex on its limits, whatever their unit; empty: 1
  Points fibre_directions;       // #E x 3 as fibre_direction, of each hex; empty: that one everywhere
  EmbeddedPoints surface;        // in this lattice, contact candidates: the mesh's vertices, and points between them
  Points surface_rest;           // #P x 3 [m] their rest positions
  std::shared_ptr<const SampledDistance>
      rest_distance;  // of the rest surface; may be null: obstacle edges pass through
  // what others hit, if it is made larger by rest_scale, in the frame of which rest_pose is the place in the world at
  // time 0; null: they pass through it, and it touches them by its vertices alone
  std::shared_ptr<const RestSurface> rest_surface;
  double rest_scale = 1;
  Pose rest_pose;
  std::shared_ptr<const BodyPins> pins;  // what tells points of it where to go; null: nothing
};

/// One constraint 1 - U/U_max >= 0 on an energy of a hex.
struct HexLimit {
  int hex = 0;
  EnergyPart part = EnergyPart::whole;  // of which the body's limit gives U_max
  LimitKind kind = LimitKind::hard;     // never none
  int form = -1;                        // of U, in Model::limit_forms; -1: the whole energy that solver.energy names
};

/// All bodies in one system of nodes and hexes. Built by make_model() as it is at time 0; bring_to() alone changes it.
struct Model {
  struct BodyRange {
    std::string name;
    int first_node = 0, num_nodes = 0;
    int first_hex = 0, num_hexes = 0;
    int first_point = 0, num_points = 0;  // of its surface
    MaterialOptions material;
    EnergyLimitOptions limit;
    PartLimitOptions part_limits;
    double friction = 0;  // [-] at the time that the model is brought to, of friction_keys
    Track<double> friction_keys;
    ContactWith contact = ContactWith::all;
    double cell_size = 0;          // [m] smallest edge of its hexes: the unit of contact tolerances
    Cells cells;                   // #E of the body x 3 grid coordinates; empty: an irregular mesh
    Vector3d cell_edges{0, 0, 0};  // [m] of a regular lattice
    std::shared_ptr<const SampledDistance> rest_distance;
    std::shared_ptr<const RestSurface> rest_surface;
    double rest_scale = 1;
    Pose rest_pose;
    std::shared_ptr<const BodyPins> pins;
    std::shared_ptr<const EmbeddedPoints> surface;  // its points in its own hexes; bodies with equal ones share them
  };
  std::vector<BodyRange> bodies;
  std::vector<BodyPair> pairs;  // exceptions
  std::vector<Obstacle> obstacles;

  Points rest_positions;         // #N x 3 [m]
  Points initial_velocities;     // #N x 3 [m/s]
  VectorXd node_mass;            // #N [kg] lumped, at the time that the model is brought to
  VectorXd node_mass_t0;         // #N [kg] at time 0; empty: of parts of a model
  std::vector<char> node_fixed;  // #N
  Hexes hexes;                   // #E x 8
  VectorXi corners;              // 8 #E corners of hexes, 8 e + n, grouped by their node and ascending
  VectorXi corner_starts;        // #N + 1 those of a node: corner_starts[node] ... corner_starts[node + 1] - 1
  std::vector<HexShape> shapes;  // distinct element shapes
  VectorXi hex_shape;            // #E index into shapes
  VectorXi hex_body;             // #E index into bodies
  VectorXd young_factor;         // #E [-] on the body's Young's modulus
  VectorXd limit_factor;         // #E [-] on the body's limits
  Points fibre_directions;       // #E x 3 unit vectors
  std::vector<HexLimit> limits;  // #L grouped by hex; of a hex whole, volumetric, deviatoric, fibre, points ascending
  VectorXi limit_starts;         // #E + 1 the limits of hex e: limit_starts[e] ... limit_starts[e + 1] - 1
  std::vector<Matrix24d> limit_forms;  // K' of limited parts and points for unit Young's modulus, shared

  Eigen::Index num_nodes() const { return rest_positions.rows(); }
  Eigen::Index num_hexes() const { return hexes.rows(); }
  Eigen::Index num_points() const { return bodies.empty() ? 0 : bodies.back().first_point + bodies.back().num_points; }
};

/// The body that a hex belongs to.
inline const Model::BodyRange& body_of(const Model& model, Eigen::Index hex) {
  return model.bodies[std::size_t(model.hex_body[hex])];
}

/// Weights of a surface point of the body (a number of the model) on the nodes of its hex.
inline Eigen::Map<const Vector8d> surface_weights(const Model::BodyRange& body, Eigen::Index point) {
  return Eigen::Map<const Vector8d>(body.surface->weights.data() + 8 * (point - body.first_point));
}

/// The same of a point of any body, and the hex that it is in.
Eigen::Map<const Vector8d> surface_weights(const Model& model, Eigen::Index point);
int surface_hex(const Model& model, Eigen::Index point);

/// Throw Error (bad_data) that names the body or obstacle, the key and the value, unless all can be simulated.
void validate(const Body& body);
void validate(const Obstacle& obstacle);

/// Validates all of them. A body is given up as soon as it is in the model.
Model make_model(std::vector<Body> bodies, const std::vector<Obstacle>& obstacles,
                 const std::vector<BodyPair>& pairs = {});

/// Sets what keys decide from step to step to what it is at a time [s]: the mass of nodes (density), friction. Young's
/// modulus, limits and damping are asked for their time by steps themselves. True: something has changed, and workspaces
/// are to be made anew.
bool bring_to(Model& model, double time);

/// Whether bring_to() would ever change anything.
bool has_keyed_mass_or_friction(const Model& model);

/// The model of some of its bodies (ascending), whose nodes, hexes, points and limits follow each other as before.
Model part_of(const Model& model, const std::vector<int>& bodies);

/// May the surfaces of two bodies touch, or those of a body's own parts (a == b)? Both have to allow it, unless a pair
/// says otherwise.
bool may_touch(const Model& model, int a, int b);

/// Does the body touch obstacles?
bool touches_obstacles(const Model& model, int body);

/// Coulomb's coefficient [-] between two bodies.
double friction_between(const Model& model, int a, int b);

/// Young's modulus [Pa] of a hex at a time [s], and U_max [J] of a part of its energy (infinity: none).
double young_at(const Model& model, Eigen::Index hex, double time);
double energy_limit_at(const Model& model, Eigen::Index hex, double time, EnergyPart part = EnergyPart::whole);

enum class ContactKind {
  vertex,         // a vertex of a body's surface against the obstacle
  obstacle_edge,  // a point on the obstacle's edges against the body's surface
  surface,        // a vertex of a body's surface against a body's surface, its own perhaps
};

/// Which point it is that touches.
struct ContactPoint {
  ContactKind kind = ContactKind::vertex;
  int index = -1;  // of the bodies' surfaces, or among the obstacle's edge points
  bool operator==(const ContactPoint&) const = default;
};

/// Everything that influences later steps, and nothing else.
struct State {
  /// Impulse of a contact of the last step, for warm starts.
  struct ContactImpulse {
    ContactPoint point;
    int obstacle = -1;                    // -1: a body
    int hex = -1;                         // that held it
    int other_hex = -1;                   // of the body that was touched, if one was; it held the touched point
    Vector3d impulse = Vector3d::Zero();  // [N s] world
  };
  double time = 0;             // [s]
  long long step = 0;          // time steps done
  bool been_feasible = false;  // all hard limits have held once
  Points positions;            // #N x 3 [m]
  Points velocities;           // #N x 3 [m/s]
  VectorXd limit_multipliers;  // #L [J] force-level, >= 0: limit force = -(multiplier / U_max) dU/dx
  std::vector<ContactImpulse> contacts;
};

/// Rest shape with the bodies' initial velocity and spin, at time 0.
State rest_state(const Model& model);

/// The 8 node positions of a hex.
Matrix8x3d hex_nodes(const Model& model, const Points& positions, Eigen::Index hex);

}  // namespace umax
