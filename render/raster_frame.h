// One frame as the rasteriser's GL part takes it: flat arrays, matrices and light samples. No scene types, no GL types.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "render/image.h"

namespace umax::raster {

// unaligned, so that structs of them have the layout that the shaders read
using Matrix4f = Eigen::Matrix<float, 4, 4, Eigen::DontAlign>;
using Vector4f = Eigen::Matrix<float, 4, 1, Eigen::DontAlign>;

struct Vertex {
  Vector3f position;  // world [m]
  Vector3f normal;    // unit
  Vector3f color;     // linear reflectance
  Vector2f texture_coordinate;
};

/// A range of indices drawn with one look.
struct Batch {
  int first_index = 0, num_indices = 0;
  Vector4f surface{0.5f, 0.04f, 0, 0};  // roughness, reflectance at normal incidence, metallic, clear coat
  float coat_roughness = 0.03f;
  bool is_ground = false;  // casts no shadow, fades into the background
  std::shared_ptr<const Image> texture;
};

/// One direction or point of light with a shadow map of its own. Laid out as the shaders read it (std140).
struct LightSample {
  Matrix4f shadow_from_world;  // to [0, 1]^3
  Vector4f position;           // w = 0: direction towards the light; w = 1: point [m]
  Vector4f power;              // rgb: irradiance (w = 0) or radiance times area (w = 1); a: normal offset [m] or [1]
  Vector4f axis;               // where a point emits to; w: 1 / its share of the whole light
};

/// Lights with highlights: a rectangle (corner, two edges) or the sun (a direction), sampled by `count` samples from
/// `first`.
struct KeyLight {
  Vector4f corner;    // xyz; w = 1: rectangle, 0: direction towards the sun
  Vector4f edge_u;    // xyz; w: first sample
  Vector4f edge_v;    // xyz; w: number of samples
  Vector4f radiance;  // rgb: radiance of the rectangle, or irradiance of the sun
};

static_assert(sizeof(LightSample) == 112 && sizeof(KeyLight) == 64 && sizeof(Vertex) == 44);

struct WireVertex {
  Vector4f clip;   // position in clip space
  float distance;  // [px] from the line's middle
};

constexpr int max_key_samples = 64, max_key_lights = 8, max_sky_samples = 48, num_probe_layers = 6;

struct Frame {
  int width = 0, height = 0;  // [px] as rendered
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<Batch> batches;

  std::vector<KeyLight> key_lights;
  std::vector<LightSample> key_samples, sky_samples;
  int key_map_size = 512, sky_map_size = 256;  // [px] of the shadow maps

  Matrix4f clip_from_world = Matrix4f::Identity();
  Matrix4f world_from_clip = Matrix4f::Identity();
  Vector3f eye{0, 0, 0};
  Image background;          // latitude-longitude, or one pixel
  std::vector<Image> probe;  // the surroundings as seen in surfaces of roughness 0, 0.2, … 1
  Vector4f sun{0, 1, 0, 2};  // direction and cosine of its radius (2: none); seen by camera rays
  Vector3f sun_radiance{0, 0, 0};
  Vector4f ground_fade{0, 0, 0, 0};  // centre xz [m], distance where the fading begins and ends [m]

  std::vector<WireVertex> wires;  // triangles
  Vector3f wire_color{0, 0, 0};
  float wire_half_width = 0.6f;  // [px]
  float wire_opacity = 1;
  float hidden_wire_opacity = 0;  // 0: hidden lines are not drawn
};

}  // namespace umax::raster
