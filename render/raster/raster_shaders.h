// The rasteriser's GLSL programs: what is seen at each sample, the wires, and reading samples out one by one.
#pragma once

namespace umax::raster {

constexpr const char* surface_vertex_shader = R"glsl(#version 450 core
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 color;
layout(location = 3) in vec2 texture_coordinate;
uniform mat4 clip_from_world;
centroid out vec3 world;
centroid out vec3 world_normal;
centroid out vec3 base_color;
centroid out vec2 uv;
void main() {
  world = position;
  world_normal = normal;
  base_color = color;
  uv = texture_coordinate;
  gl_Position = clip_from_world * vec4(position, 1);
}
)glsl";

constexpr const char* surface_fragment_shader = R"glsl(#version 450 core
centroid in vec3 world;
centroid in vec3 world_normal;
centroid in vec3 base_color;
centroid in vec2 uv;
layout(location = 0) out vec4 geometry;  // normal towards the eye, distance
layout(location = 1) out vec4 material;  // base colour, batch + 1
uniform vec3 eye;
uniform sampler2D base_texture;
uniform int textured;
uniform float batch;
void main() {
  vec3 n = normalize(world_normal);
  geometry = vec4(gl_FrontFacing ? n : -n, distance(world, eye));
  material = vec4(textured != 0 ? base_color * texture(base_texture, uv).rgb : base_color, batch + 1);
}
)glsl";

constexpr const char* wire_vertex_shader = R"glsl(#version 450 core
layout(location = 0) in vec4 clip;
layout(location = 1) in float distance_in;
noperspective out float from_middle;
void main() {
  from_middle = distance_in;
  gl_Position = clip;
}
)glsl";

// colour times coverage; written to the first target only
constexpr const char* wire_fragment_shader = R"glsl(#version 450 core
noperspective in float from_middle;
uniform vec3 color;
uniform float half_width;
uniform float opacity;
layout(location = 0) out vec4 layer;
void main() {
  float alpha = opacity * clamp(half_width + 0.5 - abs(from_middle), 0, 1);
  layer = vec4(color * alpha, alpha);
}
)glsl";

constexpr const char* full_vertex_shader = R"glsl(#version 450 core
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4 - 1, 0, 1); }
)glsl";

// one sample of each pixel, or (sample_index < 0) the mean of all
constexpr const char* pick_fragment_shader = R"glsl(#version 450 core
uniform sampler2DMS samples;
uniform int sample_index;
layout(location = 0) out vec4 picked;
void main() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  if (sample_index >= 0) {
    picked = texelFetch(samples, at, sample_index);
  } else {
    picked = 0.25 * (texelFetch(samples, at, 0) + texelFetch(samples, at, 1) + texelFetch(samples, at, 2) + texelFetch(samples, at, 3));
  }
}
)glsl";

}  // namespace umax::raster
