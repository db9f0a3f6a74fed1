// What is drawn: triangle meshes with looks, lights, sky and a camera. Knows nothing of lattices or states.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/base/triangle_mesh.h"
#include "render/image/image.h"

namespace umax {

/// Colour of one of a mesh's materials.
struct Paint {
  Vector3f base_color{0.6f, 0.6f, 0.6f};      // linear Rec. 709 reflectance
  std::shared_ptr<const Image> texture = {};  // linear RGB, multiplies base_color
  std::string name = {};                      // of the material; empty: the object's
};

/// Diffuse base under a glossy dielectric (or metallic) layer and an optional clear coat. In closed meshes, light may
/// enter what lies under that layer: clear matter (`transmission`), cloudy matter (`subsurface`).
struct Look {
  Vector3f base_color{0.6f, 0.6f, 0.6f};  // linear Rec. 709 reflectance
  float roughness = 0.5f;                 // [0, 1] perceptual: alpha = roughness^2
  float ior = 1.5f;                       // of the dielectric layer
  float metallic = 0;                     // [0, 1]
  float clearcoat = 0;                    // [0, 1]
  float clearcoat_roughness = 0.03f;
  float transmission = 0;           // [0, 1] share of the base that light passes through, bent by `ior`
  float transmission_depth = 0.1f;  // [m] of matter after which that light has the base's colour
  float subsurface = 0;             // [0, 1] share of the rest of the base in which light wanders
  Vector3f subsurface_radius{0.01f, 0.005f, 0.003f};  // [m] that it goes between two turns, of red, green and blue
  std::shared_ptr<const Image> texture =
      {};                          // linear RGB, multiplies base_color where the mesh has texture coordinates
  std::vector<Paint> paints = {};  // in place of base_color and texture: of each of the mesh's materials
  std::string material = {};       // its name where there are no paints; empty: the object's
  bool vertex_colors = false;      // the mesh's colors replace base_color (heat maps, painted meshes)

  bool lets_light_in() const { return transmission > 0 || subsurface > 0; }
};

/// Where a surface is while the shutter is open: at `instants.size()` even times from `first` to `last`, in which 0 is
/// when the shutter opens and 1 when it closes; in between its points go straight. [first, last] contains [0, 1].
struct SurfaceMotion {
  float first = 0, last = 1;
  std::vector<std::shared_ptr<const TriangleMesh>> instants{};  // vertices and normals of the object's mesh, at least
                                                                // two; none: it stands still
};

/// A ground that passes into what is seen at the horizon behind it: no edge shows where it ends.
struct Fade {
  Vector3f center{0, 0, 0};  // [m]
  float begin = 0, end = 1;  // [m] from the centre: all of the surface is seen, nothing of it
  /// The share of the surface that is not seen: smooth, 0 to 1.
  float at(const Vector3f& place) const {
    const float s = std::clamp(((place - center).norm() - begin) / std::max(end - begin, 1e-6f), 0.0f, 1.0f);
    return s * s * (3 - 2 * s);
  }
};

struct RenderObject {
  std::string name;
  std::shared_ptr<const TriangleMesh> mesh;  // world space [m]
  Look look;
  SurfaceMotion motion = {};  // path tracer
  // its vertices one frame before and after, for motion vectors; null: where they are now
  std::shared_ptr<const TriangleMesh> previous = {}, next = {};
  std::vector<float> values = {};  // a number of each vertex, for a layer of its own, or empty
  bool catches_shadows = false;    // seen only where other objects keep light from it (path tracer)
  std::optional<Fade> fade = {};   // how the camera sees it; not where it catches shadows, nor in a transparent picture

