#include <algorithm>
#include <cmath>

#include "embedding/figure_shape.h"

namespace umax::figure {
namespace {

double fraction(double x) {
  return x - std::floor(x);
}

/// Distance from the nearest whole number, in units of one.
double from_seam(double x) {
  return std::abs(x - std::round(x));
}

/// 1 in a seam of the given half width, falling smoothly to 0 at its shoulders.
double seam(double x, double half_width) {
  return 1 - smooth_step(0, half_width, from_seam(x));
}

}  // namespace

// The armour's rows are planes through an axis across the chest, as if the creature could roll up around it.
PlatePattern shell_pattern(const Vector3d& p) {
  constexpr double row_angle = 0.088, first_band = -3.5, last_band = 3.5;  // rows of the movable bands
  const double row = std::atan2(p.y() - 0.86, 0.50 - p.z()) / row_angle + 0.5;
  const double lap = 1 - fraction(row);  // 0 at a row's upper edge, 1 at its lower edge
  const double middle = row - 0.5;
  const double band =
      smooth_step(first_band - 0.1, first_band + 0.1, middle) * smooth_step(last_band + 0.1, last_band - 0.1, middle);
  const double around = std::atan2(p.x(), 0.12 - p.z()) / 0.145 + 0.5 * fraction(0.5 * std::floor(row));
  PlatePattern pattern;
  const double across = seam(row, 0.10), along = seam(around, 0.09);
  const double tile_groove = std::max(across, along);
  pattern.groove =
      tile_groove * (1 - band) + band * std::max(seam(row, 0.09), 0.55 * along * smooth_step(0.15, 0.3, lap));
  pattern.rim = band * smooth_step(0.72, 0.92, lap);
  const double overlap = 0.020 * lap * smooth_step(1.0, 0.90, lap) - 0.006;
  pattern.height = band * (overlap - 0.003 * along) + (1 - band) * 0.007 * (0.6 - tile_groove);
  return pattern;
}

double shell_distance(double torso, const Vector3d& p) {
  if (torso > 1) return far_away;
  const double edge = 0.05 - 1.1 * (p.y() - 0.74) * (p.y() - 0.74);  // z of the shell's front edge
  const double slope = 2.2 * (p.y() - 0.74);
  const double region = (p.z() - edge) / std::sqrt(1 + slope * slope);
  const double lip = 0.014 * std::exp(-region * region / (0.03 * 0.03));
  return smooth_max(torso - 0.048 - lip - shell_pattern(p).height, region, 0.03);
}

PlatePattern cap_pattern(const Vector3d& p) {
  const double row = (p.z() + 0.35 * p.y()) / 0.075;
  const double across = p.x() / 0.085 + 0.5 * fraction(0.5 * std::floor(row)) * 2;
  PlatePattern pattern;
  pattern.groove = std::max(seam(row, 0.11), seam(across, 0.11));
  pattern.height = 0.006 * (0.5 - pattern.groove);
  return pattern;
}

double cap_distance(double head, const Vector3d& p) {
  if (head > 1) return far_away;
  const Eigen::Array3d radii(0.165, 0.20, 0.30);
  const Eigen::Array3d scaled = (p - Vector3d(0, 1.68, -0.02)).array() / radii;
  const double level = scaled.matrix().norm(), slope = (scaled / radii).matrix().norm();
  const double region = slope < 1e-9 ? -0.16 : level * (level - 1) / slope;
  return smooth_max(head - 0.022 - cap_pattern(p).height, region, 0.02);
}

PlatePattern tail_pattern(const Vector3d& p) {
  // rings along the tail, closer towards the tip
  const double along = -p.z() - 0.35 * p.y();
  const double ring = 9.0 * along + 3.0 * along * along;
  const double lap = fraction(ring);
  const double fade = smooth_step(0.16, 0.30, along) * smooth_step(1.12, 1.0, along);
  PlatePattern pattern;
  pattern.groove = fade * seam(ring, 0.12);
  pattern.rim = fade * smooth_step(0.7, 0.9, lap);
  pattern.height = fade * (0.016 * lap * smooth_step(1.0, 0.88, lap) - 0.003);
  return pattern;
}

double mouth_line(const Vector3d& p) {
  const double height = 1.318 + 0.050 * smooth_step(0.34, 0.16, p.z()) - 0.012 * smooth_step(0.30, 0.50, p.z());
  const double offset = (p.y() - height) / 0.010;
  return std::exp(-offset * offset) * smooth_step(0.13, 0.18, p.z()) * smooth_step(1.2, 1.25, p.y());
}

double skin_relief(const Distances& d, const Vector3d& p) {
  double relief = 0;
  if (d.head < 0.1) relief += 0.011 * mouth_line(p);
  // belly bands: shallow furrows across the front of the torso
  if (d.torso < 0.1) {
    const double front = smooth_step(0.10, 0.22, p.z()) * smooth_step(0.24, 0.12, p.x()) *
                         smooth_step(0.42, 0.5, p.y()) * smooth_step(1.16, 1.08, p.y());
    relief += 0.006 * front * seam(p.y() / 0.085, 0.16);
  }
  return relief;
}

}  // namespace umax::figure
