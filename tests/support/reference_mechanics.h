// One step's minimisation written a second time, from the definitions and with none of core's laws: what the exact
// method's results are held against. Box hexes, rotation at the centre, true energy, obstacles: the plane y = 0.
//
// U_e = sum_q w_q (lambda/2 tr(eps)^2 + mu eps:eps),  eps = sym(sum_j u_j h_j^T),  u_j = R^T x_j - X_j
// Phi(x) = sum_i m_i (|x_i - x0_i - h v0_i|^2 / 2h^2 + alpha |x_i - x0_i|^2 / 2h - g.x_i) + sum_e U_e + damping
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <vector>

#include "core/step.h"

namespace umax::test {

/// f(x + i s) = f(x) + i s f'(x): a derivative that is exact to rounding, as nothing is subtracted.
inline constexpr double complex_step = 1e-30;

template <class S>
using Matrix3Of = Eigen::Matrix<S, 3, 3>;
template <class S>
using Vector3Of = Eigen::Matrix<S, 3, 1>;
template <class S>
using NodesOf = Eigen::Matrix<S, 8, 3>;

/// Polar factor of a matrix with positive determinant: R <- (R + R^-T)/2, analytic in its entries.
template <class S>
Matrix3Of<S> reference_rotation(const Matrix3Of<S>& G) {
  Matrix3Of<S> R = G;
  for (int iteration = 0; iteration < 12; ++iteration) R = (0.5 * (R + R.inverse().transpose())).eval();
  return R;
}

/// A box-shaped hex at rest.
struct ReferenceHex {
  NodesOf<double> rest;                      // [m] about the centre
  std::array<NodesOf<double>, 8> gradients;  // [1/m] row j: dN_j/dX at each quadrature point
  NodesOf<double> centre_gradients;          // [1/m]
  double weight = 0;                         // [m^3] of a quadrature point
  double lame_lambda = 0, lame_mu = 0;       // [Pa]
};

inline ReferenceHex make_reference_hex(const Matrix8x3d& nodes, double young, double poisson) {
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
  hex.weight = size.prod() / 8;
  hex.lame_lambda = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
  hex.lame_mu = young / (2 * (1 + poisson));
  return hex;
}

/// x and its displacement u seen from the hex's own frame.
template <class S>
struct ReferenceFrame {
  Matrix3Of<S> rotation;  // R
  NodesOf<S> local;       // y_j = R^T x_j about the centroid
  Matrix3Of<S> stretch;   // R^T G
};
template <class S>
ReferenceFrame<S> reference_frame(const ReferenceHex& hex, const NodesOf<S>& x) {
  ReferenceFrame<S> frame;
  const NodesOf<S> centred = x.rowwise() - x.colwise().mean();
  const Matrix3Of<S> G = centred.transpose() * hex.centre_gradients.template cast<S>();
  frame.rotation = reference_rotation(G);
  frame.local = centred * frame.rotation;
  frame.stretch = frame.rotation.transpose() * G;
  return frame;
}

template <class S>
Matrix3Of<S> reference_strain(const ReferenceHex& hex, const NodesOf<S>& u, int q) {
  const Matrix3Of<S> gradient = u.transpose() * hex.gradients[q].template cast<S>();
  return 0.5 * (gradient + gradient.transpose());
}

/// U_e [J].
template <class S>
S reference_energy(const ReferenceHex& hex, const NodesOf<S>& x) {
  const NodesOf<S> u = reference_frame(hex, x).local - hex.rest.template cast<S>();
  S energy = 0;
  for (int q = 0; q < 8; ++q) {
    const Matrix3Of<S> strain = reference_strain(hex, u, q);
    const S trace = strain.trace();
    energy += hex.weight * (0.5 * hex.lame_lambda * trace * trace + hex.lame_mu * strain.cwiseProduct(strain).sum());
  }
  return energy;
}

/// dU_e/dx [N] by complex steps of the energy.
inline NodesOf<double> reference_force_by_steps(const ReferenceHex& hex, const NodesOf<double>& x) {
  NodesOf<double> gradient;
  NodesOf<std::complex<double>> stepped = x.cast<std::complex<double>>();
  for (int j = 0; j < 8; ++j)
    for (int axis = 0; axis < 3; ++axis) {
      stepped(j, axis).imag(complex_step);
      gradient(j, axis) = reference_energy(hex, stepped).imag() / complex_step;
      stepped(j, axis).imag(0);
    }
  return gradient;
}

/// dU_e/dx [N] by the chain rule, R^T dG = [w]S + dS for the turn w of R: so that a complex step of it is the Hessian.
template <class S>
NodesOf<S> reference_force(const ReferenceHex& hex, const NodesOf<S>& x) {
  const ReferenceFrame<S> frame = reference_frame(hex, x);
  const NodesOf<S> u = frame.local - hex.rest.template cast<S>();
  NodesOf<S> g = NodesOf<S>::Zero();
  for (int q = 0; q < 8; ++q) {
    const Matrix3Of<S> strain = reference_strain(hex, u, q);
    const Matrix3Of<S> stress = hex.lame_lambda * strain.trace() * Matrix3Of<S>::Identity() + 2 * hex.lame_mu * strain;
    g += hex.weight * hex.gradients[q].template cast<S>() * stress;
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

/// d2U_e/dx2 [N/m], node after node, by complex steps of the force.
inline Matrix24d reference_hessian(const ReferenceHex& hex, const NodesOf<double>& x) {
  Matrix24d hessian;
  NodesOf<std::complex<double>> stepped = x.cast<std::complex<double>>();
  for (int column = 0; column < 24; ++column) {
    stepped(column / 3, column % 3).imag(complex_step);
    const NodesOf<std::complex<double>> force = reference_force(hex, stepped);
    for (int row = 0; row < 24; ++row) hessian(row, column) = force(row / 3, row % 3).imag() / complex_step;
    stepped(column / 3, column % 3).imag(0);
  }
  return hessian;
}

/// R K(Y) R^T v at the positions x [N]: the warped stiffness that damps, as the linear force of the turned velocities.
inline NodesOf<double> reference_warped_product(const ReferenceHex& hex, const NodesOf<double>& x,
                                                const NodesOf<double>& v) {
  const Matrix3d rotation = reference_frame(hex, x).rotation;
  const NodesOf<double> local = v * rotation;
  NodesOf<double> g = NodesOf<double>::Zero();
  for (int q = 0; q < 8; ++q) {
    const Matrix3d strain = reference_strain(hex, local, q);
    const Matrix3d stress = hex.lame_lambda * strain.trace() * Matrix3d::Identity() + 2 * hex.lame_mu * strain;
    g += hex.weight * hex.gradients[q] * stress;
  }
  return g * rotation.transpose();
}

/// One backward Euler step from `before`, as a minimisation.
struct ReferenceStep {
  const Model* model = nullptr;
  Vector3d gravity{0, 0, 0};  // [m/s^2]
  double h = 0;               // [s]
  State before;
  std::vector<ReferenceHex> hexes;
  VectorXd limits;       // [J] infinity: none
  VectorXd alpha, beta;  // #N [1/s], #E [s] damping
};

inline ReferenceStep make_reference_step(const Model& model, const StepOptions& options, const State& before) {
  ReferenceStep step{&model, options.gravity, options.time_step, before, {}, {}, {}, {}};
  const double end = before.time + options.time_step;
  step.limits.resize(model.num_hexes());
  step.alpha.resize(model.num_nodes());
  step.beta.resize(model.num_hexes());
  for (const Model::BodyRange& body : model.bodies)
    step.alpha.segment(body.first_node, body.num_nodes).setConstant(body.material.damping_mass);
  for (Eigen::Index e = 0; e < model.num_hexes(); ++e) {
    const Model::BodyRange& body = model.bodies[model.hex_body[e]];
    step.hexes.push_back(make_reference_hex(hex_nodes(model, model.rest_positions, e), body.material.young.at(end),
                                            body.material.poisson));
    step.limits[e] = energy_limit_at(model, e, end);
    step.beta[e] = body.material.damping_stiffness;
  }
  return step;
}

inline NodesOf<double> nodes_at(const ReferenceStep& step, const Points& positions, Eigen::Index e) {
  NodesOf<double> x;
  for (int n = 0; n < 8; ++n) x.row(n) = positions.row(step.model->hexes(e, n));
  return x;
}

inline void add_to_nodes(const ReferenceStep& step, Eigen::Index e, const NodesOf<double>& element, Points& sum) {
  for (int n = 0; n < 8; ++n) sum.row(step.model->hexes(e, n)) += element.row(n);
}

/// x0 + h v0, fixed nodes at x0.
inline Points predictor(const ReferenceStep& step) {
  Points x = step.before.positions + step.h * step.before.velocities;
  for (Eigen::Index i = 0; i < x.rows(); ++i)
    if (step.model->node_fixed[i]) x.row(i) = step.before.positions.row(i);
  return x;
}

/// Phi(x) [J] without limits and contacts; gravity's part is taken against x0.
inline double incremental_potential(const ReferenceStep& step, const Points& x) {
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

/// Depth [m] that a surface point may keep: a start in the ground, within the contact tolerance, is left as it is.
inline double kept_depth(const ReferenceStep& step, Eigen::Index point) {
  double y = 0;
  for (int n = 0; n < 8; ++n)
    y += step.model->surface.weights(point, n) *
         step.before.positions(step.model->hexes(step.model->surface.hex[point], n), 1);
  return std::max(0.0, -y);
}

/// Height [m] of a surface point above the ground plane y = 0, and what it may keep.
inline double ground_gap(const ReferenceStep& step, const Points& x, Eigen::Index point) {
  double y = 0;
  for (int n = 0; n < 8; ++n)
    y += step.model->surface.weights(point, n) * x(step.model->hexes(step.model->surface.hex[point], n), 1);
  return y + kept_depth(step, point);
}

/// The forces on the nodes [N] whose sum vanishes at the end of a step; each as a gradient, so that of gravity points
/// up.
struct ReferenceForces {
  Points inertia, gravity, elastic, damping, limit, contact;
  Points sum() const { return inertia + gravity + elastic + damping + limit + contact; }
};

/// From the two states alone. Contacts with obstacles' edges are not known here.
inline ReferenceForces reference_forces(const ReferenceStep& step, const State& after) {
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
    if (after.limit_multipliers[e] > 0)
      add_to_nodes(step, e, after.limit_multipliers[e] / step.limits[e] * force, forces.limit);
  }
  for (const State::ContactImpulse& contact : after.contacts)
    for (int n = 0; n < 8; ++n)
      forces.contact.row(model.hexes(contact.hex, n)) -=
          model.surface.weights(contact.point, n) * contact.impulse.transpose() / step.h;
  return forces;
}

}  // namespace umax::test
