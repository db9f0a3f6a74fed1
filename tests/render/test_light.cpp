#include "render/scene/light.h"

#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

constexpr int num_samples = 4096;
constexpr double pi = std::numbers::pi;

Vector2f point(int s, int dimension = 0) {
  static const SampleSequence sequence(num_samples, 6);
  return sequence.point(unsigned(s), dimension, 0);
}

// form factor from a small horizontal patch to a parallel rectangle [0, x] x [0, y] at height z above it (textbook)
double corner_factor(double x, double y, double z) {
  const double a = x / z, b = y / z, ra = std::sqrt(1 + a * a), rb = std::sqrt(1 + b * b);
  return (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb)) / (2 * pi);
}

AreaLight ceiling(float x0, float z0, float x1, float z1, float height) {
  return {.corner = {x0, height, z0}, .edge_u = {x1 - x0, 0, 0}, .edge_v = {0, 0, z1 - z0}, .radiance = {2, 2, 2}};
}

// light on a horizontal patch at a point
double irradiance(const RectangleLights& lights, const Vector3f& from) {
  double sum = 0;
  for (int s = 0; s < num_samples; ++s) {
    const LightSample sample = lights.sample(from, point(s));
    if (sample.density > 0) sum += double(sample.radiance.x() * sample.direction.y() / sample.density);
  }
  return sum / num_samples;
}

}  // namespace

TEST_CASE("rectangles are sampled and met the same alone and many at once, to the last bit") {
  // near and far ones, some with their dark side to the point
  const RectangleLights lights(
      {{.corner = {-1, 2, -1}, .edge_u = {2, 0, 0}, .edge_v = {0, 0, 2}, .radiance = {5, 5, 5}},
       {.corner = {4, 6, 1}, .edge_u = {0, -1, 1}, .edge_v = {-1, 0, 0.3f}, .radiance = {9, 9, 9}},
       {.corner = {-3, 0, 0}, .edge_u = {0, 0, 1}, .edge_v = {0, 1, 0}, .radiance = {2, 1, 3}}});
  const SampleSequence sequence(128, 4);
  rows::DirectionRows from;
  rows::Row u, v;
  rows::RayRows rays;
  for (int i = 0; i < 128; ++i) {
    const Vector2f a = sequence.point(unsigned(i), 0, 0), b = sequence.point(unsigned(i), 1, 0);
    from.set(i, Vector3f(6 * a.x() - 3, 3 * a.y(), 4 * b.x() - 2));
    u[i] = sequence.point(unsigned(i), 2, 0).x(), v[i] = sequence.point(unsigned(i), 2, 0).y();
    const Vector3f up = cosine_hemisphere(b);
    rays.set(i, {.origin = from.vector(i), .direction = Vector3f(up.x(), up.z(), up.y()).normalized()});
  }
  LightRows samples;
  LightMetRows met;
  lights.sample(from, u, v, 128, samples);
  lights.meet(rays, 128, false, met);
  int num_met = 0;
  for (int i = 0; i < 128; ++i) {
    const LightSample alone = lights.sample(from.vector(i), {u[i], v[i]});
    CHECK(alone.density == samples.density[i]);
    if (alone.density > 0) CHECK(alone.direction == samples.direction.vector(i));
    if (alone.density > 0) CHECK(alone.distance == samples.distance[i]);
    const auto met_alone = lights.meet(rays.origin.vector(i), rays.direction.vector(i), rays.max_distance[i], false);
    CHECK(met_alone.light == met.light[i]);
    if (met_alone.light >= 0) CHECK(met_alone.distance == met.distance[i]);
    num_met += met.light[i] >= 0;
  }
  CHECK(num_met > 5);
}

