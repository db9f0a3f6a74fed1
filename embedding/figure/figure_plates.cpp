#include <algorithm>
#include <cmath>

#include "embedding/figure/figure_shape.h"

namespace umax::figure {
namespace {

double fraction(double x) {
  return x - std::floor(x);
}

/// 1 in a seam at every whole number, of the given half width, falling smoothly to 0 at its shoulders.
double seam(double x, double half_width) {
  return 1 - smooth_step(0, half_width, std::abs(x - std::round(x)));
}

/// [-1, 1] a number that looks random, for a tile in a row.
double tile_tint(double row, double column) {
  return 2 * fraction(0.754877666 * row + 0.569840291 * column) - 1;
}

/// First-order distance to an ellipsoid with axes along the coordinates.
double oval(const Vector3d& p, const Vector3d& centre, const Vector3d& radii) {
  return distance_to(Ellipsoid{centre, radii}, p);
}

/// Rings that overlap like roof tiles: rising along x, falling at every whole number.
PlatePattern rings(double x, double step) {
  const double lap = fraction(x);
  PlatePattern pattern;
  pattern.groove = seam(x, 0.12);
  pattern.rim = smooth_step(0.68, 0.88, lap);
  pattern.height = step * (lap * smooth_step(1.0, 0.84, lap) - 0.2);
  return pattern;
}

}  // namespace

// The armour's rows are planes through an axis across the chest, as if the creature could roll up around it: seven
// movable bands between a shield for the shoulders and one for the hips.
PlatePattern shell_pattern(const Vector3d& p) {
  constexpr double row_angle = 0.072, last_band = 3.5;
  const double row = std::atan2(p.y() - 0.84, 0.50 - p.z()) / row_angle + 0.5, middle = row - 0.5;
  const double upper = smooth_step(last_band - 0.1, last_band + 0.1, middle);
  const double lower = smooth_step(-last_band + 0.1, -last_band - 0.1, middle);
  const double band = 1 - upper - lower;
  const double column = std::atan2(p.x(), 0.12 - p.z()) / 0.15 + 0.5 * (fraction(0.5 * std::floor(row)) > 0.25);
  const double lap = 1 - fraction(row);
  const double along = seam(column, 0.09), tile = std::max(seam(row, 0.11), along);
  PlatePattern pattern;
  pattern.groove = (1 - band) * tile + band * std::max(seam(row, 0.09), 0.5 * along);
  pattern.rim = band * smooth_step(0.70, 0.90, lap);
  pattern.tint = tile_tint(std::floor(row), (1 - band) * std::round(column + 0.5));
  const double overlap = 0.022 * lap * smooth_step(1.0, 0.84, lap) - 0.006 - 0.003 * along;
  pattern.height = band * overlap + upper * 0.018 + lower * 0.004 - (1 - band) * 0.008 * tile;
  return pattern;
}

double shell_distance(double shell_base, const Vector3d& p, double reach) {
  constexpr double thickest = 0.14;  // [m] of the plates and the dome on the back
  if (shell_base > reach + thickest) return far_away;
  // seen from the side: a curved front edge and a cut above the thighs that runs back to the tail; round shoulders
  const double below = p.y() - 0.80, slope = 1.7 * below;
  const double front = (p.z() - 0.075 + 0.85 * below * below) / std::sqrt(1 + slope * slope);
  const double bottom = 0.93 * (0.47 - p.y()) + 0.37 * (p.z() - 0.05);
  const double top = 0.55 * p.x() + 0.83 * p.y() - 1.125;
  const double region = smooth_max(smooth_max(front, bottom, 0.08), top, 0.10);
  if (region > reach + 0.01) return region;
  const double lip = 0.012 * std::exp(-region * region / (0.03 * 0.03));
  const double height = (p.y() - 0.86) / 0.30;
  const double dome = 0.05 * std::exp(-height * height) * smooth_step(0.05, -0.35, p.z());
  return smooth_max(shell_base - 0.040 - lip - dome - shell_pattern(p).height, region, 0.03);
}

PlatePattern cap_pattern(const Vector3d& p) {
  // rows around the head, from the brow to the nape
  const double row = std::atan2(p.z() + 0.02, p.y() - 1.40) / 0.285 + 0.35;
  const double column = p.x() / 0.085 + 0.5 * (fraction(0.5 * std::floor(row)) > 0.25);
  PlatePattern pattern;
  pattern.groove = std::max(seam(row, 0.11), seam(column, 0.11));
  pattern.height = 0.006 * (0.5 - pattern.groove);
  pattern.tint = tile_tint(std::floor(row), std::round(column + 0.5));
  return pattern;
}

double cap_distance(double head, const Vector3d& p, double reach) {
  if (head > reach + 0.05) return far_away;
  // an oval from the bridge of the snout over the forehead, and a second one down the nape
  static const Matrix3d axes = (Matrix3d() << 1, 0, 0, 0, 0.90, 0.436, 0, -0.436, 0.90).finished();
  const double crown = distance_to(Ellipsoid{{0, 1.67, 0.01}, {0.155, 0.20, 0.32}, axes}, p);
  const double nape = oval(p, {0, 1.55, -0.21}, {0.145, 0.20, 0.16});
  const double region = head_scale * smooth_min(crown, nape, 0.06);
  return region > reach + 0.02 ? region : smooth_max(head - 0.024 - cap_pattern(p).height, region, 0.02);
}

PlatePattern tail_pattern(const Vector3d& p) {
  const double along = -p.z() - 0.35 * p.y();  // [m] rings are closer towards the tip
  PlatePattern pattern = rings(9.0 * along + 3.0 * along * along, 0.018);
  const double fade = smooth_step(1.12, 1.0, along);
  pattern.groove *= fade;
  pattern.rim *= fade;
  pattern.height *= fade;
  return pattern;
}

PlatePattern guard_pattern(const PosedPoint& p) {
  static const Vector3d forearm = Vector3d(0.185, 0.12, 0.10).normalized();
  const bool on_arm = p.body.y() > 0.75;
  return on_arm ? rings(p.arm.dot(forearm) / 0.062 + 0.1, 0.016) : rings(-p.body.y() / 0.075 + 0.2, 0.016);
}

double guards_distance(double arms, double legs, const PosedPoint& p, double reach) {
  if (std::min(arms, legs) > reach + 0.05) return far_away;
  const double forearm = oval(p.arm, {0.640, 1.00, 0.00}, {0.15, 0.13, 0.12});
  const double knee = oval(p.body, {0.29, 0.31, 0.20}, {0.115, 0.145, 0.12});
  const double thickness = 0.016 + guard_pattern(p).height;
  return std::min(smooth_max(arms - thickness, forearm, 0.02), smooth_max(legs - thickness, knee, 0.02));
}

double mouth_line(const Vector3d& p) {
  const double height = 1.284 + 0.075 * smooth_step(0.42, 0.22, p.z()) + 0.03 * smooth_step(0.28, 0.20, p.z());
  const double offset = (p.y() - height) / 0.009;
  return std::abs(offset) > 4
             ? 0
             : std::exp(-offset * offset) * smooth_step(0.195, 0.225, p.z()) * smooth_step(1.2, 1.25, p.y());
}

double skin_relief(const Distances& d, const PosedPoint& p) {
  double relief = 0;
  if (d.head < 0.1) relief += 0.011 * mouth_line(p.head);
  if (d.torso < 0.1) {
    // shallow furrows across the belly
    const double front = smooth_step(0.10, 0.22, p.body.z()) * smooth_step(0.24, 0.12, p.body.x()) *
                         smooth_step(0.42, 0.5, p.body.y()) * smooth_step(1.16, 1.08, p.body.y());
    relief += 0.006 * front * seam(p.body.y() / 0.085, 0.16);
  }
  return relief;
}

}  // namespace umax::figure
