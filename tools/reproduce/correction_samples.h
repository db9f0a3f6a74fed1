// Sample hexes for corrections(): the paper's regular cells of several sizes, deformed, turned and moved; the same ones
// always.
#pragma once

#include <functional>
#include <vector>

#include "core/element/elastic_energy.h"
#include "core/element/material.h"
#include "tools/reproduce/corrections.h"

namespace umax {

/// A box of the given edges at some place in the world.
struct SampleHex {
  HexShape shape;
  Moduli moduli;                              // [Pa] of `young` and the shape's Poisson's ratio
  double young = 0;                           // [Pa]
  double edge = 0;                            // [m] the shortest
  Matrix3d pose = Matrix3d::Identity();       // world from lattice
  Vector3d place = Vector3d::Zero();          // [m]
  Matrix3d strain = Matrix3d::Zero();         // [-] symmetric, for uniform deformations
  Matrix8x3d positions = Matrix8x3d::Zero();  // [m] every node displaced by up to 15 % of the edges, then posed
};

/// 20 poses of each cell.
std::vector<SampleHex> sample_hexes(const std::vector<Vector3d>& cells, double poisson = 0.3);

/// The cell of the paper's beam, of its armadillo, and a flat one of 26 cm.
std::vector<SampleHex> sample_hexes();

/// Positions [m] of the hex under the uniform strain, in its pose.
Matrix8x3d strained(const SampleHex& hex, const Matrix3d& strain);

/// 1/2 sigma:eps V [J] of a uniform strain.
double closed_form_energy(const SampleHex& hex, const Matrix3d& strain);

/// Derivatives by x of a function of the positions, to fourth order in the step.
Vector24d fine_difference(const SampleHex& hex, const std::function<double(const Matrix8x3d&)>& f);

/// Derivatives of a function that is quadratic: exact but for rounding.
Vector24d exact_difference(const SampleHex& hex, const std::function<double(const Matrix8x3d&)>& f);

struct ErrorPair {
  double printed = 0, corrected = 0;  // [-]
};

/// The row with its errors filled in from all samples.
Correction measured(Correction row, const std::vector<SampleHex>& samples,
                    const std::function<ErrorPair(const SampleHex&)>& errors_of);

/// The rows of Eq. 6 to 16, of Eq. 15 to 17 and the rotation, and of Sect. 5.
void add_energy_corrections(std::vector<Correction>& rows);
void add_derivative_corrections(std::vector<Correction>& rows);
void add_step_corrections(std::vector<Correction>& rows);

}  // namespace umax
