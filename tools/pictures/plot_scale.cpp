#include "tools/pictures/plot_scale.h"

#include <fmt/format.h>

#include <array>

#include "render/annotation/annotate.h"

namespace umax {
namespace {

std::string number_text(double value, int decimals) {
  const std::string text = fmt::format("{:.{}f}", std::abs(value), decimals);
  const bool is_zero = text.find_first_not_of("0.") == std::string::npos;
  return value < 0 && !is_zero ? "−" + text : text;
}

/// Finer than asked for where else there would be fewer than two ticks.
double axis_step(const PlotAxis& axis, double low, double high, int num_ticks) {
  double step = tick_step(high - low, num_ticks);
  for (; num_ticks < 100 && std::floor(high / step) - std::ceil(low / step) < 1; num_ticks *= 2)
    step = tick_step(high - low, num_ticks);
  return axis.whole_numbers ? std::max(1.0, step) : step;
}

void add_linear_ticks(Scale& scale, double step) {
  const double largest = std::max(std::abs(scale.low), std::abs(scale.high));
  const int power = int(std::floor(std::log10(largest) + 1e-9));
  if (power > 4 || power < -2) scale.exponent = int(std::floor(power / 3.0)) * 3;
  const double unit = std::pow(10.0, scale.exponent);
  const int decimals = std::max(0, -int(std::floor(std::log10(step / unit) + 1e-9)));
  for (double i = std::ceil(scale.low / step - 1e-6); i * step <= scale.high + 1e-6 * step; ++i)
    scale.ticks.push_back({i * step, number_text(i * step / unit, decimals)});
}

/// Powers of ten; over few of them also their multiples.
void add_logarithmic_ticks(Scale& scale) {
  const int first = int(std::floor(std::log10(scale.low) + 1e-9)), last = int(std::ceil(std::log10(scale.high) - 1e-9));
  const double decades = std::log10(scale.high) - std::log10(scale.low);
  const int stride = std::max(1, int(std::ceil(decades / 7)));
  for (int power = first; power <= last; ++power)
    for (int digit = 1; digit <= 9; ++digit) {
      const double value = digit * std::pow(10.0, power);
      if (value < scale.low * (1 - 1e-9) || value > scale.high * (1 + 1e-9)) continue;
      const bool has_label = digit == 1 ? (power - first) % stride == 0 : decades < 2 && (digit == 2 || digit == 5);
      if (!has_label && decades > 4) continue;
      const bool is_plain = power >= -3 && power <= 4;
      const std::string label = is_plain     ? fmt::format("{:g}", value)
                                : digit == 1 ? "10" + superscript(power)
                                             : fmt::format("{}·10{}", digit, superscript(power));
      scale.ticks.push_back({value, has_label ? label : ""});
    }
}

/// The next 1, 2 or 5 times a power of ten below or above a value.
double round_to_digit(double value, bool up) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  double below = power;
  for (const double factor : {1.0, 2.0, 5.0, 10.0}) {
    const double rounded = factor * power;
    if (up && rounded >= value * (1 - 1e-9)) return rounded;
    if (rounded <= value * (1 + 1e-9)) below = rounded;
  }
  return up ? 10 * power : below;
}

}  // namespace

bool is_shown(double value, bool logarithmic) {
  return std::abs(value) < 1e300 && (!logarithmic || value > 1e-300);
}

std::string superscript(int number) {
  static const std::array<const char*, 10> digits{"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
  std::string text;
  for (const char character : std::to_string(number))
    text += character == '-' ? "⁻" : digits[std::size_t(character - '0')];
  return text;
}

Scale make_scale(const PlotAxis& axis, double low, double high, double begin, double end, int num_ticks, bool rounded) {
  Scale scale{.logarithmic = axis.logarithmic, .begin = begin, .end = end};
  if (low > high) low = axis.logarithmic ? 1 : 0, high = axis.logarithmic ? 10 : 1;
  scale.low = axis.low.value_or(low);
  scale.high = axis.high.value_or(high);
  if (axis.logarithmic) {
    if (!axis.low) scale.low = round_to_digit(scale.low, false);
    if (!axis.high) scale.high = round_to_digit(scale.high, true);
    if (!(scale.high > scale.low)) scale.high = 10 * scale.low;
    add_logarithmic_ticks(scale);
    return scale;
  }
  // values that are all the same, or nearly, or on the wrong side of an end that is given
  if (!(scale.high - scale.low > std::max(1e-290, 1e-9 * std::max(std::abs(scale.low), std::abs(scale.high))))) {
    const bool is_zero = std::abs(scale.low) < 1e-290;
    const double half = is_zero ? 1 : 0.1 * std::abs(scale.low);
    if (!axis.low && !is_zero) scale.low -= half;
    scale.high = (axis.low ? *axis.low : scale.high) + half;
  }
  const double step = axis_step(axis, scale.low, scale.high, num_ticks);
  if (rounded && !axis.low) scale.low = std::floor(scale.low / step + 1e-9) * step;
  if (rounded && !axis.high) scale.high = std::ceil(scale.high / step - 1e-9) * step;
  add_linear_ticks(scale, step);
  return scale;
}

}  // namespace umax
