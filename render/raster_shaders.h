// The rasteriser's GLSL programs.
#pragma once

namespace umax::raster {

constexpr const char* shadow_vertex_shader = R"glsl(#version 450 core
layout(location = 0) in vec3 position;
uniform mat4 shadow_from_world;  // to [0, 1]^3
void main() {
  vec4 p = shadow_from_world * vec4(position, 1);
  gl_Position = vec4(2 * p.xyz - p.w, p.w);
}
)glsl";

constexpr const char* shadow_fragment_shader = R"glsl(#version 450 core
void main() {}
)glsl";

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

constexpr const char* surroundings = R"glsl(
const float pi = 3.14159265358979;

// row 0 is +Y, u = 0 looks along +Z, u = 0.25 along +X
vec2 latlong(vec3 d) { return vec2(atan(d.x, d.z) / (2 * pi), acos(clamp(d.y, -1, 1)) / pi); }

uniform sampler2D background_map;
uniform vec4 sun;  // direction, cosine of its radius
uniform vec3 sun_radiance;

vec3 background(vec3 direction) {
  vec3 sky = textureLod(background_map, latlong(direction), 0).rgb;
  float edge = 0.15 * (1 - sun.w);
  return sky + sun_radiance * smoothstep(sun.w - edge, sun.w + edge, dot(direction, sun.xyz));
}
)glsl";

constexpr const char* surface_fragment_shader = R"glsl(
centroid in vec3 world;
centroid in vec3 world_normal;
centroid in vec3 base_color;
centroid in vec2 uv;
out vec4 radiance;

struct LightSample { mat4 shadow_from_world; vec4 position; vec4 power; vec4 axis; };
struct KeyLight { vec4 corner; vec4 edge_u; vec4 edge_v; vec4 radiance; };
layout(std140, binding = 0) uniform KeySamples { LightSample key_samples[64]; };
layout(std140, binding = 1) uniform SkySamples { LightSample sky_samples[48]; };
layout(std140, binding = 2) uniform KeyLights { KeyLight key_lights[8]; };
uniform int num_key_lights;
uniform int num_sky_samples;
uniform sampler2DArrayShadow key_shadows;
uniform sampler2DArrayShadow sky_shadows;
uniform sampler2DArray probe;
uniform sampler2D base_texture;
uniform bool textured;
uniform bool is_ground;
uniform vec4 ground_fade;
uniform vec4 surface;  // roughness, f0, metallic, clear coat
uniform float coat_roughness;
uniform vec3 eye;

// how much of a light sample reaches p, a little off the surface against self-shadowing
float visibility(sampler2DArrayShadow maps, mat4 shadow_from_world, int layer, vec3 p) {
  vec4 s = shadow_from_world * vec4(p, 1);
  if (s.w <= 0) return 1;
  s.xyz /= s.w;
  if (any(lessThan(s.xy, vec2(0))) || any(greaterThan(s.xy, vec2(1)))) return 1;
  return texture(maps, vec4(s.xy, layer, min(s.z, 1)));
}

// GGX with the height-correlated Smith term: the BRDF without its Fresnel factor
float ggx(float n_h, float n_v, float n_l, float alpha) {
  float a2 = alpha * alpha;
  float d = n_h * n_h * (a2 - 1) + 1;
  float v = n_l * sqrt(n_v * n_v * (1 - a2) + a2) + n_v * sqrt(n_l * n_l * (1 - a2) + a2);
  return a2 / (pi * d * d) * 0.5 / max(v, 1e-5);
}
vec3 fresnel(vec3 f0, float c) { return f0 + (1 - f0) * pow(1 - clamp(c, 0, 1), 5); }

// scale and bias of f0 for light from all around: the fit of B. Karis, "Physically Based Shading on Mobile", 2014
vec2 all_around(float roughness, float n_v) {
  vec4 r = roughness * vec4(-1, -0.0275, -0.572, 0.022) + vec4(1, 0.0425, 1.04, -0.04);
  float a = min(r.x * r.x, exp2(-9.28 * n_v)) * r.x + r.y;
  return vec2(-1.04, 1.04) * a + r.zw;
}

