#include "tests/support/reference_mechanics.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>

namespace umax::test {
namespace {

/// f(x + i s) = f(x) + i s f'(x): a derivative that is exact to rounding, as nothing is subtracted.
constexpr double complex_step = 1e-30;

template <class S>
using Matrix3Of = Eigen::Matrix<S, 3, 3>;
template <class S>
using Vector3Of = Eigen::Matrix<S, 3, 1>;

/// Polar factor of a matrix with positive determinant: R <- (R + R^-T)/2, analytic in its entries.
template <class S>
Matrix3Of<S> rotation_of(const Matrix3Of<S>& G) {
  Matrix3Of<S> R = G;
  for (int iteration = 0; iteration < 12; ++iteration) R = (0.5 * (R + R.inverse().transpose())).eval();
  return R;
}

/// x and its displacement u seen from the hex's own frame.
template <class S>
struct ReferenceFrame {
  Matrix3Of<S> rotation;  // R
  NodesOf<S> local;       // y_j = R^T x_j about the centroid
  Matrix3Of<S> stretch;   // R^T G
};

template <class S>
ReferenceFrame<S> frame_of(const ReferenceHex& hex, const NodesOf<S>& x) {
  ReferenceFrame<S> frame;
  const NodesOf<S> centred = x.rowwise() - x.colwise().mean();
  const Matrix3Of<S> G = centred.transpose() * hex.centre_gradients.template cast<S>();
  frame.rotation = rotation_of(G);
  frame.local = centred * frame.rotation;
  frame.stretch = frame.rotation.transpose() * G;
  return frame;
}

template <class S>
Matrix3Of<S> strain_of(const ReferenceHex& hex, const NodesOf<S>& u, int q) {
  const Matrix3Of<S> gradient = u.transpose() * hex.gradients[q].template cast<S>();
  return 0.5 * (gradient + gradient.transpose());
}

// f.eps f
template <class S>
S along_fibre(const ReferenceHex& hex, const Matrix3Of<S>& strain) {
  S sum = 0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) sum += hex.fibre[i] * hex.fibre[k] * strain(i, k);
  return sum;
}

template <class S>
Matrix3Of<S> stress_of(const ReferenceHex& hex, const Matrix3Of<S>& strain) {
  const Matrix3d along = hex.fibre_young * hex.fibre * hex.fibre.transpose();
  return hex.lame_lambda * strain.trace() * Matrix3Of<S>::Identity() + 2 * hex.lame_mu * strain +
         along_fibre(hex, strain) * along.template cast<S>();
}

template <class S>
S energy_of(const ReferenceHex& hex, const NodesOf<S>& x) {
  const NodesOf<S> u = frame_of(hex, x).local - hex.rest.template cast<S>();
  S energy = 0;
  for (int q = 0; q < 8; ++q) {
    const Matrix3Of<S> strain = strain_of(hex, u, q);
    const S trace = strain.trace(), along = along_fibre(hex, strain);
    energy +=
        hex.weights[q] * (0.5 * hex.lame_lambda * trace * trace + hex.lame_mu * strain.cwiseProduct(strain).sum() +
                          0.5 * hex.fibre_young * along * along);
  }
  return energy;
}

template <class S>
NodesOf<S> force_of(const ReferenceHex& hex, const NodesOf<S>& x) {
  const ReferenceFrame<S> frame = frame_of(hex, x);
  const NodesOf<S> u = frame.local - hex.rest.template cast<S>();
  NodesOf<S> g = NodesOf<S>::Zero();
  for (int q = 0; q < 8; ++q) {
    const Matrix3Of<S> strain = strain_of(hex, u, q);
    g += hex.weights[q] * hex.gradients[q].template cast<S>() * stress_of(hex, strain);
  }
  const auto cross = [](const Vector3Of<S>& a, const Vector3Of<S>& b) {
    return Vector3Of<S>(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
  };
  Vector3Of<S> torque = Vector3Of<S>::Zero();
  for (int j = 0; j < 8; ++j)
    torque += cross(Vector3Of<S>(frame.local.row(j).transpose()), Vector3Of<S>(g.row(j).transpose()));
  const Matrix3Of<S> D = frame.stretch.trace() * Matrix3Of<S>::Identity() - frame.stretch;
  const Vector3Of<S> p = D.inverse() * torque;
  for (int j = 0; j < 8; ++j)
    g.row(j) -= cross(p, Vector3Of<S>(hex.centre_gradients.row(j).transpose().template cast<S>())).transpose();
  return g * frame.rotation.transpose();
}

}  // namespace

ReferenceHex make_reference_hex(const Matrix8x3d& nodes, double young, double poisson) {
  ReferenceHex hex;
  const Vector3d low = nodes.row(0), size = (nodes.row(7) - nodes.row(0)).transpose();
  const auto gradients_at = [&](const Vector3d& local) {  // local in [0, 1]^3
    NodesOf<double> h;
    for (int n = 0; n < 8; ++n) {
      Vector3d value, slope;
      for (int axis = 0; axis < 3; ++axis) {
        const bool far = n >> (2 - axis) & 1;
        value[axis] = far ? local[axis] : 1 - local[axis];
        slope[axis] = (far ? 1 : -1) / size[axis];
      }
      h.row(n) << slope[0] * value[1] * value[2], value[0] * slope[1] * value[2], value[0] * value[1] * slope[2];
    }
    return h;
  };
  const double offset = 0.5 / std::sqrt(3.0);
  for (int q = 0; q < 8; ++q)
    hex.gradients[q] = gradients_at(
        {0.5 + (q & 4 ? offset : -offset), 0.5 + (q & 2 ? offset : -offset), 0.5 + (q & 1 ? offset : -offset)});
  hex.centre_gradients = gradients_at(Vector3d::Constant(0.5));
  hex.rest = nodes.rowwise() - (low + 0.5 * size).transpose();
  hex.weights.fill(size.prod() / 8);
  hex.lame_lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  hex.lame_mu = young / (2 * (1 + poisson));
  return hex;
}

ReferenceHex limited_part(const ReferenceHex& hex, const Model& model, const HexLimit& limit, double young) {
  ReferenceHex part = hex;
  const Model::BodyRange& body = model.bodies[model.hex_body[limit.hex]];
  if (limit.part == EnergyPart::volumetric) part.lame_lambda += 2 * hex.lame_mu / 3, part.lame_mu = 0;
  if (limit.part == EnergyPart::deviatoric) part.lame_lambda = -2 * hex.lame_mu / 3;
  if (limit.part == EnergyPart::fibre) {
    part.lame_lambda = part.lame_mu = 0;
    part.fibre_young = young;
    part.fibre = model.fibre_directions.row(limit.hex).transpose();
  }
  if (limit_on(body.limit, body.part_limits, limit.part).measure == LimitMeasure::mean) return part;
  // the points of a part follow one another
  int first = model.limit_starts[limit.hex];
  while (model.limits[first].part != limit.part) ++first;
  part.weights.fill(0);
  part.weights[std::size_t(limit.form - model.limits[first].form)] = 8 * hex.weights[0];
  return part;
}

double reference_energy(const ReferenceHex& hex, const NodesOf<double>& x) {
  return energy_of(hex, x);
}

NodesOf<double> reference_force(const ReferenceHex& hex, const NodesOf<double>& x) {
  return force_of(hex, x);
}

NodesOf<double> reference_force_by_steps(const ReferenceHex& hex, const NodesOf<double>& x) {
  NodesOf<double> gradient;
  NodesOf<std::complex<double>> stepped = x.cast<std::complex<double>>();
  for (int j = 0; j < 8; ++j)
    for (int axis = 0; axis < 3; ++axis) {
      stepped(j, axis).imag(complex_step);
      gradient(j, axis) = energy_of(hex, stepped).imag() / complex_step;
      stepped(j, axis).imag(0);
    }
  return gradient;
}

Matrix24d reference_hessian(const ReferenceHex& hex, const NodesOf<double>& x) {
  Matrix24d hessian;
  NodesOf<std::complex<double>> stepped = x.cast<std::complex<double>>();
  for (int column = 0; column < 24; ++column) {
    stepped(column / 3, column % 3).imag(complex_step);
    const NodesOf<std::complex<double>> force = force_of(hex, stepped);
    for (int row = 0; row < 24; ++row) hessian(row, column) = force(row / 3, row % 3).imag() / complex_step;
    stepped(column / 3, column % 3).imag(0);
  }
  return hessian;
}

NodesOf<double> reference_warped_product(const ReferenceHex& hex, const NodesOf<double>& x, const NodesOf<double>& v) {
  const Matrix3d rotation = frame_of(hex, x).rotation;
  const NodesOf<double> local = v * rotation;
  NodesOf<double> g = NodesOf<double>::Zero();
  for (int q = 0; q < 8; ++q) {
    const Matrix3d strain = strain_of(hex, local, q);
    g += hex.weights[q] * hex.gradients[q] * stress_of(hex, strain);
  }
  return g * rotation.transpose();
}

ReferenceStep make_reference_step(const Model& model, const StepOptions& options, const State& before) {
  ReferenceStep step{&model, options.gravity, options.time_step, before, {}, {}, {}, {}, {}};
  const double end = before.time + options.time_step;
  step.limits.resize(Eigen::Index(model.limits.size()));
  step.alpha.resize(model.num_nodes());
  step.beta.resize(model.num_hexes());
  for (const Model::BodyRange& body : model.bodies)
    step.alpha.segment(body.first_node, body.num_nodes).setConstant(body.material.damping_mass.at(end));
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
    const Model::BodyRange& body = model.bodies[model.hex_body[e]];
    step.hexes.push_back(make_reference_hex(hex_nodes(model, model.rest_positions, e), body.material.young.at(end),
                                            body.material.poisson));
    step.beta[e] = body.material.damping_stiffness.at(end);
  }
  for (std::size_t l = 0; l < model.limits.size(); ++l) {
    const HexLimit& limit = model.limits[l];
    const double young = model.bodies[model.hex_body[limit.hex]].material.young.at(end);
    step.limited.push_back(limited_part(step.hexes[limit.hex], model, limit, young));
    step.limits[Eigen::Index(l)] = energy_limit_at(model, limit.hex, end, limit.part);
  }
  return step;
}