TEST_CASE("a rectangle lights a patch as its form factor says, near and far") {
  const float height = GENERATE(0.05f, 0.5f, 3.0f, 40.0f);
  // edge_u x edge_v = (x, 0, 0) x (0, 0, z) points down
  const RectangleLights lights({ceiling(-1, -0.5f, 2, 1.5f, height)});
  const double h = double(height);
  const double factor =
      corner_factor(1, 0.5, h) + corner_factor(2, 0.5, h) + corner_factor(1, 1.5, h) + corner_factor(2, 1.5, h);
  CHECK(irradiance(lights, {0, 0, 0}) == Approx(2 * pi * factor).epsilon(0.004));
}

TEST_CASE("several lights add up, those that face away give nothing") {
  const AreaLight a = ceiling(-1, -1, 1, 1, 2), b = ceiling(3, -2, 4, 2, 5);
  AreaLight away = ceiling(-3, -3, 3, 3, 1);
  std::swap(away.edge_u, away.edge_v);
  const Vector3f from(0.3f, 0, 0.2f);
  const double alone = irradiance(RectangleLights({a}), from) + irradiance(RectangleLights({b}), from);
  CHECK(irradiance(RectangleLights({a, away, b}), from) == Approx(alone).epsilon(0.01));
  CHECK(irradiance(RectangleLights({away}), from) == 0);
}

TEST_CASE("a ray that meets a light knows the density of aiming there") {
  AreaLight skewed = ceiling(-1, -1, 1, 1, 3);
  skewed.edge_v = {1, 0, 2};
  const std::vector<AreaLight> variants[] = {{ceiling(-1, -1, 1, 1, 1)},
                                             {ceiling(-1, -1, 1, 1, 30)},
                                             {skewed},
                                             {ceiling(-1, -1, 1, 1, 1), ceiling(3, 0, 5, 1, 2)}};
  for (const auto& variant : variants) {
    const RectangleLights lights(variant);
    for (int s = 0; s < 64; ++s) {
      const Vector3f from(0.2f, 0, -0.4f);
      const LightSample sample = lights.sample(from, point(s));
      const auto met = lights.meet(from, sample.direction, 1e9f, false);
      REQUIRE(met.light >= 0);
      CHECK(met.distance == Approx(sample.distance).epsilon(1e-4));
      CHECK(lights.density(met, from, sample.direction) == Approx(sample.density).epsilon(1e-3));
    }
  }
}

TEST_CASE("lights are seen from their bright side only, and by the camera only if they say so") {
  AreaLight light = ceiling(-1, -1, 1, 1, 2);
  const RectangleLights hidden({light});
  light.visible = true;
  const RectangleLights visible({light});
  CHECK(hidden.meet({0, 0, 0}, {0, 1, 0}, 1e9f, true).light == -1);
  CHECK(visible.meet({0, 0, 0}, {0, 1, 0}, 1e9f, true).light == 0);
  CHECK(hidden.meet({0, 0, 0}, {0, 1, 0}, 1e9f, false).light == 0);
  CHECK(visible.meet({0, 4, 0}, {0, -1, 0}, 1e9f, true).light == -1);
  CHECK(visible.meet({0, 0, 0}, {0, 1, 0}, 1.9f, true).light == -1);
}

TEST_CASE("a light without area is refused") {
  AreaLight light;
  light.edge_v = 2 * light.edge_u;
  CHECK_THROWS_AS(RectangleLights({light}), Error);
}

