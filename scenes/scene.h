// What is to be simulated and shown, as a scene file describes it; every default of the program stands here.
#pragma once

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/model/model.h"
#include "core/problem/step_options.h"
#include "embedding/maps/factor_map.h"
#include "render/scene/render_scene.h"

namespace umax {

struct ClipDescription {
  int frames = 120;                                // frame 1 is the initial state
  double fps = 60;                                 // [1/s]
  int substeps = 1;                                // time steps a frame
  Track<Vector3d> gravity{Vector3d(0, -9.81, 0)};  // [m/s^2]
  bool allow_overlap = false;                      // bodies that are deep inside each other at the start
  std::filesystem::path pulls;                     // absolute: what a live session pulled bodies by; empty: nothing
  std::string pulls_sha256;                        // filled when the scene is read
  double preroll = 0;  // [s] before the first frame, in which pins lead from rest to where they are at time 0
  double time_step() const { return 1.0 / (fps * substeps); }
};

struct MeshSource {
  std::filesystem::path path;     // absolute once resolved
  std::optional<double> unit;     // [m] length of one file unit; unset: the file's own, else 1
  std::optional<std::string> up;  // "x", "y", "z", or with a sign, "-z"; unset: the file's own, else "y"
  std::string sha256;             // of the file, filled when the scene is read
  std::string from;               // where the file is had, for the message when it is missing
};
/// An animation that another program has made, and when it plays: its instant t is at the clip's time
/// start + (t - its first instant - offset) / speed.
struct CacheSource {
  std::filesystem::path path;  // absolute: PC2, MDD, or a folder of OBJ or PLY files; empty: none
  double start = 0;            // [s] of the clip
  double speed = 1;            // [-]
  double offset = 0;           // [s] of the animation
  std::optional<double> fps;   // [1/s] of its frames; unset: as its file says, else the clip's
  std::string sha256;          // filled when the scene is read
};
struct BoxShape {
  Vector3d size{1, 1, 1};  // [m]
};
struct SphereShape {
  double radius = 1;  // [m]
};
struct CylinderShape {
  double radius = 0.06, length = 1;  // [m] axis along x
};
struct RingShape {
  double radius = 0.5, thickness = 0.2;  // [m] around z, of the circle in the middle of its thickness
};
struct FigureShape {};  // the built-in character, 2 m tall unless height is given
using BodySource = std::variant<MeshSource, BoxShape, SphereShape, CylinderShape, RingShape, FigureShape>;

struct CageDescription {
  enum class Clip { filled, box };  // cells that touch the solid, or the whole grid
  // wanted number of cells, grid of the bounding box, cell edge [m]; or a file of hexes in the body's own units and
  // axes
  std::variant<int, Vector3i, double, MeshSource> size = 365;
  Clip clip = Clip::filled;  // of cells
};

/// Factors on one of a body's values, from a file or from the paint of its own mesh.
struct MapSource {
  bool own_paint = false;            // the colours of the body's own mesh
  std::filesystem::path path;        // absolute: OpenVDB, or a mesh with vertex colours; else empty
  std::string grid;                  // of an OpenVDB file; empty: its only float grid
  std::optional<FactorRange> range;  // factors at 0 (black) and 1 (white); unset: FactorRange() for colours, and the
                                     // numbers of a grid are the factors
  std::string sha256;                // of the file, filled when the scene is read

  bool is_set() const { return own_paint || !path.empty(); }
  bool is_grid() const { return is_vdb_file(path); }
};

struct FixedBox {
  Vector3d min, max;
};  // [m] world coordinates of the initial placed shape

struct BodyDescription {
  std::string name;
  BodySource source = FigureShape{};
  std::optional<double> height;        // [m] scale so that the placed shape is this tall
  std::optional<double> scale;         // [-]
  Vector3d rotation_degrees{0, 0, 0};  // about world X, then Y, then Z
  std::optional<Vector3d> position;    // [m] centre of the placed bounding box
  std::optional<double> drop_height;   // [m] lowest point above the highest obstacle below
  Vector3d velocity{0, 0, 0};          // [m/s]
  Vector3d spin_degrees{0, 0, 0};      // [deg/s] world axes
  Track<double> friction{0.5};
  ContactWith contact = ContactWith::all;
  CageDescription cage;
  MaterialOptions material;
  EnergyLimitOptions limit;
  PartLimitOptions part_limits;
  MapSource young_map, limit_map;
  MapSource fibre_map;  // of directions
  std::vector<FixedBox> fixed;
  Look look;                           // texture is loaded by the program from texture_path
  std::filesystem::path texture_path;  // empty: the mesh file's own colour texture, if any

