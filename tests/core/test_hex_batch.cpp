// Hexes evaluated several at once, against those evaluated one by one.
#include "core/element/hex_batch.h"

#include <algorithm>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using test::Random;

namespace {

/// Turned and little, clearly and wildly deformed; flat, in a line, in a point, mirrored.
std::vector<Matrix8x3d> samples(const Matrix8x3d& rest) {
  Random random(11);
  std::vector<Matrix8x3d> nodes{rest};
  for (const double noise : {1e-9, 0.01, 0.1, 0.3, 1.0, 3.0})
    for (int i = 0; i < 12; ++i) nodes.push_back(test::deformed(rest, random, noise));
  for (const Vector3d& scale : {Vector3d(1, 0, 1), Vector3d(1e-5, 1, 1), Vector3d(0, 0, 1), Vector3d(0, 0, 0),
                                Vector3d(-1, 1, 1), Vector3d(1, 1e-3, 50)})
    nodes.push_back(test::affine(rest, random.rotation() * scale.asDiagonal().toDenseMatrix()));
  return nodes;
}

void require_same(const CorotatedHex& hex, const EnergyWithGradient& elastic, const HexBatch& batch, int lane,
                  double young) {
  const CorotatedHex found = corotated_hex(batch, lane);
  const double size = 1 + hex.local_nodes.norm(), force = young * (1 + hex.displacement.norm());
  CHECK((found.rotation - hex.rotation).norm() < 1e-11);
  CHECK((found.stretch - hex.stretch).norm() < 1e-11 * (1 + hex.stretch.norm()));
  CHECK((found.local_nodes - hex.local_nodes).norm() < 1e-11 * size);
  CHECK((found.displacement - hex.displacement).norm() < 1e-11 * size);
  CHECK(std::abs(elastic_energy(young, batch, lane) - elastic.energy) < 1e-11 * (elastic.energy + young * 1e-3));
  CHECK((elastic_gradient(young, batch, lane) - elastic.gradient).norm() < 1e-9 * force);
  CHECK(rotation_of(batch, lane) == found.rotation);
}

}  // namespace

TEST_CASE("a batch of hexes has the rotations, energies and gradients of single ones") {
  constexpr double young = 3e5;
  for (const Matrix8x3d& rest : {test::box_nodes({0.1, 0.12, 0.09}), test::distorted_nodes()}) {
    const HexShape shape = make_hex_shape(rest, 0.3);
    const std::vector<Matrix8x3d> nodes = samples(rest);
    for (const RotationEstimate estimate : test::rotation_estimates)
      for (std::size_t first = 0; first < nodes.size(); first += most_batched) {
        const int count = int(std::min(nodes.size() - first, std::size_t(most_batched)));
        HexBatch batch;
        for (int lane = 0; lane < count; ++lane) set_nodes(nodes[first + std::size_t(lane)], lane, batch);
        evaluate(shape, estimate, count, batch);
        for (int lane = 0; lane < count; ++lane) {
          const CorotatedHex hex = corotate(shape, estimate, nodes[first + std::size_t(lane)]);
          INFO("estimate " << int(estimate) << ", sample " << first + std::size_t(lane));
          require_same(hex, energy_with_gradient(shape.stiffness, young, shape.rotation_gradients[int(estimate)], hex),
                       batch, lane, young);
        }
      }
  }
}

TEST_CASE("a batch of hexes has the warped products of single ones") {
  Random random(5);
  const HexShape shape = make_hex_shape(test::distorted_nodes(), 0.3);
  for (const int count : {1, 3, most_batched}) {
    HexBatch batch;
    std::vector<Matrix8x3d> motions;
    std::vector<Matrix3d> rotations;
    for (int lane = 0; lane < count; ++lane) {
      set_nodes(motions.emplace_back(random.nodes(1)), lane, batch);
      set_rotation(rotations.emplace_back(random.rotation()), lane, batch);
    }
    multiply_warped(shape, count, batch);
    for (int lane = 0; lane < count; ++lane) {
      const Vector24d product = warped_product(shape.stiffness, 7, rotations[lane], motions[lane]);
      CHECK((elastic_gradient(7, batch, lane) - product).norm() < 1e-13 * product.norm());
    }
  }
}

TEST_CASE("what a batch finds of a hex does not depend on the hexes beside it") {
  const Matrix8x3d rest = test::box_nodes({0.1, 0.1, 0.1});
  const HexShape shape = make_hex_shape(rest, 0.3);
  const std::vector<Matrix8x3d> nodes = samples(rest);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    HexBatch alone, among;
    set_nodes(nodes[i], 0, alone);
    evaluate(shape, RotationEstimate::centre, 1, alone);
    const int lane = int(i % most_batched);
    for (int other = 0; other < most_batched; ++other)
      set_nodes(nodes[other == lane ? i : (7 * i + std::size_t(other)) % nodes.size()], other, among);
    evaluate(shape, RotationEstimate::centre, most_batched, among);
    INFO("sample " << i);
    CHECK(elastic_gradient(1, alone, 0) == elastic_gradient(1, among, lane));
    CHECK(elastic_energy(1, alone, 0) == elastic_energy(1, among, lane));
    CHECK(rotation_of(alone, 0) == rotation_of(among, lane));
  }
}

TEST_CASE("batch kernels of every instruction set find the same bits") {
  const Matrix8x3d rest = test::distorted_nodes();
  const HexShape shape = make_hex_shape(rest, 0.3);
  const HexBatchShape constants{shape.stiffness.data(), shape.rotation_gradients[0].data(), shape.rest_nodes.data()};
  const std::vector<Matrix8x3d> nodes = samples(rest);
  for (std::size_t first = 0; first + most_batched <= nodes.size(); first += most_batched) {
    HexBatch portable = {};
    for (const InstructionSet set : {InstructionSet::portable, InstructionSet::avx2, InstructionSet::avx512}) {
      if (!is_supported(set)) continue;
      HexBatch batch = {};
      for (int lane = 0; lane < most_batched; ++lane) set_nodes(nodes[first + std::size_t(lane)], lane, batch);
      hex_batch_kernels(set).evaluate(constants, batch);
      if (set == InstructionSet::portable) portable = batch;
      INFO("instruction set " << name_of(set));
      CHECK(batch.unresolved == portable.unresolved);
      for (int lane = 0; lane < most_batched; ++lane) {
        if (batch.unresolved >> lane & 1) continue;
        CHECK(elastic_gradient(1, batch, lane) == elastic_gradient(1, portable, lane));
        CHECK(elastic_energy(1, batch, lane) == elastic_energy(1, portable, lane));
        CHECK(corotated_hex(batch, lane).stretch == corotated_hex(portable, lane).stretch);
      }
    }
  }
}
