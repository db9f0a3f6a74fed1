// Names for the matrix types that all rooms share: points, triangles, hexes, small vectors. One row is one point.
#pragma once

#include <Eigen/Core>

namespace umax {

using Eigen::Matrix3d;
using Eigen::Matrix3f;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::Vector3f;
using Eigen::Vector3i;
using Eigen::VectorXd;
using Eigen::VectorXf;
using Eigen::VectorXi;

using Points = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;  // #P x 3
using Triangles = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;  // #T x 3
using Hexes = Eigen::Matrix<int, Eigen::Dynamic, 8, Eigen::RowMajor>;      // #E x 8, local order: element/hexahedron.h
using Cells = Eigen::Matrix<int, Eigen::Dynamic, 3, Eigen::RowMajor>;      // #E x 3 integer grid coordinates
using Matrix8x3d = Eigen::Matrix<double, 8, 3, Eigen::RowMajor>;           // a hexahedron's nodes, one a row
using Vector8d = Eigen::Matrix<double, 8, 1>;
using Vector24d = Eigen::Matrix<double, 24, 1>;  // 8 nodes x (x, y, z), node after node
using Matrix6d = Eigen::Matrix<double, 6, 6>;    // strains (xx, yy, zz, yz, xz, xy), engineering shear
using Matrix24d = Eigen::Matrix<double, 24, 24>;

}  // namespace umax
