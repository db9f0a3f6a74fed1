#include "render/trace/bsdf.h"

#include <cmath>

#include "core/base/error.h"
#include "render/scene/sampling.h"
#include "tests/support/catch.h"

using namespace umax;

namespace {

constexpr int num_samples = 8192;

Vector3f direction_at(float cosine) {
  return {std::sqrt(1 - cosine * cosine), 0, cosine};
}

// light that comes back from a surface in surroundings of radiance 1
Eigen::Vector3d reflected_by_sampling(const Bsdf& bsdf) {
  const SampleSequence sequence(num_samples, 4);
  Eigen::Vector3d sum(0, 0, 0);
  for (int s = 0; s < num_samples; ++s)
    sum += sample_bsdf(bsdf, sequence.point(unsigned(s), 0, 0)).weight.cast<double>();
  return sum / num_samples;
}

struct Integrals {
  Eigen::Vector3d value{0, 0, 0};
  double density = 0;
};
Integrals integrate_evaluation(const Bsdf& bsdf) {
  // midpoints of a fine grid over the hemisphere
  constexpr int rows = 400, columns = 800;
  Integrals sum;
  for (int i = 0; i < rows; ++i) {
    for (int j = 0; j < columns; ++j) {
      const float z = (float(i) + 0.5f) / rows, r = std::sqrt(1 - z * z),
                  phi = 6.2831853f * (float(j) + 0.5f) / columns;
      const BsdfValue value = evaluate_bsdf(bsdf, {r * std::cos(phi), r * std::sin(phi), z});
      sum.value += value.value.cast<double>() * (6.283185307 / (rows * columns));
      sum.density += double(value.density) * (6.283185307 / (rows * columns));
    }
  }
  return sum;
}

}  // namespace

TEST_CASE("a white surface in a white furnace is white for every look") {
  Look look;
  look.roughness = GENERATE(0.0f, 0.15f, 0.5f, 1.0f);
  look.metallic = GENERATE(0.0f, 0.4f, 1.0f);
  look.clearcoat = GENERATE(0.0f, 1.0f);
  look.ior = GENERATE(1.0f, 1.5f, 2.2f);
  const BsdfLook prepared = make_bsdf_look(look, "test");
  for (float cosine : {0.1f, 0.45f, 0.8f, 1.0f}) {
    const Bsdf bsdf = make_bsdf(prepared, {1, 1, 1}, direction_at(cosine));
    const Eigen::Vector3d reflected = reflected_by_sampling(bsdf);
    CAPTURE(look.roughness, look.metallic, look.clearcoat, look.ior, cosine);
    CHECK(reflected.x() == Approx(1).margin(0.008));
    CHECK(double(bsdf.albedo.r) == Approx(1).margin(0.005));
  }
}

TEST_CASE("no look gives back more than it receives") {
  Look look;
  look.roughness = GENERATE(0.1f, 0.9f);
  look.metallic = GENERATE(0.0f, 1.0f);
  look.clearcoat = GENERATE(0.0f, 0.5f);
  const BsdfLook prepared = make_bsdf_look(look, "test");
  for (float cosine : {0.05f, 0.3f, 0.9f}) {
    const Bsdf bsdf = make_bsdf(prepared, {0.9f, 0.5f, 0.1f}, direction_at(cosine));
    const Eigen::Vector3d reflected = reflected_by_sampling(bsdf);
    CHECK(reflected.maxCoeff() < 1.003);
    CHECK(reflected.x() > reflected.z());
  }
}

TEST_CASE("samples follow the density and the value that evaluation tells") {
  Look look;
  look.roughness = GENERATE(0.35f, 0.8f);
  look.metallic = GENERATE(0.0f, 0.5f);
  look.clearcoat = GENERATE(0.0f, 1.0f);
  look.clearcoat_roughness = 0.4f;
  const Bsdf bsdf = make_bsdf(make_bsdf_look(look, "test"), {0.7f, 0.5f, 0.3f}, direction_at(0.6f));
  const Integrals integrals = integrate_evaluation(bsdf);
  const Eigen::Vector3d sampled = reflected_by_sampling(bsdf);
  for (int c = 0; c < 3; ++c) CHECK(sampled[c] == Approx(integrals.value[c]).epsilon(0.01));
  // what is missing to 1 was sampled below the surface
  const SampleSequence sequence(num_samples, 8);
  double kept = 0;
  for (int s = 0; s < num_samples; ++s) kept += sample_bsdf(bsdf, sequence.point(unsigned(s), 0, 0)).density > 0;
  CHECK(integrals.density == Approx(kept / num_samples).margin(0.005));
}

TEST_CASE("a layer of index 1 leaves the bare diffuse surface") {
  Look look;
  look.ior = 1;
  const Bsdf bsdf = make_bsdf(make_bsdf_look(look, "test"), {0.5f, 0.5f, 0.5f}, direction_at(0.2f));
  CHECK(double(evaluate_bsdf(bsdf, direction_at(0.3f)).value.x()) == Approx(0.5 * 0.3 / 3.14159265));
}

TEST_CASE("a smooth metal is a mirror") {
  Look look;
  look.roughness = 0;
  look.metallic = 1;
  const Bsdf bsdf = make_bsdf(make_bsdf_look(look, "test"), {0.9f, 0.6f, 0.2f}, direction_at(0.7f));
  const BsdfSample sample = sample_bsdf(bsdf, {0.3f, 0.4f});
  const Vector3f mirrored(-bsdf.viewer.x, 0, 0.7f);
  CHECK((sample.to_light - mirrored).norm() < 5e-3f);
  CHECK(double(sample.weight.z()) == Approx(0.2).margin(0.01));
}

TEST_CASE("looks outside their range are refused by name") {
  Look look;
  SECTION("roughness") {
    look.roughness = 1.2f;
  }
  SECTION("metallic") {
    look.metallic = -0.1f;
  }
  SECTION("clear coat") {
    look.clearcoat = NAN;
  }
  SECTION("index of refraction") {
    look.ior = 0.5f;
  }
  CHECK_THROWS_AS(make_bsdf_look(look, "body"), Error);
}
