#include "tools/reproduce/correction_samples.h"

#include <algorithm>
#include <cstdint>
#include <random>

#include "core/base/finite_differences.h"
#include "core/element/rotation.h"

namespace umax {
namespace {

constexpr double young = 150e3;  // [Pa]
constexpr double noise = 0.15;   // [-] of the edges, and of the strains
constexpr int poses_per_cell = 20;

// entries in (-1, 1) from the generator's bits: those are the same everywhere, the standard's distributions are not
template <class Matrix>
Matrix uniform(std::mt19937_64& bits) {
  Matrix m;
  for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = double(std::int64_t(bits()) >> 11) * 0x1p-52;
  return m;
}

SampleHex sample_hex(const Vector3d& edges, double poisson, std::mt19937_64& bits) {
  Matrix8x3d nodes;
  for (int n = 0; n < 8; ++n) nodes.row(n) << (n & 4 ? edges[0] : 0), (n & 2 ? edges[1] : 0), (n & 1 ? edges[2] : 0);
  SampleHex hex{.shape = make_hex_shape(nodes, poisson), .moduli = moduli(young, poisson)};
  hex.young = young;
  hex.edge = edges.minCoeff();
  hex.pose = rotation_from_degrees(180 * uniform<Vector3d>(bits));
  hex.place = uniform<Vector3d>(bits);
  const Matrix3d m = noise * uniform<Matrix3d>(bits);
  hex.strain = 0.5 * (m + m.transpose());
  const Matrix8x3d displaced = hex.shape.rest_nodes + noise * uniform<Matrix8x3d>(bits) * edges.asDiagonal();
  hex.positions = (displaced * hex.pose.transpose()).rowwise() + hex.place.transpose();
  return hex;
}

}  // namespace

std::vector<SampleHex> sample_hexes(const std::vector<Vector3d>& cells, double poisson) {
  std::mt19937_64 bits(2013);
  std::vector<SampleHex> samples;
  for (const Vector3d& edges : cells)
    for (int i = 0; i < poses_per_cell; ++i) samples.push_back(sample_hex(edges, poisson, bits));
  return samples;
}

std::vector<SampleHex> sample_hexes() {
  return sample_hexes({{1.0 / 14, 0.06, 0.06}, {0.163, 0.163, 0.163}, {0.26, 0.18, 0.12}});
}

Matrix8x3d strained(const SampleHex& hex, const Matrix3d& strain) {
  const Matrix3d F = hex.pose * (Matrix3d::Identity() + strain);
  return (hex.shape.rest_nodes * F.transpose()).rowwise() + hex.place.transpose();
}

double closed_form_energy(const SampleHex& hex, const Matrix3d& strain) {
  const double trace = strain.trace();
  return hex.shape.volume * (0.5 * hex.moduli.E2 * trace * trace + hex.moduli.E3 * strain.squaredNorm());
}

Vector24d fine_difference(const SampleHex& hex, const std::function<double(const Matrix8x3d&)>& f) {
  const double h = 4e-3 * hex.edge;
  return (4 * difference_gradient(f, hex.positions, 0.5 * h) - difference_gradient(f, hex.positions, h)) / 3;
}

Vector24d exact_difference(const SampleHex& hex, const std::function<double(const Matrix8x3d&)>& f) {
  return difference_gradient(f, hex.positions, 0.1 * hex.edge);
}

Correction measured(Correction row, const std::vector<SampleHex>& samples,
                    const std::function<ErrorPair(const SampleHex&)>& errors_of) {
  row.num_samples = int(samples.size());
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const ErrorPair errors = errors_of(samples[i]);
    row.error_printed += errors.printed / double(samples.size());
    row.lowest_printed = i == 0 ? errors.printed : std::min(row.lowest_printed, errors.printed);
    row.highest_printed = std::max(row.highest_printed, errors.printed);
    row.error_corrected = std::max(row.error_corrected, errors.corrected);
  }
  return row;
}

}  // namespace umax