TEST_CASE("aimed and free directions together find all the light of a picture of the sky") {
  // a dim sky with one bright window
  auto image = std::make_shared<Image>(64, 32);
  for (float& v : image->values) v = 0.2f;
  for (int y = 6; y < 9; ++y)
    for (int x = 40; x < 44; ++x)
      for (int c = 0; c < 3; ++c) image->pixel(x, y)[c] = 90;
  const SkyLight sky(EnvironmentMap{.image = image, .intensity = 1.5f, .rotation_degrees = 30});
  REQUIRE(sky.is_aimed());
  // reference: midpoints of a fine grid
  double total = 0;
  constexpr int rows = 1000, columns = 2000;
  for (int i = 0; i < rows; ++i) {
    const float y = 1 - 2 * (float(i) + 0.5f) / rows, r = std::sqrt(1 - y * y);
    for (int j = 0; j < columns; ++j) {
      const float phi = 6.2831853f * (float(j) + 0.5f) / columns;
      total += double(sky.radiance({r * std::cos(phi), y, r * std::sin(phi)}).x()) * 4 * pi / (rows * columns);
    }
  }
  double found = 0;
  const float free_density = float(1 / (4 * pi));
  for (int s = 0; s < num_samples; ++s) {
    const LightSample sample = sky.sample(point(s));
    CHECK(sky.density(sample.direction) == Approx(sample.density).epsilon(0.01));
    CHECK(sky.radiance(sample.direction).x() == Approx(sample.radiance.x()).epsilon(0.02));
    found += double(sample.radiance.x() / (sample.density + free_density)) / num_samples;
    const Vector2f u = point(s, 1);
    const float y = 1 - 2 * u.x(), r = std::sqrt(std::max(0.0f, 1 - y * y)), phi = 6.2831853f * u.y();
    const Vector3f free(r * std::cos(phi), y, r * std::sin(phi));
    found += double(sky.radiance(free).x() / (sky.density(free) + free_density)) / num_samples;
  }
  CHECK(found == Approx(total).epsilon(0.01));
}

TEST_CASE("a picture of the sky stands as its header says") {
  auto image = std::make_shared<Image>(8, 4);
  for (int c = 0; c < 3; ++c) {
    image->pixel(2, 1)[c] = image->pixel(1, 1)[c] = 1;  // u = 0.25
    image->pixel(2, 2)[c] = image->pixel(1, 2)[c] = 1;
  }
  const SkyLight sky(EnvironmentMap{.image = image});
  CHECK(sky.radiance({1, 0, 0}).x() == Approx(1).epsilon(1e-3));
  CHECK(sky.radiance({-1, 0, 0}).x() == Approx(0).margin(1e-4));
  CHECK(sky.radiance({0, 1, 0}).x() == Approx(0).margin(1e-4));
}

TEST_CASE("the sun's light does not depend on the size of its disc") {
  const auto irradiance_of = [](float size) {
    const SkyLight sky(DaylightSky{.sun_size_degrees = size});
    double sum = 0;
    for (int s = 0; s < num_samples; ++s) {
      const LightSample sample = sky.sample(point(s));
      sum += double(sample.radiance.y() / sample.density) / num_samples;
    }
    return sum;
  };
  CHECK(irradiance_of(0.53f) == Approx(irradiance_of(5)).epsilon(0.02));
  CHECK(irradiance_of(0.53f) > 1);
}

TEST_CASE("a clear sky is blue above, bright about the sun, and red in the evening") {
  const SkyLight noon(DaylightSky{.sun_direction = {0.3f, 0.9f, 0}});
  const Vector3f above = noon.radiance(Vector3f(-0.3f, 0.9f, 0).normalized());
  CHECK(above.z() > 1.3f * above.x());
  CHECK(noon.radiance(Vector3f(0.42f, 0.9f, 0).normalized()).y() > 1.5f * above.y());
  const Vector3f noon_sun = noon.sample({0.5f, 0.5f}).radiance;
  const Vector3f evening_sun = SkyLight(DaylightSky{.sun_direction = {1, 0.08f, 0}}).sample({0.5f, 0.5f}).radiance;
  CHECK(evening_sun.x() / evening_sun.z() > 1.5f * noon_sun.x() / noon_sun.z());
  CHECK(evening_sun.y() < 0.6f * noon_sun.y());
  CHECK_FALSE(SkyLight(DaylightSky{.sun_direction = {1, -0.3f, 0}}).is_aimed());
}

TEST_CASE("skies that make no light are refused") {
  CHECK_THROWS_AS(SkyLight(ConstantSky{{-1, 0, 0}}), Error);
  CHECK_THROWS_AS(SkyLight(DaylightSky{.sun_direction = {0, 0, 0}}), Error);
  CHECK_THROWS_AS(SkyLight(EnvironmentMap{}), Error);
}
