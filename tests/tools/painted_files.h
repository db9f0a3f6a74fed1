// Painted meshes as files.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>

#include "core/base/triangle_mesh.h"

namespace umax::testing {

/// ASCII PLY with 8-bit colours; mesh.colors are the codes' shares of 255, as they are.
inline std::string painted_ply(const TriangleMesh& mesh) {
  std::ostringstream text;
  text.precision(17);
  text << "ply\nformat ascii 1.0\nelement vertex " << mesh.num_vertices()
       << "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nproperty uchar green\n"
          "property uchar blue\nelement face "
       << mesh.num_triangles() << "\nproperty list uchar int vertex_indices\nend_header\n";
  for (Eigen::Index v = 0; v < mesh.num_vertices(); ++v) {
    for (const double x : mesh.positions.row(v)) text << x << ' ';
    for (const double c : mesh.colors.row(v)) text << int(255 * c + 0.5) << ' ';
    text << '\n';
  }
  for (const auto& t : mesh.triangles.rowwise()) text << "3 " << t[0] << ' ' << t[1] << ' ' << t[2] << '\n';
  return text.str();
}

/// OBJ with the widespread three numbers of colour behind a vertex.
inline std::string painted_obj(const TriangleMesh& mesh) {
  std::ostringstream text;
  text.precision(17);
  for (Eigen::Index v = 0; v < mesh.num_vertices(); ++v) {
    text << 'v';
    for (const double x : mesh.positions.row(v)) text << ' ' << x;
    for (const double c : mesh.colors.row(v)) text << ' ' << c;
    text << '\n';
  }
  for (const auto& t : mesh.triangles.rowwise()) text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
  return text.str();
}

inline std::string base64_text(const std::string& bytes) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t group = 0;
    for (std::size_t k = 0; k < 3; ++k)
      group = group << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : std::uint8_t(0));
    for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

/// glTF with COLOR_0 as floats, which the format defines as linear.
inline std::string painted_gltf(const TriangleMesh& mesh) {
  std::string bytes;
  const auto append = [&](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  for (const double x : mesh.positions.reshaped<Eigen::RowMajor>()) append(float(x));
  for (const double c : mesh.colors.reshaped<Eigen::RowMajor>()) append(float(c));
  for (const int corner : mesh.triangles.reshaped<Eigen::RowMajor>()) append(std::uint32_t(corner));
  std::ostringstream text;
  const auto vertices = mesh.num_vertices(), size = 12 * vertices;
  text << R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
       << R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"COLOR_0":1},"indices":2}]}],)"
       << R"("buffers":[{"byteLength":)" << bytes.size() << R"(,"uri":"data:application/octet-stream;base64,)"
       << base64_text(bytes) << R"("}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":)" << size
       << R"(},{"buffer":0,"byteOffset":)" << size << R"(,"byteLength":)" << size << R"(},{"buffer":0,"byteOffset":)"
       << 2 * size << R"(,"byteLength":)" << 12 * mesh.num_triangles() << R"(}],"accessors":[)"
       << R"({"bufferView":0,"componentType":5126,"count":)" << vertices
       << R"(,"type":"VEC3","min":[-9,-9,-9],"max":[9,9,9]},{"bufferView":1,"componentType":5126,"count":)" << vertices
       << R"(,"type":"VEC3"},{"bufferView":2,"componentType":5125,"count":)" << 3 * mesh.num_triangles()
       << R"(,"type":"SCALAR"}]})";
  return text.str();
}

}  // namespace umax::testing