  /// Whether each material of the mesh has a paint of its own.
  bool has_paints() const {
    return !look.paints.empty() && mesh->materials.size() == std::size_t(mesh->num_triangles());
  }
  /// What the triangles show: by material where has_paints(), else one for all.
  std::vector<Paint> paints() const {
    return has_paints() ? look.paints : std::vector<Paint>{{look.base_color, look.texture, look.material}};
  }
};

/// Rectangle that emits on the side of cross(edge_u, edge_v).
struct AreaLight {
  Vector3f corner{0, 0, 0}, edge_u{1, 0, 0}, edge_v{0, 0, 1};  // [m]
  Vector3f radiance{1, 1, 1};                                  // [W/(m^2 sr)]
  bool visible = false;                                        // to camera rays
};
struct ConstantSky {
  Vector3f radiance{0.35f, 0.45f, 0.6f};
};
/// Analytic daylight sky with a sun disc.
struct DaylightSky {
  Vector3f sun_direction{0.4f, 0.8f, 0.45f};  // towards the sun, normalised by the renderer
  float turbidity = 3;
  float intensity = 1;             // scales sky and sun
  float sun_size_degrees = 0.53f;  // angular diameter; larger softens shadows
};
/// Latitude-longitude picture: row 0 is +Y, u = 0 looks along +Z, u = 0.25 along +X.
struct EnvironmentMap {
  std::shared_ptr<const Image> image;
  float intensity = 1;
  float rotation_degrees = 0;  // about Y
};
/// Studio backdrop: horizon and zenith colours blended by elevation.
struct GradientSky {
  Vector3f horizon{0.9f, 0.9f, 0.9f}, zenith{0.4f, 0.5f, 0.7f}, ground{0.3f, 0.3f, 0.3f};
};
using Sky = std::variant<ConstantSky, GradientSky, DaylightSky, EnvironmentMap>;

struct Camera {
  Vector3f position{0, 1.6f, 5.5f}, target{0, 0.9f, 0}, up{0, 1, 0};
  float vertical_fov_degrees = 35;
  float aperture_radius = 0;  // [m] thin lens; 0: pinhole
  float focus_distance = 0;   // [m]; 0: the target's
};

/// Line segments drawn over the rasteriser's picture (the cage).
struct WireOverlay {
  std::vector<std::pair<Vector3f, Vector3f>> segments;  // world space [m]
  Vector3f color{0.05f, 0.05f, 0.08f};
  float width_pixels = 1.2f;
  bool hidden_lines = false;  // also draw, fainter, what lies behind surfaces
};
/// Colour bar for vertex colours that mean numbers.
struct Legend {
  std::string title;  // "U / U_max"
  double low = 0, high = 1;
  bool ends_at_limit = false;  // high is a limit: the red of color_of_value() from there on, apart from the bar
  double slack = 0;            // [-] of the bar: so near its end a limit counts as reached
  bool logarithmic = false;    // even in log(value) or, from low = 0 on, in log(1 + value); low >= 0
};

/// Words over the picture; (x, y) in [0, 1] from the top left is the middle of their upper edge.
struct Caption {
  std::string text;
  float x = 0.5f, y = 0.9f;
};

struct RenderScene {
  std::vector<RenderObject> objects;
  std::vector<AreaLight> lights;
  Sky sky = ConstantSky{};
  std::optional<Vector3f> backdrop;  // colour camera rays see instead of the sky
  Camera camera;
  std::vector<Camera> camera_path{};  // at even times from the shutter's opening to its closing, at least two; none: it
                                      // stands still (path tracer)
  // one frame before and after, for motion vectors; none: as now
  std::optional<Camera> previous_camera = {}, next_camera = {};
  float moment = 0;          // of the picture itself, while the shutter is open: what is not blurred is seen then
  bool transparent = false;  // the camera sees neither sky nor backdrop (path tracer)
  std::optional<WireOverlay> wires;
  std::optional<Legend> legend;
  std::vector<Caption> captions{};
  float exposure_stops = 0;  // applied when an 8-bit picture is made
};

/// Whether a ground passes into the horizon: then what lies behind it is seen below the horizon, too.
inline bool has_fade(const RenderScene& scene) {
  return !scene.transparent && std::any_of(scene.objects.begin(), scene.objects.end(), [](const RenderObject& object) {
    return object.fade && !object.catches_shadows;
  });
}
/// The direction in which a camera sees what lies behind a ground that fades: of all below the horizon, just above it.
inline Vector3f at_or_above_horizon(const Vector3f& direction) {
  constexpr float lowest = 0.002f;
  return direction[1] < lowest ? Vector3f(Vector3f(direction[0], lowest, direction[2]).normalized()) : direction;
}

}  // namespace umax
