// What passes between the rasteriser's parts: prepare (scene to flat arrays), draw (GL: what is seen where), shade.
#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "render/image/image.h"
#include "render/scene/render_scene.h"

namespace umax::raster {

using Eigen::Matrix4f;
using Eigen::Vector4f;

struct Vertex {
  Vector3f position;  // world [m]
  Vector3f normal;    // unit
  Vector3f color;     // linear reflectance
  Vector2f texture_coordinate;
};

/// A range of indices drawn with one look.
struct Batch {
  int first_index = 0, num_indices = 0;
  float roughness = 0.5f, reflectance = 0.04f, metallic = 0, coat = 0,
        coat_roughness = 0.03f;                        // reflectance: at normal incidence
  float transmission = 0, subsurface = 0, ior = 1.5f;  // in place of what is matt: is seen through; is soft
  bool is_ground = false;                              // casts no shadow, fades into the background
  std::shared_ptr<const Image> texture;
};

/// One direction or point of light with a shadow map of its own.
struct LightSample {
  Matrix4f shadow_from_world;  // to [0, 1]^3
  Vector3f position;           // direction towards the light, or point [m]
  bool is_point = false;
  Vector3f power;          // irradiance (direction) or radiance times area (point)
  Vector3f axis{0, 1, 0};  // where a point emits to
  float texel = 0;         // size of a texel of its map: [m], or for a point [m] at 1 m
};

/// Lights with highlights: a rectangle, or the sun, sampled by key_samples[first] and the following.
struct KeyLight {
  bool is_rectangle = false;
  Vector3f corner{0, 0, 0};  // [m], or the direction towards the sun
  Vector3f edge_u{1, 0, 0}, edge_v{0, 0, 1};
  Vector3f radiance{0, 0, 0};  // of the rectangle, or irradiance of the sun
  int first = 0, count = 0;
};

static_assert(sizeof(Vertex) == 44);

struct WireVertex {
  Eigen::Matrix<float, 4, 1, Eigen::DontAlign> clip;  // position in clip space
  float distance;                                     // [px] from the line's middle
};

constexpr int max_key_samples = 128, max_key_lights = 16, max_sky_samples = 64, num_probe_layers = 6;

struct Frame {
  int width = 0, height = 0;  // [px] as rendered
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;
  std::vector<Batch> batches;

  std::vector<KeyLight> key_lights;
  std::vector<LightSample> key_samples, sky_samples;
  int key_map_size = 512, sky_map_size = 160;  // [px] of the shadow maps

  Matrix4f clip_from_world = Matrix4f::Identity();
  Matrix4f world_from_clip = Matrix4f::Identity();
  Vector3f eye{0, 0, 0};
  Image background;          // latitude-longitude, or one pixel
  std::vector<Image> probe;  // the surroundings as seen in surfaces of roughness 0, 0.2, … 1
  Vector4f sun{0, 1, 0, 2};  // direction and cosine of its radius (2: none); seen by camera rays
  Vector3f sun_radiance{0, 0, 0};
  std::optional<Fade> ground_fade;

  std::vector<WireVertex> wires;  // triangles
  Vector3f wire_color{0, 0, 0};
  float wire_half_width = 0.6f;  // [px]
  float wire_opacity = 1;
  float hidden_wire_opacity = 0;  // 0: hidden lines are not drawn
};

constexpr int samples_per_pixel = 4;

/// What GL found at each sample of each pixel, rows from the top.
struct Visible {
  int width = 0, height = 0;
  // 4 floats at ((sample * height + y) * width + x) * 4
  std::vector<float> geometry;  // unit normal towards the eye, distance from the eye [m]
  std::vector<float> material;  // base colour, index of the batch + 1 (0: background)
  Image wires;                  // RGBA, colour times coverage, to be laid over the picture; empty: none
};

}  // namespace umax::raster