NodesOf<double> nodes_at(const ReferenceStep& step, const Points& positions, Eigen::Index e) {
  NodesOf<double> x;
  for (int n = 0; n < 8; ++n) x.row(n) = positions.row(step.model->hexes(e, n));
  return x;
}

void add_to_nodes(const ReferenceStep& step, Eigen::Index e, const NodesOf<double>& element, Points& sum) {
  for (int n = 0; n < 8; ++n) sum.row(step.model->hexes(e, n)) += element.row(n);
}

Points predictor(const ReferenceStep& step) {
  Points x = step.before.positions + step.h * step.before.velocities;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (step.model->node_fixed[i]) x.row(i) = step.before.positions.row(i);
  return x;
}

double incremental_potential(const ReferenceStep& step, const Points& x) {
  const Points moved = x - step.before.positions;
  double sum = 0;
  for (Eigen::Index i = 0; i < x.rows(); ++i) {
    if (step.model->node_fixed[i]) continue;
    const Vector3d d = moved.row(i), from_inertia = d - step.h * step.before.velocities.row(i).transpose();
    sum += step.model->node_mass[i] * (0.5 * from_inertia.squaredNorm() / (step.h * step.h) +
                                       0.5 * step.alpha[i] * d.squaredNorm() / step.h - step.gravity.dot(d));
  }
  for (Eigen::Index e = 0; e < step.model->num_hexes(); ++e) {
    sum += reference_energy(step.hexes[e], nodes_at(step, x, e));
    if (step.beta[e] == 0) continue;
    const NodesOf<double> d = nodes_at(step, moved, e);
    const NodesOf<double> force = reference_warped_product(step.hexes[e], nodes_at(step, step.before.positions, e), d);
    sum += 0.5 * step.beta[e] / step.h * force.cwiseProduct(d).sum();
  }
  return sum;
}

