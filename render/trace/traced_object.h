// An object in the form that rays are traced against and surfaces are looked up in.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "render/scene/ray.h"
#include "render/scene/render_scene.h"

namespace umax {

/// Even times at which vertices are known: between two of them they go straight, before and after all they rest.
struct InstantTimes {
  int num_instants = 1;
  float first = 0, segments_per_time = 0;
  struct Place {
    int segment = 0;
    float share = 0;  // of the instant after it
  };
  Place at(float time) const {
    if (num_instants == 1) return {};
    const float position = std::clamp((time - first) * segments_per_time, 0.0f, float(num_instants - 1));
    const int segment = std::min(int(position), num_instants - 2);
    return {.segment = segment, .share = position - float(segment)};
  }
  float time_of(int instant) const { return first + float(instant) / segments_per_time; }
};

struct TracedObject {
  // a vertex in half a cache line; the ray library reads the position in place
  struct alignas(32) Vertex {
    float position[3], unused = 0;
    float normal[3], unused2 = 0;
  };
  struct Corners {
    unsigned index[3];
    bool operator==(const Corners&) const = default;
  };
  // a vertex's place among the instants
  struct Instant {
    std::size_t before = 0, after = 0;  // where their vertices start
    float share = 0;                    // of the one after
  };

  std::vector<Vertex> vertices;  // of all instants, one after the other
  std::size_t num_vertices = 0;  // of one
  InstantTimes instants;
  std::vector<Corners> triangles;
  std::vector<Vector3f> colors;               // per vertex, or empty
  std::vector<Vector2f> texture_coordinates;  // per triangle corner, or empty
  std::vector<int> paint;                     // per triangle, or empty: the first
  std::vector<Paint> paints;
  bool has_normals = false;

  bool is_moving() const { return instants.num_instants > 1; }
  Instant at(float time) const;
  /// Normal of a triangle, not of unit length, on the side from which its corners run counter-clockwise.
  Vector3f face(unsigned triangle, float time) const;
  /// Where a point of it is.
  Vector3f position_on(const Hit& hit, float time) const;
  /// The colour of the triangle's paint, by texture or vertices where it has them; first_share: barycentric weight of the first corner.
  Vector3f color_at(unsigned triangle, float first_share, float u, float v) const;

 private:
  Vector3f corner(unsigned triangle, int c, const Instant& instant) const;
};

/// Throws Error 65 for indices out of range, positions that are not finite, and instants of another number of vertices.
TracedObject make_traced_object(const RenderObject& object);

}  // namespace umax
