#include "core/element/hexahedron.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <string>

#include "core/base/error.h"
#include "core/element/material.h"
#include "tests/support/catch.h"
#include "tests/support/eigenvalues.h"
#include "tests/support/finite_differences.h"
#include "tests/support/hex_samples.h"

using namespace umax;
using namespace umax::test;

TEST_CASE("shape functions are a partition of unity and interpolate linear fields") {
  Random random(1);
  for (int i = 0; i < 20; ++i) {
    const Vector3d s = random.vector(1);
    CHECK(shape_functions(s).sum() == Approx(1).epsilon(1e-15));
    CHECK(shape_gradients(s).colwise().sum().norm() < 1e-15);

    // of the reference cube itself: s = sum N_n s_n and ds/ds = I
    const Matrix8x3d cube = box_nodes({2, 2, 2}).array() - 1;
    CHECK((cube.transpose() * shape_functions(s) - s).norm() < 1e-15);
    CHECK((cube.transpose() * shape_gradients(s) - Matrix3d::Identity()).norm() < 1e-14);
  }
}

TEST_CASE("shape functions are one at their own node and zero at the others, z fastest") {
  for (int n = 0; n < 8; ++n) {
    const Vector8d N = shape_functions(Vector3d(n & 4 ? 1 : -1, n & 2 ? 1 : -1, n & 1 ? 1 : -1));
    CHECK(N == Vector8d::Unit(n));
    const Vector3d q = quadrature_points()[n] * std::sqrt(3.0);
    CHECK((q - Vector3d(n & 4 ? 1 : -1, n & 2 ? 1 : -1, n & 1 ? 1 : -1)).norm() < 1e-15);
  }
}

TEST_CASE("shape gradients match finite differences to second order") {
  // differences along a diagonal: along an axis the functions are linear and the differences exact
  const Vector3d s(0.3, -0.2, 0.6), direction(1, 0.7, -0.4);
  const Vector8d exact = shape_gradients(s) * direction;
  const auto result = convergence(0.1, [&](double h) {
    return relative_error(Vector8d((shape_functions(s + h * direction) - shape_functions(s - h * direction)) / (2 * h)),
                          exact);
  });
  CHECK(result.lowest_order > 1.95);
  CHECK(result.highest_order < 2.05);
}

TEST_CASE("quadrature knows the volume, material gradients and moments of a hex") {
  const HexShape box = make_hex_shape(box_nodes({0.5, 0.2, 0.4}), 0.3);
  CHECK(box.volume == Approx(0.04).epsilon(1e-14));
  for (const double w : box.weights) CHECK(w == Approx(0.005).epsilon(1e-14));
  CHECK(box.rest_nodes.colwise().sum().norm() < 1e-15);

  // an irregular hex: gradients of linear fields at every point, volume by the divergence theorem on its bilinear faces
  const HexShape shape = make_hex_shape(distorted_nodes(), 0.3);
  for (const Matrix8x3d& h : shape.gradients)
    CHECK((shape.rest_nodes.transpose() * h - Matrix3d::Identity()).norm() < 1e-14);
  constexpr int faces[6][4] = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
  double volume = 0;  // integral of x . n / 3: exact with 2 x 2 Gauss points
  for (const auto& face : faces)
    for (const double a : {-1 / std::sqrt(3.0), 1 / std::sqrt(3.0)})
      for (const double b : {-1 / std::sqrt(3.0), 1 / std::sqrt(3.0)}) {
        const Eigen::Vector4d N(0.25 * (1 - a) * (1 - b), 0.25 * (1 + a) * (1 - b), 0.25 * (1 + a) * (1 + b),
                                0.25 * (1 - a) * (1 + b));
        const Eigen::Vector4d Na(-0.25 * (1 - b), 0.25 * (1 - b), 0.25 * (1 + b), -0.25 * (1 + b));
        const Eigen::Vector4d Nb(-0.25 * (1 - a), -0.25 * (1 + a), 0.25 * (1 + a), 0.25 * (1 - a));
        Vector3d x = Vector3d::Zero(), xa = x, xb = x;
        for (int k = 0; k < 4; ++k) {
          const Vector3d node = shape.rest_nodes.row(face[k]);
          x += N[k] * node, xa += Na[k] * node, xb += Nb[k] * node;
        }
        volume += x.dot(xa.cross(xb)) / 3;
      }
  CHECK(shape.volume == Approx(volume).epsilon(1e-13));
}

