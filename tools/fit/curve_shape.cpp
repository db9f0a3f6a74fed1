#include "tools/fit/curve_shape.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace umax {
namespace {

constexpr std::size_t fewest_above = 3;  // points above a knee

}  // namespace

Knee find_knee(const Measurements& data) {
  std::vector<const MeasuredPoint*> points;
  for (const MeasuredPoint& point : data.points) points.push_back(&point);
  std::stable_sort(points.begin(), points.end(), [](const MeasuredPoint* a, const MeasuredPoint* b) {
    return std::abs(a->stress) < std::abs(b->stress);
  });
  // sums over the points below the cut: a line through the origin; above it: a constant
  const auto count = points.size();
  std::vector<double> stress2(count + 1), product(count + 1), stretch2(count + 1), stretch1(count + 1);
  for (std::size_t i = 0; i < count; ++i) {
    const double stress = std::abs(points[i]->stress), stretch = points[i]->stretch * (points[i]->stress < 0 ? -1 : 1);
    stress2[i + 1] = stress2[i] + stress * stress;
    product[i + 1] = product[i] + stress * stretch;
    stretch2[i + 1] = stretch2[i] + stretch * stretch;
    stretch1[i + 1] = stretch1[i] + stretch;
  }
  Knee best{stress2[count] / product[count], 0};
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t cut = 1; cut + fewest_above <= count; ++cut) {
    if (!(stress2[cut] > 0 && product[cut] > 0)) continue;
    const double above = stretch1[count] - stretch1[cut], num_above = double(count - cut);
    const double error = stretch2[count] - product[cut] * product[cut] / stress2[cut] - above * above / num_above;
    if (error >= least || above <= 0) continue;
    least = error;
    best = {stress2[cut] / product[cut], above / num_above};
  }
  return best;
}

double compliance_left(const Measurements& data, const std::vector<char>& limited, double young) {
  double count = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (std::size_t i = 0; i < limited.size(); ++i) {
    if (!limited[i]) continue;
    const double stress = std::abs(data.points[i].stress) / young;
    const double stretch = data.points[i].stretch * (data.points[i].stress < 0 ? -1 : 1);
    ++count, x += stress, y += stretch, xx += stress * stress, xy += stress * stretch, yy += stretch * stretch;
  }
  const double sxx = xx - x * x / count, sxy = xy - x * y / count, syy = yy - y * y / count;
  if (!(sxx > 1e-12 * xx)) return 0;
  const double slope = sxy / sxx,
               error = count > 2 ? std::sqrt(std::max(0.0, syy - slope * sxy) / (count - 2) / sxx) : slope;
  return slope - 2 * error;
}

double residual_correlation(const Measurements& data, const std::vector<double>& stretch) {
  std::vector<std::size_t> order(stretch.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return data.points[a].stress < data.points[b].stress; });
  double products = 0, squares = 0, last = 0;
  for (const std::size_t i : order) {
    const double residual = data.points[i].stretch - stretch[i];
    products += last * residual;
    squares += residual * residual;
    last = residual;
  }
  return squares > 0 ? products / squares : 0;
}

}  // namespace umax