vec3 surroundings_in(vec3 direction, float roughness) {
  float layer = 5 * roughness, lower = floor(layer);
  vec2 at = latlong(direction);
  return mix(textureLod(probe, vec3(at, lower), 0).rgb, textureLod(probe, vec3(at, min(lower + 1, 5)), 0).rgb, layer - lower);
}

// the point of a rectangle that a mirror would show, or the nearest to it
vec3 mirrored_point(KeyLight light, vec3 r) {
  vec3 axis = cross(light.edge_u.xyz, light.edge_v.xyz);
  vec3 centre = light.corner.xyz + 0.5 * (light.edge_u.xyz + light.edge_v.xyz);
  float along = dot(r, axis);
  vec3 hit = abs(along) > 1e-6 ? world + r * (dot(light.corner.xyz - world, axis) / along) : centre;
  if (dot(hit - world, r) < 0) hit = centre;
  vec3 offset = hit - light.corner.xyz;
  float u = clamp(dot(offset, light.edge_u.xyz) / dot(light.edge_u.xyz, light.edge_u.xyz), 0, 1);
  float v = clamp(dot(offset, light.edge_v.xyz) / dot(light.edge_v.xyz, light.edge_v.xyz), 0, 1);
  return light.corner.xyz + u * light.edge_u.xyz + v * light.edge_v.xyz;
}

struct Shading { vec3 diffuse; vec3 glossy; vec3 coat; };  // light in, weighted by the cosine (glossy, coat: by the lobe)

void add_key_light(int k, vec3 n, vec3 v, float n_v, vec3 f0, inout Shading sum) {
  KeyLight light = key_lights[k];
  int first = int(light.edge_u.w), count = int(light.edge_v.w);
  vec3 irradiance = vec3(0);
  float seen = 0;
  for (int i = first; i < first + count; ++i) {
    LightSample s = key_samples[i];
    vec3 to_light = s.position.xyz - s.position.w * world;
    float d2 = dot(to_light, to_light);
    vec3 l = to_light * inversesqrt(d2);
    float n_l = dot(n, l), emitted = s.position.w > 0 ? max(-dot(l, s.axis.xyz), 0) / d2 : 1;
    if (n_l <= 0 || emitted <= 0) continue;
    float off = s.power.a * (s.position.w > 0 ? sqrt(d2) : 1);
    float lit = visibility(key_shadows, s.shadow_from_world, i, world + n * off * (1.0 + 2.0 * (1 - n_l)));
    seen += lit;
    irradiance += s.power.rgb * (lit * emitted * n_l);
  }
  sum.diffuse += irradiance;
  if (seen == 0) return;
  // the highlight once per light, from its most mirror-like point, widened by the light's angular size
  vec3 l = light.corner.xyz;
  float widening = 0, n_irradiance = 1;
  vec3 power = light.radiance.rgb;
  if (light.corner.w > 0) {
    vec3 to_light = mirrored_point(light, reflect(-v, n)) - world;
    vec3 axis = cross(light.edge_u.xyz, light.edge_v.xyz);
    float d2 = dot(to_light, to_light), area = length(axis);
    l = to_light * inversesqrt(d2);
    widening = sqrt(area / (pi * d2)) * 0.5;
    power *= area / d2 * max(-dot(l, axis / area), 0);
  }
  float n_l = clamp(dot(n, l), 0, 1);
  if (n_l == 0) return;
  vec3 h = normalize(l + v);
  float n_h = clamp(dot(n, h), 0, 1), v_h = dot(v, h);
  vec3 arriving = power * (n_l * seen / count);
  float alpha = max(surface.x * surface.x, 0.002), coat_alpha = max(coat_roughness * coat_roughness, 0.002);
  float wide = min(alpha + widening, 1), coat_wide = min(coat_alpha + widening, 1);
  // a wider lobe with the energy of the narrow one
  sum.glossy += arriving * fresnel(f0, v_h) * ggx(n_h, n_v, n_l, wide);
  sum.coat += arriving * ggx(n_h, n_v, n_l, coat_wide) * fresnel(vec3(0.04), v_h).x;
}