TEST_CASE("the rotation estimates reproduce affine maps, a tetrahedron's leaves the other nodes out") {
  const HexShape shape = make_hex_shape(distorted_nodes(), 0.3);
  const Matrix3d A = Random(2).matrix(1);
  for (const RotationEstimate estimate : rotation_estimates) {
    const Matrix8x3d& h = shape.rotation_gradients[int(estimate)];
    CHECK((affine(shape.rest_nodes, A).transpose() * h - A).norm() < 1e-13);
    CHECK(h.colwise().sum().norm() < 1e-14);
    int empty = 0;
    for (int j = 0; j < 8; ++j) empty += h.row(j).isZero(0);
    CHECK(empty == (estimate == RotationEstimate::centre ? 0 : 4));
  }
  // inner: no two of its nodes share an edge of the hex; Kuhn: the main diagonal is an edge of it
  CHECK_FALSE(shape.rotation_gradients[int(RotationEstimate::tetrahedron)].row(3).isZero(0));
  CHECK_FALSE(shape.rotation_gradients[int(RotationEstimate::kuhn)].row(7).isZero(0));
}

TEST_CASE("the stiffness is symmetric, positive and free of the six rigid motions only") {
  const double poisson = GENERATE(0.0, 0.3, 0.45);
  const HexShape shape = make_hex_shape(distorted_nodes(), poisson);
  for (const Matrix24d* K : {&shape.stiffness, &shape.stiffness_paper}) {
    CHECK(*K == K->transpose());
    const Vector24d values = eigenvalues(*K);
    CHECK(values.head<6>().cwiseAbs().maxCoeff() < 1e-14 * values[23]);
    CHECK(values[6] > 1e-3 * values[23]);
  }
}

TEST_CASE("[PPO13] Eq. 6 needs the inverse of the sum: as printed it inverts matrices of rank one") {
  const Matrix8x3d X = distorted_nodes();
  const Matrix3d A = Random(7).matrix(1) + 2 * Matrix3d::Identity();
  const Matrix8x3d x = affine(X, A);
  for (const Vector3d& s : quadrature_points()) {
    const Matrix8x3d H = shape_gradients(s);
    for (int n = 0; n < 8; ++n)
      CHECK(std::abs((X.row(n).transpose() * H.row(n)).determinant()) < 1e-16);  // X_n dN_n/ds: no inverse
    const Matrix3d corrected = (x.transpose() * H) * (X.transpose() * H).inverse();
    CHECK((corrected - A).norm() < 1e-13);
  }
}

TEST_CASE("[PPO13] Eq. 9 needs a 6 x 24 strain matrix: the printed diagonal one sees no shear") {
  const HexShape shape = make_hex_shape(box_nodes({0.5, 0.2, 0.4}), 0.3);
  Matrix3d shear = Matrix3d::Zero();
  shear(0, 1) = shear(1, 0) = 0.1;
  const Matrix8x3d u = affine(shape.rest_nodes, shear);
  double printed = 0;  // B = (diag(dN_1) ... diag(dN_8)): only du_i/dX_i
  for (int q = 0; q < 8; ++q) {
    const Vector3d normal = (u.cwiseProduct(shape.gradients[q])).colwise().sum();
    printed += shape.weights[q] * 0.5 * normal.dot(elasticity_matrix(1, 0.3).topLeftCorner<3, 3>() * normal);
  }
  const double exact = shape.volume * 0.5 * (1 / 2.6) * 0.2 * 0.2;  // 1/2 mu gamma^2
  CHECK(0.5 * stacked(u).dot(shape.stiffness * stacked(u)) == Approx(exact).epsilon(1e-12));
  CHECK(printed < 1e-15);
}

TEST_CASE("an unusable hex is refused by an error that names the fault and the place") {
  const auto message = [](const Matrix8x3d& nodes, double poisson) -> std::string {
    try {
      make_hex_shape(nodes, poisson);
    } catch (const Error& error) {
      CHECK(error.fault() == Fault::bad_data);
      return error.what();
    }
    return "";
  };
  const Matrix8x3d good = box_nodes({1, 1, 1});
  CHECK(message(good, 0.3).empty());

  Matrix8x3d mirrored = good;
  mirrored.col(0) *= -1;
  CHECK(message(mirrored, 0.3).find("hex: is inverted") == 0);
  Matrix8x3d flat = good;
  flat.col(2).setZero();
  CHECK(message(flat, 0.3).find("hex: is inverted") == 0);
  Matrix8x3d dented = good;  // one corner pushed in: inverted there, but at no quadrature point
  dented.row(7) << 0.6, 0.6, 0.6;
  CHECK(message(dented, 0.3).find("must be positive at its node 7, got -0.025") != std::string::npos);
  Matrix8x3d not_a_number = good;
  not_a_number(3, 1) = std::nan("");
  CHECK_FALSE(message(not_a_number, 0.3).empty());

  for (const double poisson : {0.5, -1.0, 0.7, std::nan("")})
    CHECK(message(good, poisson).find("Poisson") != std::string::npos);
}
