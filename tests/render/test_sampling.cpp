#include "render/scene/sampling.h"

#include <numbers>
#include <set>

#include "tests/support/catch.h"

using namespace umax;

namespace {

// whether every cell of a grid over the unit square holds exactly one of as many points
bool one_in_each_cell(const std::vector<Vector2f>& points, int columns, int rows) {
  std::set<int> cells;
  for (const Vector2f& p : points) cells.insert(int(p.y() * float(rows)) * columns + int(p.x() * float(columns)));
  return int(cells.size()) == columns * rows && points.size() == cells.size();
}

std::vector<Vector2f> points_of(const SampleSequence& sequence, int x, int y, int samples, int dimension) {
  std::vector<Vector2f> points;
  for (int s = 0; s < samples; ++s)
    points.push_back(sequence.point(sequence.pixel_start(x, y) + unsigned(s), dimension, sequence.block_key(x, y)));
  return points;
}

}  // namespace

TEST_CASE("the points of a pixel fall one into each elementary interval") {
  const unsigned seed = GENERATE(1u, 77u);
  const SampleSequence sequence(16, seed);
  for (const auto& [x, y] : {std::pair{0, 0}, {5, 3}, {1279, 719}, {40000, 9}}) {
    for (int dimension : {0, 1, 5, 30, 130}) {
      const auto points = points_of(sequence, x, y, 16, dimension);
      for (int columns : {1, 2, 4, 8, 16}) CHECK(one_in_each_cell(points, columns, 16 / columns));
    }
  }
}

TEST_CASE("four neighbouring pixels share one finer set of points") {
  const SampleSequence sequence(4, 3);
  for (int dimension : {0, 7}) {
    std::vector<Vector2f> points;
    for (int i = 0; i < 4; ++i)
      for (const Vector2f& p : points_of(sequence, 10 + i % 2, 24 + i / 2, 4, dimension)) points.push_back(p);
    for (int columns : {1, 2, 4, 8, 16}) CHECK(one_in_each_cell(points, columns, 16 / columns));
  }
}

TEST_CASE("dimensions, seeds and distant pixels have points of their own") {
  const SampleSequence one(8, 1), two(8, 2);
  CHECK(points_of(one, 4, 4, 8, 0)[0] != points_of(one, 4, 4, 8, 1)[0]);
  CHECK(points_of(one, 4, 4, 8, 0)[0] != points_of(two, 4, 4, 8, 0)[0]);
  CHECK(points_of(one, 4, 4, 8, 0)[0] != points_of(one, 4 + 65536, 4, 8, 0)[0]);
}

TEST_CASE("padded dimensions are not correlated") {
  const SampleSequence sequence(1024, 5);
  const auto a = points_of(sequence, 0, 0, 1024, 2), b = points_of(sequence, 0, 0, 1024, 3);
  double sum = 0;
  for (int i = 0; i < 1024; ++i) sum += (double(a[i].x()) - 0.5) * (double(b[i].x()) - 0.5);
  CHECK(std::abs(12 * sum / 1024) < 0.1);
}

TEST_CASE("directions of the cosine hemisphere have its moments") {
  const SampleSequence sequence(4096, 1);
  Eigen::Vector3d mean(0, 0, 0);
  double square = 0;
  for (const Vector2f& u : points_of(sequence, 0, 0, 4096, 0)) {
    const Vector3f d = cosine_hemisphere(u);
    CHECK(std::abs(d.norm() - 1) < 1e-5f);
    mean += d.cast<double>() / 4096;
    square += double(d.z() * d.z()) / 4096;
  }
  CHECK(mean.x() == Approx(0).margin(2e-3));
  CHECK(mean.y() == Approx(0).margin(2e-3));
  CHECK(mean.z() == Approx(2.0 / 3).epsilon(1e-3));
  CHECK(square == Approx(0.5).epsilon(1e-3));
}

TEST_CASE("a frame is orthonormal and right-handed about any normal") {
  for (const Vector3f& n : {Vector3f(0, 0, 1), Vector3f(0, 0, -1), Vector3f(0.6f, 0, -0.8f), Vector3f(0, 1, 0)}) {
    const Frame frame(n);
    CHECK((frame.x.cross(frame.y) - n).norm() < 1e-6f);
    CHECK((frame.to_world(frame.to_local(Vector3f(0.1f, 0.2f, 0.3f))) - Vector3f(0.1f, 0.2f, 0.3f)).norm() < 1e-6f);
  }
}

TEST_CASE("a table is sampled with the density that it tells") {
  const std::vector<float> values{0, 1, 2, 5, 0, 0, 0, 0, 3, 1, 0, 4};
  const TableDistribution table(4, 3, values);
  std::vector<double> counts(12, 0.0);
  const SampleSequence sequence(16384, 9);
  for (const Vector2f& u : points_of(sequence, 0, 0, 16384, 0)) {
    float density = 0;
    const Vector2f p = table.sample(u, density);
    CHECK(table.density(p) == Approx(density));
    counts[std::size_t(p.y() * 3) * 4 + std::size_t(p.x() * 4)] += 1.0 / 16384;
  }
  for (int i = 0; i < 12; ++i) CHECK(counts[i] == Approx(double(values[i]) / 16).margin(2e-3));
  CHECK(TableDistribution(2, 2, {0, 0, 0, 0}).density({0.3f, 0.9f}) == Approx(1));
}

TEST_CASE("the pixel filter has the spread of its window and no drift") {
  const PixelFilter filter;
  double mean = 0, square = 0;
  for (int i = 0; i < 4096; ++i) {
    const double x = double(filter.offset({(float(i) + 0.5f) / 4096, 0.5f}).x());
    CHECK(std::abs(x) <= 1.5);
    mean += x / 4096;
    square += x * x / 4096;
  }
  // second moment of a0 + a1 cos(2 pi t) + ... over [-1/2, 1/2], times the width squared
  constexpr double pi = std::numbers::pi, a[4] = {0.35875, 0.48829, 0.14128, 0.01168};
  const double moment = a[0] / 12 - (a[1] - a[2] / 4 + a[3] / 9) / (2 * pi * pi);
  CHECK(mean == Approx(0).margin(1e-4));
  CHECK(square == Approx(9 * moment / a[0]).epsilon(5e-3));
}

TEST_CASE("short polynomials for angles keep their accuracy") {
  for (int i = -1000; i <= 1000; ++i) {
    const float angle = float(i) * 0.0123f;
    CHECK(std::abs(double(sin_cos(angle).sine) - std::sin(double(angle))) < 5e-7);
    CHECK(std::abs(double(sin_cos(angle).cosine) - std::cos(double(angle))) < 5e-7);
    const float x = std::cos(angle), y = 3 * std::sin(angle);
    CHECK(std::abs(double(fast_atan2(y, x)) - std::atan2(double(y), double(x))) < 1e-6);
  }
}
