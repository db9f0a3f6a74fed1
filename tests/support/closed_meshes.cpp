#include "tests/support/closed_meshes.h"

#include "tests/support/bodies.h"

namespace umax::test {

TriangleMesh box_mesh(const Vector3d& low, const Vector3d& high, const Vector3i& parts) {
  std::vector<Vector3d> points;
  std::vector<Vector3i> triangles;
  for (int face = 0; face < 6; ++face) {
    const int x = face / 2, y = (x + 1) % 3, z = (x + 2) % 3, first = int(points.size()), row = parts[z] + 1;
    for (int i = 0; i <= parts[y]; ++i)
      for (int j = 0; j <= parts[z]; ++j) {
        Vector3d share;
        share[x] = face % 2;
        share[y] = double(i) / parts[y];
        share[z] = double(j) / parts[z];
        points.push_back(low + share.cwiseProduct(high - low));
        if (i == parts[y] || j == parts[z]) continue;
        const int a = first + i * row + j, b = a + row, c = b + 1, d = a + 1;
        const bool high_side = face % 2 == 1;
        triangles.push_back(high_side ? Vector3i(a, b, c) : Vector3i(a, c, b));
        triangles.push_back(high_side ? Vector3i(a, c, d) : Vector3i(a, d, c));
      }
  }
  TriangleMesh mesh;
  mesh.positions = as_points(points);
  mesh.triangles.resize(Eigen::Index(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) mesh.triangles.row(Eigen::Index(t)) = triangles[t].transpose();
  return mesh;
}

TriangleMesh ball_mesh(const Vector3d& centre, double radius, int parts) {
  TriangleMesh mesh = box_mesh({-1, -1, -1}, {1, 1, 1}, Vector3i::Constant(parts));
  for (auto point : mesh.positions.rowwise()) point = (centre + radius * point.transpose().normalized()).transpose();
  return mesh;
}

TriangleMesh joined(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh;
  mesh.positions.resize(a.positions.rows() + b.positions.rows(), 3);
  mesh.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
  mesh.positions << a.positions, b.positions;
  mesh.triangles << a.triangles, (b.triangles.array() + int(a.positions.rows())).matrix();
  return mesh;
}

}  // namespace umax::test