float add_sky(vec3 n, inout Shading sum) {
  float open = 0, whole = 1e-6;
  for (int j = 0; j < num_sky_samples; ++j) {
    float n_l = dot(n, sky_samples[j].position.xyz);
    if (n_l <= 0) continue;
    vec3 p = world + n * (sky_samples[j].power.a * (1.5 + 2.0 * (1 - n_l)));
    float lit = visibility(sky_shadows, sky_samples[j].shadow_from_world, j, p);
    vec3 arriving = sky_samples[j].power.rgb * n_l;
    sum.diffuse += arriving * lit;
    open += n_l * lit;
    whole += n_l;
  }
  return open / whole;
}

void main() {
  vec3 v = normalize(eye - world);
  vec3 n = normalize(gl_FrontFacing ? world_normal : -world_normal);
  float n_v = max(dot(n, v), 1e-3);
  vec3 base = textured ? base_color * texture(base_texture, uv).rgb : base_color;
  float metallic = surface.z, coat = surface.w;
  vec3 f0 = mix(vec3(surface.y), base, metallic);

  Shading sum = Shading(vec3(0), vec3(0), vec3(0));
  for (int k = 0; k < num_key_lights; ++k) add_key_light(k, n, v, n_v, f0, sum);
  float open = add_sky(n, sum);

  // mirrored surroundings, dimmed where the sky is hidden (S. Lagarde, "Moving Frostbite to PBR", 2014, occlusion of reflections)
  vec3 r = reflect(-v, n);
  vec2 fit = all_around(surface.x, n_v), coat_fit = all_around(coat_roughness, n_v);
  float open_glossy = clamp(pow(n_v + open, exp2(-16 * surface.x - 1)) - 1 + open, 0, 1);
  sum.glossy += surroundings_in(r, surface.x) * (f0 * fit.x + fit.y) * open_glossy;
  sum.coat += surroundings_in(r, coat_roughness) * (0.04 * coat_fit.x + coat_fit.y) * clamp(pow(n_v + open, 0.5) - 1 + open, 0, 1);

  vec3 diffuse = base * (1 - metallic) / pi * (1 - (f0 * fit.x + fit.y)) * sum.diffuse;
  float through = 1 - coat * (0.04 * coat_fit.x + coat_fit.y);
  vec3 color = (diffuse + sum.glossy) * through * through + coat * sum.coat;

  if (is_ground) {
    float fade = smoothstep(ground_fade.z, ground_fade.w, distance(world.xz, ground_fade.xy));
    vec3 horizon = normalize(vec3(-v.x, max(-v.y, 0.002), -v.z));
    color = mix(color, background(horizon), fade);
  }
  radiance = vec4(color, 1);
}
)glsl";

constexpr const char* background_vertex_shader = R"glsl(#version 450 core
uniform mat4 world_from_clip;
uniform vec3 eye;
out vec3 direction;
void main() {
  vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4 - 1;
  vec4 far = world_from_clip * vec4(corner, 1, 1);
  direction = far.xyz / far.w - eye;
  gl_Position = vec4(corner, 1, 1);
}
)glsl";

constexpr const char* background_fragment_shader = R"glsl(
in vec3 direction;
out vec4 radiance;
void main() { radiance = vec4(background(normalize(direction)), 0); }
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

constexpr const char* wire_fragment_shader = R"glsl(#version 450 core
noperspective in float from_middle;
uniform vec3 color;
uniform float half_width;
uniform float opacity;
out vec4 radiance;
void main() { radiance = vec4(color, opacity * clamp(half_width + 0.5 - abs(from_middle), 0, 1)); }
)glsl";

constexpr const char* resolve_vertex_shader = R"glsl(#version 450 core
void main() { gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4 - 1, 0, 1); }
)glsl";

// mean of the four samples, each weighted by 1 / (1 + its brightness): edges against highlights stay smooth
constexpr const char* resolve_fragment_shader = R"glsl(#version 450 core
uniform sampler2DMS samples;
out vec4 radiance;
void main() {
  vec4 sum = vec4(0);
  float weights = 0;
  for (int i = 0; i < 4; ++i) {
    vec4 s = texelFetch(samples, ivec2(gl_FragCoord.xy), i);
    float weight = 1 / (1 + max(s.r, max(s.g, s.b)));
    sum += weight * s;
    weights += weight;
  }
  radiance = sum / weights;
}
)glsl";

}  // namespace umax::raster
