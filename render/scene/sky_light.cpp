#include <algorithm>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/base/srgb.h"
#include "render/scene/daylight.h"
#include "render/scene/light.h"

namespace umax {
namespace {

constexpr float pi = 3.14159265f;

// A latitude-longitude table of radiance with bilinear look-up. Rows are even in height (equal solid angles per cell)
// or even in polar angle (pictures).
struct DirectionTable {
  enum class Rows { polar_angle, signed_root_of_height };
  Rows rows = Rows::polar_angle;
  int width = 0, height = 0;
  std::vector<Vector3f> values;

  Vector2f place(const Vector3f& direction) const {
    float u = fast_atan2(direction.x(), direction.z()) / (2 * pi);
    if (u < 0) u += 1;
    const float horizontal = std::sqrt(direction.x() * direction.x() + direction.z() * direction.z());
    if (rows == Rows::polar_angle) return {u, fast_atan2(horizontal, direction.y()) / pi};
    return {u, 0.5f - 0.5f * std::copysign(std::sqrt(std::min(std::abs(direction.y()), 1.0f)), direction.y())};
  }
  Vector3f direction(const Vector2f& place) const {
    float y = 0;
    if (rows == Rows::polar_angle) {
      y = sin_cos(pi * place.y()).cosine;
    } else {
      const float root = 1 - 2 * place.y();
      y = root * std::abs(root);
    }
    const float r = rows == Rows::polar_angle ? sin_cos(pi * place.y()).sine : std::sqrt(std::max(0.0f, 1 - y * y));
    const SinCos phi = sin_cos(2 * pi * place.x());
    return {r * phi.sine, y, r * phi.cosine};
  }
  Vector3f at(const Vector2f& place) const {
    const float x = place.x() * float(width) - 0.5f, y = place.y() * float(height) - 0.5f;
    const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
    const float fx = x - float(x0), fy = y - float(y0);
    const auto texel = [&](int i, int j) -> const Vector3f& {
      i = i < 0 ? i + width : i >= width ? i - width : i;
      return values[std::size_t(std::clamp(j, 0, height - 1)) * width + i];
    };
    return (1 - fy) * ((1 - fx) * texel(x0, y0) + fx * texel(x0 + 1, y0)) +
           fy * ((1 - fx) * texel(x0, y0 + 1) + fx * texel(x0 + 1, y0 + 1));
  }
};

DirectionTable table_of_picture(const EnvironmentMap& map) {
  if (!map.image || map.image->width < 2 || map.image->height < 2) {
    throw Error(Fault::bad_data, {.where = "sky",
                                  .what = "environment map without a picture",
                                  .value = "",
                                  .remedy = "name an .hdr or .exr file"});
  }
  DirectionTable table{
      .rows = DirectionTable::Rows::polar_angle, .width = map.image->width, .height = map.image->height, .values = {}};
  table.values.reserve(std::size_t(table.width) * table.height);
  for (int y = 0; y < table.height; ++y) {
    for (int x = 0; x < table.width; ++x) {
      const float* p = map.image->pixel(x, y);
      const Vector3f color = map.image->channels >= 3 ? Vector3f(p[0], p[1], p[2]) : Vector3f(p[0], p[0], p[0]);
      table.values.push_back(color.allFinite() ? Vector3f(map.intensity * color.cwiseMax(0.0f)) : Vector3f(0, 0, 0));
    }
  }
  return table;
}

DirectionTable table_of_daylight(const Daylight& daylight) {
  DirectionTable table{.rows = DirectionTable::Rows::signed_root_of_height, .width = 256, .height = 128, .values = {}};
  table.values.reserve(std::size_t(table.width) * table.height);
  for (int y = 0; y < table.height; ++y)
    for (int x = 0; x < table.width; ++x)
      table.values.push_back(daylight.dome(table.direction({(float(x) + 0.5f) / 256, (float(y) + 0.5f) / 128})));
  return table;
}

// Density to aim with: luminance above its mean, for the rest is served well by the surfaces' own choice
// [Karlik et al. 2019, "MIS compensation"]. Cells hold the largest value that look-ups inside them can meet.
TableDistribution distribution_of(const DirectionTable& table) {
  const int step = std::max(1, table.width / 512);
  const int width = (table.width + step - 1) / step, height = (table.height + step - 1) / step;
  std::vector<float> cells(std::size_t(width) * height, 0.0f);
  double sum = 0, weight = 0;
  for (int j = 0; j < height; ++j) {
    const float sine = std::sin(pi * (float(j) + 0.5f) / float(height));
    for (int i = 0; i < width; ++i) {
      float& cell = cells[std::size_t(j) * width + i];
      for (int y = j * step - 1; y <= (j + 1) * step; ++y) {
        for (int x = i * step - 1; x <= (i + 1) * step; ++x) {
          const Vector3f& v = table.values[std::size_t(std::clamp(y, 0, table.height - 1)) * table.width +
                                           (x + table.width) % table.width];
          cell = std::max(cell, luminance(v.x(), v.y(), v.z()));
        }
      }
      sum += double(cell * sine);
      weight += double(sine);
    }
  }
  const float mean = float(sum / weight);
  for (int j = 0; j < height; ++j) {
    const float sine = std::sin(pi * (float(j) + 0.5f) / float(height));
    for (int i = 0; i < width; ++i) {
      float& cell = cells[std::size_t(j) * width + i];
      cell = std::max(cell - mean, 0.0f) * sine;
    }
  }
  return TableDistribution(width, height, cells);
}

Vector3f rotate_about_y(const Vector3f& d, const SinCos& angle) {
  return {angle.cosine * d.x() + angle.sine * d.z(), d.y(), angle.cosine * d.z() - angle.sine * d.x()};
}

void check_color(const Vector3f& color, const char* key) {
  if (color.allFinite() && color.minCoeff() >= 0) return;
  throw Error(Fault::bad_data, {.where = std::string("sky.") + key,
                                .what = "is negative or not finite",
                                .value = "",
                                .remedy = "give three numbers from 0 upwards"});
}

}  // namespace

struct SkyLight::Data {
  Sky sky;
  std::optional<DirectionTable> table;  // daylight's dome, or the picture
  std::optional<Daylight> daylight;
  TableDistribution distribution;  // of a picture
  SinCos rotation{0, 1};           // of a picture, from its own frame to the world
};

SkyLight::SkyLight(const Sky& sky) : data_(std::make_unique<Data>()) {
  data_->sky = sky;
  if (const auto* constant = std::get_if<ConstantSky>(&sky)) check_color(constant->radiance, "radiance");
  if (const auto* gradient = std::get_if<GradientSky>(&sky)) {
    check_color(gradient->horizon, "horizon");
    check_color(gradient->zenith, "zenith");
    check_color(gradient->ground, "ground");
  }
  if (const auto* daylight = std::get_if<DaylightSky>(&sky)) {
    if (!daylight->sun_direction.allFinite() || !(daylight->sun_direction.norm() > 0)) {
      throw Error(Fault::bad_data, {.where = "sky.sun_direction",
                                    .what = "is no direction",
                                    .value = "",
                                    .remedy = "give a vector towards the sun"});
    }
    data_->daylight.emplace(*daylight);
    data_->table = table_of_daylight(*data_->daylight);
  }
  if (const auto* map = std::get_if<EnvironmentMap>(&sky)) {
    data_->table = table_of_picture(*map);
    data_->distribution = distribution_of(*data_->table);
    data_->rotation = sin_cos(map->rotation_degrees * pi / 180);
  }
}
SkyLight::~SkyLight() = default;
SkyLight::SkyLight(SkyLight&&) noexcept = default;

Vector3f SkyLight::radiance(const Vector3f& direction) const {
  if (const auto* constant = std::get_if<ConstantSky>(&data_->sky)) return constant->radiance;
  if (const auto* gradient = std::get_if<GradientSky>(&data_->sky)) {
    const float y = direction.y(), t = std::sqrt(std::min(std::abs(y), 1.0f)), blend = t * t * (3 - 2 * t);
    return gradient->horizon + blend * ((y >= 0 ? gradient->zenith : gradient->ground) - gradient->horizon);
  }
  if (data_->daylight) {
    const Daylight& d = *data_->daylight;
    const Vector3f dome = data_->table->at(data_->table->place(direction));
    return direction.dot(d.sun_direction) >= d.sun_cosine ? Vector3f(dome + d.sun_radiance) : dome;
  }
  const SinCos back{-data_->rotation.sine, data_->rotation.cosine};
  return data_->table->at(data_->table->place(rotate_about_y(direction, back)));
}

bool SkyLight::is_aimed() const {
  return data_->daylight ? data_->daylight->sun_radiance.maxCoeff() > 0 : !data_->distribution.empty();
}

LightSample SkyLight::sample(const Vector2f& u) const {
  LightSample sample;
  sample.distance = std::numeric_limits<float>::infinity();
  if (data_->daylight) {
    // uniform over the sun's disc
    const Daylight& d = *data_->daylight;
    const float rise = u.x() * (1 - d.sun_cosine), z = 1 - rise, r = std::sqrt(std::max(0.0f, rise * (2 - rise)));
    const SinCos phi = sin_cos(2 * pi * u.y());
    sample.direction = Frame(d.sun_direction).to_world({r * phi.cosine, r * phi.sine, z}).normalized();
    sample.density = 1 / d.sun_solid_angle;
    sample.radiance = data_->table->at(data_->table->place(sample.direction)) + d.sun_radiance;
    return sample;
  }
  float density = 0;
  const Vector2f place = data_->distribution.sample(u, density);
  sample.direction = rotate_about_y(data_->table->direction(place), data_->rotation);
  const float sine = sin_cos(pi * place.y()).sine;
  sample.density = sine > 1e-6f ? density / (2 * pi * pi * sine) : 0;
  sample.radiance = data_->table->at(place);
  return sample;
}

float SkyLight::density(const Vector3f& direction) const {
  if (data_->daylight) {
    const Daylight& d = *data_->daylight;
    return direction.dot(d.sun_direction) >= d.sun_cosine ? 1 / d.sun_solid_angle : 0.0f;
  }
  if (data_->distribution.empty()) return 0;
  const SinCos back{-data_->rotation.sine, data_->rotation.cosine};
  const Vector2f place = data_->table->place(rotate_about_y(direction, back));
  const float sine = sin_cos(pi * place.y()).sine;
  return sine > 1e-6f ? data_->distribution.density(place) / (2 * pi * pi * sine) : 0;
}

}  // namespace umax
