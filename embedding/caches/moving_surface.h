// A surface that moves, as caches and sequences of meshes hold it: what stays the same, and what each frame brings.
// The files' writers know nothing else: neither scenes nor cages.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/triangle_mesh.h"

namespace umax {

using FloatPoints = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;  // #P x 3

/// How a surface looks, as far as exchange formats can say it.
struct SurfaceMaterial {
  std::string name;                       // as material_names() makes them
  Vector3f base_color{0.6f, 0.6f, 0.6f};  // linear Rec. 709
  float roughness = 0.5f, metallic = 0;   // [0, 1]
  float clearcoat = 0, clearcoat_roughness = 0.03f;
  float ior = 1.5f;
  std::string texture;         // file that colours it, beside the file that is written; empty: none
  bool vertex_colors = false;  // the surface's colors are its colour
};

/// What stays the same. Vertices have the order and number of the mesh file.
struct MovingSurface {
  std::string name;
  FloatPoints rest;                           // #V x 3
  Triangles triangles;                        // #T x 3, counter-clockwise from outside
  TextureCoordinates texture_coordinates;     // 3 #T x 2, one per triangle corner, or empty
  FloatPoints colors;                         // #V x 3 linear Rec. 709, or empty
  std::vector<SurfaceMaterial> materials{1};  // at least one
  std::vector<int> triangle_materials;        // #T which of them each triangle has; empty: all the first
  std::string library;                        // file that holds the materials of OBJ meshes, beside them
  bool moves = true;                          // false: all frames have the rest shape

  Eigen::Index num_vertices() const { return rest.rows(); }
  std::size_t material_of(Eigen::Index triangle) const {
    return triangle_materials.empty() ? 0 : std::size_t(triangle_materials[std::size_t(triangle)]);
  }
  /// The textures of all materials, each once.
  std::vector<std::string> textures() const;
  /// The triangles of a material, ascending.
  std::vector<int> triangles_of(std::size_t material) const;
};

/// The surface in one frame. What a format does not hold may stay empty.
struct SurfaceFrame {
  int frame = 1;           // its number in the clip, from 1
  double time = 0;         // [s]
  FloatPoints positions;   // #V x 3
  FloatPoints velocities;  // #V x 3 per second
  FloatPoints normals;     // #V x 3 unit
};

/// Names for materials that every format takes: letters, digits, _, - and . alone, none twice, none empty.
std::vector<std::string> material_names(const std::vector<std::string>& wanted);

/// What all surfaces of an export share.
struct ClipSpace {
  double fps = 60;          // [1/s]
  std::vector<int> frames;  // numbers, increasing; frame 1 is at time 0
  bool z_up = false;        // else y
  double unit = 1;          // [m] length of one unit of what is written
  double time_of(int frame) const { return (frame - 1) / fps; }
};

/// The camera of a clip, in the axes and the unit of what is written.
struct ClipCamera {
  Vector3d position{0, 0, 5}, target{0, 0, 0}, up{0, 1, 0};
  double vertical_fov_degrees = 35, aspect = 16.0 / 9;  // width / height
  double aperture_radius = 0, focus_distance = 1;       // 0: pinhole
};

/// What a camera sees along, orthonormal: it looks along -back.
struct CameraAxes {
  Vector3d right, up, back;
};
CameraAxes axes_of(const ClipCamera& camera);

/// (x, y, z) with y up becomes what z-up programs have: (x, -z, y).
inline Vector3d z_up_from_y_up(const Vector3d& v) {
  return {v.x(), -v.z(), v.y()};
}

}  // namespace umax
