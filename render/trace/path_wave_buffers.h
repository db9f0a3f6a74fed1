// The rows that a wave of paths works on. path_wave.cpp leads the paths on their way, path_wave_light.cpp adds the light.
#pragma once

#include <array>
#include <vector>

#include "render/trace/path_rows.h"
#include "render/trace/path_wave.h"

namespace umax {

// pairs of dimensions of the sample points: a path's first ones, then a block for each vertex
enum Dimension { dim_filter, dim_lens, dims_of_camera };
constexpr int dim_time = SampleSequence::max_dimensions - 1;
enum VertexDimension { dim_light, dim_sky, dim_scatter, dim_roulette, dims_of_vertex };

// of the paths that enter bodies, beside the vertices' own
constexpr int matter_bounces = 24;
constexpr int matter_dimension(int bounce) {
  return dim_time - 1 - bounce % matter_bounces;
}

// what becomes of a path at a surface under which there is matter
enum class Fate { stays, comes_out, passes };
// what a path tells of what it meets after it has only passed through clear matter
enum class Sight { none, blurred, sharp };

struct PathWave::Buffers {
  explicit Buffers(const PathTracer& tracer_) : tracer(tracer_) {}

  const PathTracer& tracer;
  std::vector<RecordedRay>* recording = nullptr;
  int count = 0;  // paths still on their way; theirs are the first entries of everything below

  // of a path
  rows::RowOf<std::uint32_t> reversed_index, block_key;
  rows::RowOf<int> slot;  // place of its result
  rows::RayRows ray;
  rows::ColorRows throughput;
  rows::Row density;  // [1/sr] with which the ray's direction was chosen
  rows::RowOf<Sight> sight;
  std::array<PathResult, rows::capacity> results;
  std::array<FirstPart, rows::capacity> first_parts;

  // of the surface that it met
  rows::HitRows hit;
  SurfacePoints surface_points;
  SurfacePointRows point;
  LightMetRows met;
  LightRows light;
  rows::DirectionRows light_radiance;
  rows::Row u, v;
  rows::LookRows look;
  rows::FrameRows frame;
  rows::SurfaceRows surface;
  rows::DirectionRows direction, cosine, mirrored;
  rows::ColorRows value;
  rows::Row value_density, choice_again, choice_alpha, weight;
  rows::RowOf<int> goes_on;

  // of paths that enter bodies
  rows::RowOf<Fate> fate;
  rows::Row inner_u, inner_v;
  rows::RayRows beyond;  // of paths that pass
  rows::ColorRows beyond_throughput;

  // rays towards lights
  rows::RayRows shadow;
  rows::RowOf<int> shadow_of, blocked;

  // --- camera
  void start(const std::vector<PathStart>& starts);
  void start_rays(const CameraView& view);
  void start_moving_rays();
  void draw(int dimension, rows::Row& to_u, rows::Row& to_v) const;
  // --- rays
  void meet_surfaces(bool from_camera);
  void find_blocked(int num_shadows, bool coherent);
  // --- light that a ray itself meets
  void add_emissions(bool from_camera);
  void add_sky(int i, bool from_camera);
  void add_rectangle(int i, bool from_camera);
  Vector3f sky_seen(int i) const;
  Vector3f behind_everything(int i) const;
  void fade_out();
  void add_last_emission();
  // --- surfaces
  void prepare_surfaces(bool first);
  void look_up();
  void evaluate_directions();
  // --- matter below surfaces
  void enter_matter(int bounce);
  void choose_fate(int i, const Matter& matter, int bounce);
  void walk(int i, const Matter& matter, const Vector3f& base, int bounce);
  void pass(int i, const Matter& matter, int bounce);
  void go_through();
  void guide_through();
  void fade_through();
  // --- lights that are looked for
  void add_lights(int vertex_dimension, bool first);
  void add_light_samples(bool first);
  // --- the next direction
  void scatter(int vertex_dimension, bool first);
  void turn(bool first);
  // --- which paths go on
  template <class GoesOn>
  void keep(const GoesOn& goes) {
    int kept = 0;
    for (int i = 0; i < count; ++i) {
      if (!goes(i)) continue;
      if (kept != i) {
        reversed_index[kept] = reversed_index[i];
        block_key[kept] = block_key[i];
        slot[kept] = slot[i];
        ray.copy(kept, i, ray);
        throughput.set(kept, throughput.at(i));
        density[kept] = density[i];
        sight[kept] = sight[i];
        hit.copy(kept, i);
      }
      ++kept;
    }
    count = kept;
  }
};

}  // namespace umax