  /// Whether the mesh is a file of hexes, which are then the cage.
  bool brings_its_hexes() const;
};

/// Points of a body that follow keyframes or an animation.
struct PinDescription {
  struct Box {
    std::optional<Vector3d> min, max;  // [m] world coordinates of the initial placed shape
  };
  struct Sphere {
    std::optional<Vector3d> centre;  // [m] likewise
    std::optional<double> radius;    // [m]
  };
  std::string body, name;
  Box box;  // which points; one of these four
  Sphere sphere;
  std::filesystem::path map;  // absolute: a painted mesh; empty: none
  MeshSource inside;          // a mesh in the body's own units and axes; path empty: none
  std::string map_sha256;     // filled when the scene is read
  std::optional<Track<Vector3d>> position, rotation_degrees;  // by how much they are moved, turned about the pivot
  std::optional<Vector3d> pivot;                              // [m] unset: the middle of the points
  CacheSource cache;
  std::optional<double> from, until;  // [s] unset: from the beginning, to the end
  std::optional<double>
      stiffness;  // [N/m] of a spring on each point; unset: exact, and of a map's half weight the hex's own
};

/// make_bowl() in embedding/surface/shapes.h.
struct BowlShape {
  double radius = 1, thickness = 0.1;  // [m]
};

struct ObstacleDescription {
  std::string name;
  std::variant<HalfSpace, Ball, Block, BowlShape, MeshSource> shape = HalfSpace{};
  std::optional<double> height, scale;  // of a mesh
  CacheSource cache;                    // of where the mesh's vertices go
  std::optional<double> thickness;  // [m] of a mesh that is animated; unset: none, of an open one a share of its size
  double friction = 0;
  Track<Vector3d> position{Vector3d(0, 0, 0)};
  Track<Vector3d> rotation_degrees{Vector3d(0, 0, 0)};
  bool visible = true;
  bool shadow_catcher = false;  // pictures show the shadows on it alone (embree)
  std::optional<double> fade;   // [m] of a plane: where it has passed into the horizon; unset: it ends far away
  Look look;
};

/// An exception to what two bodies say, or a body of itself, where the same name stands twice.
struct PairDescription {
  std::string name;
  std::array<std::string, 2> bodies;
  bool touch = true;
  std::optional<double> friction;  // [-] unset: the larger of the two
};

struct ProbeDescription {
  std::string name, body;
  Vector3d point{0, 0, 0};  // [m] world coordinates of the initial placed shape
};

struct MovingCamera;  // embedding/cameras

struct CameraDescription {
  std::optional<Track<Vector3d>> position, target;  // [m]; unset: chosen to frame the whole motion
  Track<double> vertical_fov_degrees{35.0};
  Track<double> aperture_radius{0.0}, focus_distance{0.0};  // [m]
  std::filesystem::path file;                               // glTF or USD text that it comes from; empty: none
  std::string name;                                         // of the camera in the file; empty: its only one
  std::optional<double> start;                      // [s] of the file's animation when the clip begins; unset: its own
  std::shared_ptr<const MovingCamera> motion = {};  // what the program reads from the file

  bool moves() const {
    const auto changes = [](const auto& track) { return !track.is_constant(); };
    return motion || (position && changes(*position)) || (target && changes(*target)) ||
           changes(vertical_fov_degrees) || changes(aperture_radius) || changes(focus_distance);
  }
};

struct LightDescription {
  std::string name;
  Track<Vector3d> position{Vector3d(3, 5, 3)}, target{Vector3d(0, 1, 0)};  // [m]
  Track<double> size{2.0};                                                 // [m] edge of the square
  Track<double> power{600.0};                                              // [W] radiance = power / (pi area)
  Track<Vector3d> color{Vector3d(1, 1, 1)};
};

enum class RenderEngine { embree, osmesa };
enum class Heatmap {
  none,
  energy,      // U/U_max
  multiplier,  // lambda/U_max
  stretch,     // sqrt(2 U/(Y V))
};
/// What NNNN.exr can hold beside the colour, for compositing.
enum class PictureLayer { albedo, normal, depth, position, vector, object, energy, cryptomatte, noise };
/// How pictures place a surface in its cage.
enum class SurfaceKernel {
  trilinear,  // as physics does
  smooth,     // without creases where cells meet
};
/// What takes the noise out of pictures (embree).
enum class NoiseFilter {
  none,
  spatial,   // of each picture by itself
  temporal,  // with the pictures around it, where they show the same
};
struct RenderDescription {
  RenderEngine engine = RenderEngine::embree;
  int width = 1280, height = 720;  // [px]
  int samples = 64;                // paths a pixel (embree), at most where noise is given
  double noise = 0;                // [-] standard error that is enough (embree); 0: all samples are taken
  int bounces = 4;
  NoiseFilter denoise = NoiseFilter::temporal;
  bool preview = false;  // as fast as it goes (embree): few paths and bounces
  unsigned seed = 1;
  Heatmap heatmap = Heatmap::none;
  std::optional<double> heatmap_top;  // where the bar of multiplier and stretch ends, in its unit; unset: chosen
  bool wireframe = false;             // cage over the picture (osmesa)
  bool exr = false;                   // NNNN.exr beside NNNN.png, with what guides the filter
  std::vector<PictureLayer> layers;   // of NNNN.exr (embree), in the order of the enum; none: as exr says
  bool transparent = false;           // alpha in place of sky and backdrop (embree)
  Sky sky = GradientSky{};
  SurfaceKernel surface = SurfaceKernel::trilinear;  // of bodies in cages of equal cells
  double shutter = 0;                                // [frames] that it stays open (embree); 0: nothing blurs
  double shutter_position = 0.5;   // [-] of the frame's own time while it is open: 0 at the start, 1 at the end
  std::filesystem::path sky_path;  // HDR or EXR for an EnvironmentMap
  std::optional<Vector3f> backdrop;
  double exposure_stops = 0;

  bool has_layer(PictureLayer layer) const { return std::find(layers.begin(), layers.end(), layer) != layers.end(); }
  bool writes_exr() const { return exr || !layers.empty(); }
};

struct Scene {
  std::string name;         // stem of the file, or the built-in's name
  std::string description;  // one line, for `umax scenes`
  ClipDescription clip;
  SolverOptions solver;
  std::vector<BodyDescription> bodies;  // in order of name: no result depends on a file's order
  std::vector<ObstacleDescription> obstacles;
  std::vector<PinDescription> pins;
  std::vector<PairDescription> pairs;
  std::vector<ProbeDescription> probes;
  CameraDescription camera;
  std::vector<LightDescription> lights;
  RenderDescription render;
  bool wants_lights =
      false;  // its file names neither a light nor a sky: it gets those of a studio when bodies are placed
};

}  // namespace umax