double kept_depth(const ReferenceStep& step, Eigen::Index point) {
  double y = 0;
  for (int n = 0; n < 8; ++n)
    y += surface_weights(*step.model, point)[n] *
         step.before.positions(step.model->hexes(surface_hex(*step.model, point), n), 1);
  return std::max(0.0, -y);
}

double ground_gap(const ReferenceStep& step, const Points& x, Eigen::Index point) {
  double y = 0;
  for (int n = 0; n < 8; ++n)
    y += surface_weights(*step.model, point)[n] * x(step.model->hexes(surface_hex(*step.model, point), n), 1);
  return y + kept_depth(step, point);
}

ReferenceForces reference_forces(const ReferenceStep& step, const State& after) {
  const Model& model = *step.model;
  const Points zero = Points::Zero(model.num_nodes(), 3);
  ReferenceForces forces{zero, zero, zero, zero, zero, zero};
  const Points velocities = (after.positions - step.before.positions) / step.h;
  for (Eigen::Index i = 0; i < model.num_nodes(); ++i) {
    forces.inertia.row(i) = model.node_mass[i] * (velocities.row(i) - step.before.velocities.row(i)) / step.h;
    forces.gravity.row(i) = -model.node_mass[i] * step.gravity.transpose();
    forces.damping.row(i) = model.node_mass[i] * step.alpha[i] * velocities.row(i);
  }
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
    const NodesOf<double> force = reference_force_by_steps(step.hexes[e], nodes_at(step, after.positions, e));
    add_to_nodes(step, e, force, forces.elastic);
    if (step.beta[e] > 0)
      add_to_nodes(step, e,
                   step.beta[e] * reference_warped_product(step.hexes[e], nodes_at(step, step.before.positions, e),
                                                           nodes_at(step, velocities, e)),
                   forces.damping);
  }
  for (Eigen::Index l = 0; l < step.limits.size(); ++l) {
    if (after.limit_multipliers[l] <= 0) continue;
    const int e = model.limits[l].hex;
    const NodesOf<double> force = reference_force_by_steps(step.limited[l], nodes_at(step, after.positions, e));
    add_to_nodes(step, e, after.limit_multipliers[l] / step.limits[l] * force, forces.limit);
  }
  for (const State::ContactImpulse& contact : after.contacts)
    for (int n = 0; n < 8; ++n)
      forces.contact.row(model.hexes(contact.hex, n)) -=
          surface_weights(model, contact.point.index)[n] * contact.impulse.transpose() / step.h;
  return forces;
}

}  // namespace umax::test
