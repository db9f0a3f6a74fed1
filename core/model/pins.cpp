#include "core/model/pins.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <mutex>
#include <utility>

#include "core/element/rotation.h"

namespace umax {
namespace {

constexpr double independent = 1e-6;  // [-] of the largest pivot: what is smaller is rounding
constexpr double hardly = 1e-6;       // e above, in proportion
constexpr double weak = 1e-2;         // [-] of the largest singular value: below, x' counts for more than the points

Vector3d rest_of(const Pin& pin, Eigen::Index p) {
  return pin.rest.row(p).transpose();
}

// how far a motion that begins before time 0 has come, 0 ... 1
double come(const PinMotion& motion, double time) {
  if (time >= 0) return 1;
  if (!(motion.preroll > 0)) return 0;
  const double s = std::clamp(1 + time / motion.preroll, 0.0, 1.0);
  return s * s * (3 - 2 * s);
}

// a rigid motion of what is at rest
struct RigidMotion {
  Matrix3d rotation = Matrix3d::Identity();
  Vector3d from = Vector3d::Zero(), to = Vector3d::Zero();
  Vector3d of(const Vector3d& rest) const { return rotation * (rest - from) + to; }
};

// those of a pin's parts that fit its targets best
std::vector<RigidMotion> rigid_motions(const Pin& pin, const Points& targets) {
  const int count = pin.part.size() > 0 ? pin.part.maxCoeff() + 1 : 0;
  std::vector<RigidMotion> motions(std::size_t(count), RigidMotion{});
  std::vector<double> sizes(std::size_t(count), 0);
  for (Eigen::Index p = 0; p < targets.rows(); ++p) {
    RigidMotion& motion = motions[std::size_t(pin.part[p])];
    motion.from += rest_of(pin, p), motion.to += targets.row(p).transpose();
    sizes[std::size_t(pin.part[p])] += 1;
  }
  std::vector<Matrix3d> products(std::size_t(count), Matrix3d::Zero());
  for (std::size_t i = 0; i < motions.size(); ++i)
    if (sizes[i] > 0) motions[i].from /= sizes[i], motions[i].to /= sizes[i];
  for (Eigen::Index p = 0; p < targets.rows(); ++p) {
    const auto i = std::size_t(pin.part[p]);
    products[i] += (targets.row(p).transpose() - motions[i].to) * (rest_of(pin, p) - motions[i].from).transpose();
  }
  for (std::size_t i = 0; i < motions.size(); ++i) motions[i].rotation = polar_rotation(products[i]);
  return motions;
}

// keyframes are rigid motions themselves
std::vector<RigidMotion> motions_at(const Pin& pin, const Points& targets, double time) {
  if (pin.motion.mesh) return rigid_motions(pin, targets);
  const double share = come(pin.motion, time);
  RigidMotion motion{.rotation = rotation_from_degrees(share * pin.motion.rotation_degrees.at(time)),
                     .from = pin.motion.pivot,
                     .to = pin.motion.pivot + share * pin.motion.position.at(time)};
  return std::vector<RigidMotion>(std::size_t(pin.part.size() > 0 ? pin.part.maxCoeff() + 1 : 0), motion);
}

// a point of a pin in a hex
struct PinPoint {
  int pin = 0;
  Eigen::Index point = 0;
};

// the pin's part that most of a hex's points, or of a node's, belong to
struct PartOfPin {
  int pin = 0, part = 0;
  bool operator<(const PartOfPin& other) const { return std::pair(pin, part) < std::pair(other.pin, other.part); }
};

PartOfPin part_of(const std::vector<Pin>& pins, const PinPoint& at) {
  return {at.pin, pins[std::size_t(at.pin)].part[at.point]};
}

using Votes = std::map<PartOfPin, double>;
PartOfPin elected(const Votes& votes) {
  return std::max_element(votes.begin(), votes.end(), [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

// singular triples of a hex's conditions, those that rounding did not make
struct HexConditions {
  int hex = 0;
  std::vector<PinPoint> points;
  PartOfPin part;
  Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor> weights;     // #P x 8
  Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor> directions;  // rank x 8, v
  MatrixXd answers;                                                      // rank x #P: u / s, damped where s is small
};

Eigen::Index reduce(HexConditions& of) {
  Eigen::ColPivHouseholderQR<MatrixXd> qr(of.weights);
  qr.setThreshold(independent);
  const Eigen::Index rank = qr.rank();
  const MatrixXd R = qr.matrixR().topRows(rank).template triangularView<Eigen::Upper>();
  const MatrixXd independent_rows = R * qr.colsPermutation().transpose();  // rank x 8
  const Eigen::JacobiSVD<MatrixXd> svd(independent_rows, Eigen::ComputeThinU | Eigen::ComputeThinV);
  const MatrixXd thin_q = qr.householderQ() * MatrixXd::Identity(of.weights.rows(), rank);
  of.directions = svd.matrixV().transpose();
  const double small = weak * svd.singularValues()[0];
  VectorXd inverse = svd.singularValues();
  for (double& s : inverse) s = s / (s * s + small * small * (s < small ? 1 : 0));
  of.answers = inverse.asDiagonal() * svd.matrixU().transpose() * thin_q.transpose();
  return rank;
}

}  // namespace

Points targets_at(const Pin& pin, double time) {
  const double share = come(pin.motion, time);
  Points targets(pin.rest.rows(), 3);
  if (!pin.motion.mesh) {
    const Matrix3d rotation = rotation_from_degrees(share * pin.motion.rotation_degrees.at(time));
    const Vector3d to = pin.motion.pivot + share * pin.motion.position.at(time);
    for (Eigen::Index p = 0; p < targets.rows(); ++p)
      targets.row(p) = (rotation * (rest_of(pin, p) - pin.motion.pivot) + to).transpose();
    return targets;
  }
  const Points vertices = positions_at(*pin.motion.mesh, std::max(time, 0.0));
  for (Eigen::Index p = 0; p < targets.rows(); ++p) {
    Vector3d place = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) place += pin.motion.shares(p, k) * vertices.row(pin.motion.corners(p, k)).transpose();
    targets.row(p) = (rest_of(pin, p) + share * (place - rest_of(pin, p))).transpose();
  }
  return targets;
}

// What a set of active pins comes down to; made once.
struct PinConditions {
  std::vector<int> nodes;             // driven, ascending
  std::vector<PartOfPin> node_parts;  // of each
  std::vector<PinPoint> points;       // rows of W
  Eigen::SparseMatrix<double> W;      // #points x #nodes
  Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> normal;
  std::vector<HexConditions> partial;          // hexes that keep some freedom, ascending
  std::vector<std::pair<int, PinPoint>> soft;  // points on springs, by hex
};

struct BodyPins::Memory {
  std::mutex mutex;
  std::map<std::vector<char>, std::unique_ptr<const PinConditions>> made;
};

namespace {

// the exact points of the active pins by hex, and the others
void sort_points(const std::vector<Pin>& pins, const std::vector<char>& active,
                 std::map<int, std::vector<PinPoint>>& exact, std::vector<std::pair<int, PinPoint>>& soft) {
  for (int i = 0; i < int(pins.size()); ++i)
    for (Eigen::Index p = 0; active[std::size_t(i)] && p < pins[i].rest.rows(); ++p) {
      const int hex = pins[i].points.hex[p];
      if (std::isinf(pins[i].stiffness[p]))
        exact[hex].push_back({i, p});
      else
        soft.push_back({hex, {i, p}});
    }
  std::stable_sort(soft.begin(), soft.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
}

HexConditions conditions_in(const std::vector<Pin>& pins, int hex, const std::vector<PinPoint>& points) {
  HexConditions of;
  of.hex = hex;
  of.points = points;
  of.weights.resize(Eigen::Index(points.size()), 8);
  Votes votes;
  for (std::size_t k = 0; k < points.size(); ++k) {
    of.weights.row(Eigen::Index(k)) = pins[std::size_t(points[k].pin)].points.weights.row(points[k].point);
    votes[part_of(pins, points[k])] += 1;
  }
  of.part = elected(votes);
  return of;
}

void prepare_fit(const std::vector<Pin>& pins, const Hexes& hexes, PinConditions& conditions) {
  std::map<int, int> place;
  for (const int node : conditions.nodes) place.emplace(node, int(place.size()));
  std::vector<Eigen::Triplet<double>> entries;
  for (std::size_t i = 0; i < conditions.points.size(); ++i) {
    const EmbeddedPoints& points = pins[std::size_t(conditions.points[i].pin)].points;
    for (int n = 0; n < 8; ++n)
      entries.emplace_back(int(i), place.at(hexes(points.hex[conditions.points[i].point], n)),
                           points.weights(conditions.points[i].point, n));
  }
  conditions.W.resize(Eigen::Index(conditions.points.size()), Eigen::Index(conditions.nodes.size()));
  conditions.W.setFromTriplets(entries.begin(), entries.end());
  Eigen::SparseMatrix<double> normal = conditions.W.transpose() * conditions.W;
  const double damped = hardly * normal.diagonal().maxCoeff();
  for (Eigen::Index i = 0; i < normal.rows(); ++i) normal.coeffRef(i, i) += damped;
  conditions.normal.compute(normal);
}

std::unique_ptr<const PinConditions> make_conditions(const std::vector<Pin>& pins, const Hexes& hexes,
                                                     const std::vector<char>& active) {
  auto made = std::make_unique<PinConditions>();
  std::map<int, std::vector<PinPoint>> exact;
  sort_points(pins, active, exact, made->soft);
  std::map<int, Votes> driven;  // nodes
  for (const auto& [hex, points] : exact) {
    HexConditions of = conditions_in(pins, hex, points);
    if (reduce(of) < 8) {
      made->partial.push_back(std::move(of));
      continue;
    }
    made->points.insert(made->points.end(), points.begin(), points.end());
    for (std::size_t k = 0; k < points.size(); ++k)
      for (int n = 0; n < 8; ++n)
        driven[hexes(hex, n)][part_of(pins, points[k])] += std::abs(of.weights(Eigen::Index(k), n));
  }
  for (const auto& [node, votes] : driven) {
    made->nodes.push_back(node);
    made->node_parts.push_back(elected(votes));
  }
  if (!made->nodes.empty()) prepare_fit(pins, hexes, *made);
  return made;
}

// Where active pins' points, and the rigid motions that fit them, are at an instant.
struct Instant {
  std::vector<Points> targets;                    // of each pin
  std::vector<std::vector<RigidMotion>> motions;  // of each pin's parts
  Vector3d target(const PinPoint& at) const { return targets[std::size_t(at.pin)].row(at.point).transpose(); }
  Vector3d moved(const PartOfPin& part, const Vector3d& rest) const {
    return motions[std::size_t(part.pin)][std::size_t(part.part)].of(rest);
  }
};

Instant instant_at(const std::vector<Pin>& pins, const std::vector<char>& active, double time) {
  Instant instant{std::vector<Points>(pins.size()), std::vector<std::vector<RigidMotion>>(pins.size())};
  for (std::size_t i = 0; i < pins.size(); ++i) {
    if (!active[i]) continue;
    instant.targets[i] = targets_at(pins[i], time);
    instant.motions[i] = motions_at(pins[i], instant.targets[i], time);
  }
  return instant;
}

Points driven_places(const PinConditions& conditions, const Points& rest_nodes, const Instant& at) {
  Points places(Eigen::Index(conditions.nodes.size()), 3);
  for (std::size_t i = 0; i < conditions.nodes.size(); ++i)
    places.row(Eigen::Index(i)) =
        at.moved(conditions.node_parts[i], rest_nodes.row(conditions.nodes[i]).transpose()).transpose();
  if (conditions.nodes.empty()) return places;
  MatrixXd missed = -(conditions.W * MatrixXd(places));
  for (std::size_t i = 0; i < conditions.points.size(); ++i)
    missed.row(Eigen::Index(i)) += at.target(conditions.points[i]).transpose();
  places += conditions.normal.solve(MatrixXd(conditions.W.transpose() * missed));
  return places;
}

void append_springs(const HexConditions& of, const Points& rest_nodes, const Hexes& hexes, const Instant& at,
                    std::vector<PinSpring>& springs) {
  Matrix8x3d nodes;
  for (int n = 0; n < 8; ++n)
    nodes.row(n) = at.moved(of.part, rest_nodes.row(hexes(of.hex, n)).transpose()).transpose();
  Points missed = -(of.weights * nodes);
  for (std::size_t k = 0; k < of.points.size(); ++k) missed.row(Eigen::Index(k)) += at.target(of.points[k]).transpose();
  const Points places = of.directions * nodes + of.answers * missed;
  for (Eigen::Index i = 0; i < places.rows(); ++i)
    springs.push_back({.hex = of.hex,
                       .weights = of.directions.row(i).transpose(),
                       .place = places.row(i).transpose(),
                       .is_exact = true});
}

}  // namespace

BodyPins::BodyPins(std::vector<Pin> pins, const Points& rest_nodes, const Hexes& hexes)
    : pins_(std::move(pins)), rest_nodes_(rest_nodes), hexes_(hexes), memory_(std::make_shared<Memory>()) {}
BodyPins::BodyPins(const BodyPins& same, std::size_t pin, const Track<Vector3d>& position)
    : pins_(same.pins_), rest_nodes_(same.rest_nodes_), hexes_(same.hexes_), memory_(same.memory_) {
  pins_[pin].motion.position = position;
}
BodyPins::~BodyPins() = default;

std::vector<char> BodyPins::active_at(double time) const {
  std::vector<char> active;
  for (const Pin& pin : pins_) active.push_back(pin.is_active(time) ? 1 : 0);
  return active;
}

const PinConditions& BodyPins::conditions_of(const std::vector<char>& active) const {
  const std::lock_guard lock(memory_->mutex);
  std::unique_ptr<const PinConditions>& known = memory_->made[active];
  if (!known) known = make_conditions(pins_, hexes_, active);
  return *known;
}

std::vector<int> BodyPins::driven_nodes(const std::vector<char>& active) const {
  return conditions_of(active).nodes;
}

bool BodyPins::has_springs(const std::vector<char>& active) const {
  const PinConditions& conditions = conditions_of(active);
  return !conditions.partial.empty() || !conditions.soft.empty();
}

bool BodyPins::ever_has_springs() const {
  if (has_springs(std::vector<char>(pins_.size(), 1))) return true;
  for (std::size_t i = 0; i < pins_.size(); ++i) {
    std::vector<char> alone(pins_.size(), 0);
    alone[i] = 1;
    if (has_springs(alone)) return true;
  }
  return false;
}

PinDemands BodyPins::demands_at(double time) const {
  const std::vector<char> active = active_at(time);
  const PinConditions& conditions = conditions_of(active);
  const Instant at = instant_at(pins_, active, time);
  PinDemands demands{conditions.nodes, driven_places(conditions, rest_nodes_, at), {}};
  for (const HexConditions& of : conditions.partial) append_springs(of, rest_nodes_, hexes_, at, demands.springs);
  for (const auto& [hex, point] : conditions.soft) {
    const Pin& pin = pins_[std::size_t(point.pin)];
    demands.springs.push_back(
        {hex, pin.points.weights.row(point.point).transpose(), pin.stiffness[point.point], at.target(point), false});
  }
  std::stable_sort(demands.springs.begin(), demands.springs.end(),
                   [](const PinSpring& a, const PinSpring& b) { return a.hex < b.hex; });
  return demands;
}

double BodyPins::residual_at(double time) const {
  const std::vector<char> active = active_at(time);
  const PinConditions& conditions = conditions_of(active);
  if (conditions.nodes.empty()) return 0;
  const Instant at = instant_at(pins_, active, time);
  const MatrixXd places = conditions.W * MatrixXd(driven_places(conditions, rest_nodes_, at));
  double largest = 0;
  for (std::size_t i = 0; i < conditions.points.size(); ++i)
    largest = std::max(largest, (places.row(Eigen::Index(i)).transpose() - at.target(conditions.points[i])).norm());
  return largest;
}

}  // namespace umax
