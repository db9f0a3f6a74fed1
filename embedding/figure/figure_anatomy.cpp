#include <Eigen/Geometry>
#include <algorithm>

#include "embedding/figure/figure_shape.h"

namespace umax::figure {
namespace {

Part make_part(bool mirrored, std::vector<Primitive> primitives) {
  Part part;
  part.mirrored = mirrored;
  part.primitives = std::move(primitives);
  Eigen::AlignedBox3d box;
  const auto add_ball = [&](const Vector3d& centre, double radius) {
    box.extend(Vector3d(centre.array() - radius));
    box.extend(Vector3d(centre.array() + radius));
  };
  for (const Primitive& primitive : part.primitives) {
    if (const auto* cone = std::get_if<RoundCone>(&primitive)) {
      add_ball(cone->a, cone->radius_a);
      add_ball(cone->b, cone->radius_b);
    } else {
      const auto& ellipsoid = std::get<Ellipsoid>(primitive);
      add_ball(ellipsoid.centre, ellipsoid.radii.maxCoeff());
    }
  }
  part.centre = box.center();
  part.radius = 0.5 * box.diagonal().norm();
  return part;
}

/// Axes of an ellipsoid whose second axis points along `up` and whose third points as nearly as may be along `front`.
Matrix3d axes_along(const Vector3d& up, const Vector3d& front) {
  const Vector3d y = up.normalized(), x = y.cross(front).normalized(), z = x.cross(y);
  Matrix3d axes;
  axes << x.transpose(), y.transpose(), z.transpose();
  return axes;
}

Part make_torso() {
  return make_part(false, {
                              Ellipsoid{{0, 0.66, 0.0}, {0.355, 0.34, 0.325}},
                              Ellipsoid{{0, 1.02, -0.02}, {0.27, 0.30, 0.235}, Matrix3d::Identity(), 0.20},
                              Ellipsoid{{0, 0.70, 0.10}, {0.27, 0.30, 0.27}, Matrix3d::Identity(), 0.12},  // belly
                          });
}

Part make_head() {
  return make_part(false,
                   {
                       Ellipsoid{{0, 1.47, 0.03}, {0.275, 0.235, 0.245}},
                       RoundCone{{0, 1.24, -0.01}, {0, 1.36, 0.0}, 0.17, 0.2, 0.06},                     // neck
                       RoundCone{{0, 1.39, 0.16}, {0, 1.355, 0.41}, 0.165, 0.080, 0.10},                 // snout
                       Ellipsoid{{0, 1.305, 0.20}, {0.115, 0.060, 0.17}, Matrix3d::Identity(), 0.05},    // jaw
                       Ellipsoid{{0.15, 1.375, 0.12}, {0.115, 0.10, 0.11}, Matrix3d::Identity(), 0.08},  // cheeks
                       Ellipsoid{{-0.15, 1.375, 0.12}, {0.115, 0.10, 0.11}, Matrix3d::Identity(), 0.08},
                   });
}

const Vector3d ear_up(0.58, 0.81, -0.10), ear_front(0.30, 0.05, 0.95);

Part make_ears() {
  return make_part(true,
                   {
                       RoundCone{{0.165, 1.57, -0.01}, {0.205, 1.64, -0.015}, 0.085, 0.065},
                       Ellipsoid{{0.285, 1.745, -0.03}, {0.120, 0.185, 0.048}, axes_along(ear_up, ear_front), 0.05},
                       RoundCone{{0.335, 1.81, -0.04}, {0.405, 1.905, -0.05}, 0.055, 0.018, 0.05},
                   });
}

Part make_ear_hollows() {
  return make_part(true, {Ellipsoid{{0.300, 1.745, 0.022}, {0.082, 0.155, 0.050}, axes_along(ear_up, ear_front)}});
}

Part make_legs() {
  return make_part(true,
                   {
                       RoundCone{{0.20, 0.54, 0.01}, {0.265, 0.33, 0.06}, 0.20, 0.155},
                       RoundCone{{0.265, 0.33, 0.06}, {0.275, 0.14, 0.01}, 0.155, 0.125, 0.05},
                       Ellipsoid{{0.29, 0.065, 0.07}, {0.145, 0.095, 0.225}, axes_along({0, 1, 0}, {0.22, 0, 1}), 0.06},
                   });
}

const Vector3d toe_tips[3] = {{0.225, 0.05, 0.275}, {0.325, 0.055, 0.285}, {0.41, 0.05, 0.225}};

Part make_toes() {
  std::vector<Primitive> toes;
  for (const Vector3d& tip : toe_tips) {
    const Vector3d root = tip - Vector3d(0.02, -0.01, 0.10);
    toes.push_back(RoundCone{root, tip, 0.060, 0.056, 0.015});
  }
  return make_part(true, toes);
}

Part make_arms() {
  return make_part(
      true,
      {
          RoundCone{{0.22, 1.12, -0.02}, {0.50, 1.00, 0.0}, 0.125, 0.100},
          RoundCone{{0.50, 1.00, 0.0}, {0.685, 1.12, 0.10}, 0.100, 0.092, 0.05},
          Ellipsoid{
              {0.735, 1.165, 0.13}, {0.105, 0.115, 0.085}, axes_along({0.75, 0.6, 0.3}, {-0.3, -0.1, 0.95}), 0.05},
      });
}

struct Finger {
  Vector3d root, tip;
};
const Finger fingers[4] = {{{0.76, 1.24, 0.14}, {0.745, 1.315, 0.175}},
                           {{0.80, 1.20, 0.14}, {0.835, 1.275, 0.18}},
                           {{0.81, 1.15, 0.15}, {0.885, 1.20, 0.195}},
                           {{0.69, 1.19, 0.18}, {0.655, 1.235, 0.24}}};

Part make_fingers() {
  std::vector<Primitive> cones;
  for (const Finger& finger : fingers) cones.push_back(RoundCone{finger.root, finger.tip, 0.048, 0.040, 0.015});
  return make_part(true, cones);
}

Part make_toe_claws() {
  std::vector<Primitive> claws;
  for (const Vector3d& tip : toe_tips) {
    claws.push_back(RoundCone{tip + Vector3d(0.004, 0.005, 0.03), tip + Vector3d(0.016, -0.025, 0.10), 0.036, 0.010});
  }
  return make_part(true, claws);
}

Part make_finger_claws() {
  std::vector<Primitive> claws;
  for (const Finger& finger : fingers) {
    const Vector3d along = (finger.tip - finger.root).normalized();
    claws.push_back(
        RoundCone{finger.tip + 0.018 * along, finger.tip + 0.075 * along + Vector3d(0, 0, 0.015), 0.027, 0.008});
  }
  return make_part(true, claws);
}

Part make_tail() {
  const Vector3d points[6] = {{0, 0.48, -0.22},  {0, 0.27, -0.45}, {0, 0.14, -0.66},
                              {0, 0.105, -0.86}, {0, 0.15, -1.03}, {0, 0.24, -1.13}};
  const double radii[6] = {0.185, 0.145, 0.105, 0.075, 0.05, 0.028};
  std::vector<Primitive> cones;
  for (int i = 0; i < 5; ++i) cones.push_back(RoundCone{points[i], points[i + 1], radii[i], radii[i + 1], 0.03});
  return make_part(false, cones);
}

}  // namespace

Anatomy make_anatomy() {
  Anatomy anatomy;
  anatomy.torso = make_torso();
  anatomy.dome = make_part(false, {Ellipsoid{{0, 0.83, -0.06}, {0.375, 0.46, 0.345}}});
  anatomy.shoulders = make_part(true, {Ellipsoid{{0.235, 1.11, -0.03}, {0.15, 0.145, 0.135}}});
  anatomy.hips = make_part(true, {Ellipsoid{{0.20, 0.56, -0.01}, {0.205, 0.21, 0.205}}});
  anatomy.legs = make_legs();
  anatomy.toes = make_toes();
  anatomy.toe_claws = make_toe_claws();
  anatomy.tail = make_tail();
  anatomy.head = make_head();
  anatomy.ears = make_ears();
  anatomy.ear_hollows = make_ear_hollows();
  anatomy.eyes = make_part(true, {Ellipsoid{{0.130, 1.475, 0.200}, {0.080, 0.088, 0.074}}});
  anatomy.eyelids = make_part(true, {Ellipsoid{{0.130, 1.477, 0.197}, {0.091, 0.098, 0.083}}});
  anatomy.nose = make_part(false, {Ellipsoid{{0, 1.392, 0.475}, {0.058, 0.044, 0.040}}});
  anatomy.nostrils = make_part(true, {Ellipsoid{{0.026, 1.385, 0.513}, {0.011, 0.009, 0.014}}});
  anatomy.arms = make_arms();
  anatomy.fingers = make_fingers();
  anatomy.finger_claws = make_finger_claws();
  return anatomy;
}

}  // namespace umax::figure
