#include "tools/setup/animated_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <utility>

#include "core/base/error.h"
#include "core/model/deformation.h"
#include "embedding/caches/point_cache_reader.h"
#include "embedding/caches/sequence_files.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/distance_grid.h"
#include "embedding/surface/winding.h"

namespace umax {
namespace {

constexpr double largest_cap = 0.02;           // [-] of the surface's area: holes with which a mesh counts as closed
constexpr double share_of_thickness = 0.01;    // [-] of an open mesh's largest extent
constexpr int edge_points_along_extent = 100;  // on sharp edges
constexpr double same_mesh = 0.5;  // [-] of the edges, at least: programs cut polygons into triangles in their own ways

using Edges = std::vector<std::array<int, 2>>;

// each once, by ascending vertices
Edges edges_of(const Triangles& triangles) {
  Edges edges;
  edges.reserve(3 * std::size_t(triangles.rows()));
  for (const auto& corners : triangles.rowwise())
    for (int k = 0; k < 3; ++k) {
      const int from = corners[k], to = corners[(k + 1) % 3];
      edges.push_back({std::min(from, to), std::max(from, to)});
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

// [-] of the edges of either, those that both have
double shared_edges(const Triangles& first, const Triangles& second) {
  const Edges a = edges_of(first), b = edges_of(second);
  Edges both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  const std::size_t most = std::max(a.size(), b.size());
  return most == 0 ? 1 : double(both.size()) / double(most);
}

// Vertices in another order are as many: their faces tell.
void compare_faces(const std::filesystem::path& path, const Triangles& mesh, const Triangles& of_file,
                   std::vector<std::string>& notes) {
  if (mesh.rows() == of_file.rows() && mesh == of_file) return;
  const double shared = shared_edges(mesh, of_file);
  if (shared == 1) return;
  if (shared < same_mesh)
    throw Error(Fault::bad_data,
                {.where = path.string(),
                 .what = "has as many vertices as the mesh, but other faces",
                 .value = fmt::format("{:.0f} % of the edges in common", 100 * shared),
                 .remedy = "give the mesh that was animated, with the same vertices in the same order"});
  notes.push_back(
      fmt::format("{} has {:.0f} % of its edges in common with the mesh; polygons that are cut otherwise do no "
                  "harm, but vertices in another order would move the wrong ones",
                  path.filename().string(), 100 * shared));
}

PointSamples read_folder(const std::filesystem::path& folder, const FileVertices& vertices,
                         std::vector<std::string>& notes) {
  const Eigen::Index num_vertices = vertices.count;
  const std::size_t notes_before = notes.size();
  PointSamples samples{.times = {}, .are_frames = true, .num_vertices = num_vertices, .positions = {}};
  for (const SequenceFile& file : find_sequence(folder)) {
    const TriangleMesh mesh = load_mesh(file.path).mesh;
    if (mesh.num_vertices() != num_vertices)
      throw Error(Fault::bad_data,
                  {.where = file.path.string(),
                   .what = fmt::format("has {} vertices, but the mesh has {}", mesh.num_vertices(), num_vertices),
                   .remedy = "give the mesh that was animated, with the same vertices in the same order"});
    std::vector<std::string> further;  // one note is enough
    compare_faces(file.path, vertices.triangles, mesh.triangles, notes.size() == notes_before ? notes : further);
    samples.times.push_back(file.frame);
    for (const double value : mesh.positions.reshaped<Eigen::RowMajor>()) samples.positions.push_back(float(value));
  }
  return samples;
}

// leaves out what no triangle has
void take_vertices(const FileVertices& vertices, PointSamples& samples) {
  const auto all = std::size_t(samples.num_vertices), used = std::size_t(vertices.count);
  std::vector<float> taken(3 * used * samples.times.size());
  for (std::size_t k = 0; k < samples.times.size(); ++k)
    for (std::size_t v = 0; v < used; ++v)
      std::copy_n(samples.positions.begin() + std::ptrdiff_t(3 * (k * all + std::size_t(vertices.places[v]))), 3,
                  taken.begin() + std::ptrdiff_t(3 * (k * used + v)));
  samples.num_vertices = vertices.count;
  samples.positions = std::move(taken);
}

// what a file says becomes seconds from its first frame
std::vector<double> seconds_of(const CacheSource& cache, const PointSamples& samples, const ClipDescription& clip,
                               std::vector<std::string>& notes) {
  std::vector<double> times;
  const double fps = cache.fps.value_or(clip.fps);
  for (std::size_t k = 0; k < samples.times.size(); ++k) {
    const double since = samples.times[k] - samples.times.front();
    times.push_back(samples.are_frames ? since / fps : cache.fps ? double(k) / fps : since);
  }
  if (is_point_cache(cache.path) && samples.are_frames && !cache.fps)
    notes.push_back(
        fmt::format("{} counts its times in frames, which are taken for the clip's, {:g} a second; "
                    "cache_fps says otherwise",
                    cache.path.filename().string(), fps));
  const int gap = find_gap(times, 1 / clip.fps);
  if (gap < 0) return times;
  throw Error(Fault::bad_data,
              {.where = cache.path.string(),
               .what = fmt::format("has a gap: between frame {} at {:g} s and frame {} at {:g} s", gap + 1,
                                   samples.times[std::size_t(gap)], gap + 2, samples.times[std::size_t(gap) + 1]),
               .remedy = "export the frames in between, or give cache_fps to play the frames evenly"});
}

// the corners that edges ride on, and where
std::shared_ptr<const EdgeRiders> riders_on(const TriangleMesh& mesh, double spacing) {
  std::vector<std::array<int, 2>> ends;
  std::vector<double> shares;
  std::vector<char> taken(std::size_t(mesh.num_vertices()), 0);
  for (const auto& [low, high] : sharp_edges(mesh)) {
    for (const int end : {low, high})
      if (!std::exchange(taken[std::size_t(end)], 1)) ends.push_back({end, end}), shares.push_back(0);
    const double length = (mesh.positions.row(high) - mesh.positions.row(low)).norm();
    const int parts = std::max(1, int(std::ceil(length / spacing)));
    for (int k = 1; k < parts; ++k) ends.push_back({low, high}), shares.push_back(double(k) / parts);
  }
  EdgeRiders riders{VectorXi(Eigen::Index(ends.size())), VectorXi(Eigen::Index(ends.size())),
                    VectorXd(Eigen::Index(ends.size()))};
  for (std::size_t i = 0; i < ends.size(); ++i) {
    riders.from[Eigen::Index(i)] = ends[i][0];
    riders.to[Eigen::Index(i)] = ends[i][1];
    riders.share[Eigen::Index(i)] = shares[i];
  }
  return std::make_shared<const EdgeRiders>(std::move(riders));
}

double area_of(const Points& positions, const Triangles& triangles) {
  double sum = 0;
  for (const auto& corners : triangles.rowwise()) {
    const Vector3d a = positions.row(corners[0]), b = positions.row(corners[1]), c = positions.row(corners[2]);
    sum += 0.5 * (b - a).cross(c - a).norm();
  }
  return sum;
}

// The mesh's triangles, directed outwards, and whether they enclose something but for small holes.
struct Hull {
  Triangles triangles;
  bool is_closed = false;
};
Hull hull_of(const TriangleMesh& mesh) {
  const ClosedSurface surface = close_surface(mesh);
  Hull hull{surface.triangles.topRows(mesh.num_triangles()), false};
  const Triangles caps = surface.triangles.bottomRows(surface.triangles.rows() - mesh.num_triangles());
  hull.is_closed = area_of(surface.positions, caps) <= largest_cap * area_of(mesh.positions, hull.triangles);
  if (surface.volume < 0) hull.triangles.col(1).swap(hull.triangles.col(2));
  return hull;
}

}  // namespace

MeshMotion read_motion(const CacheSource& cache, const FileVertices& vertices, const Eigen::Affine3d& placed_from_own,
                       const ClipDescription& clip, std::vector<std::string>& notes) {
  PointSamples samples = std::filesystem::is_directory(cache.path)
                             ? read_folder(cache.path, vertices, notes)
                             : read_point_cache(cache.path, vertices.num_in_file, vertices.count);
  if (samples.num_vertices != vertices.count) take_vertices(vertices, samples);
  MeshMotion motion{.times = seconds_of(cache, samples, clip, notes),
                    .samples = std::move(samples.positions),
                    .num_vertices = vertices.count,
                    .placed_from_own = placed_from_own};
  for (double& time : motion.times) time = cache.start + (time - cache.offset) / cache.speed;
  const double clip_end = (clip.frames - 1) / clip.fps;
  if (motion.times.size() > 1 && (motion.times.back() <= 0 || motion.times.front() >= clip_end))
    notes.push_back(
        fmt::format("its animation plays from {:.4g} s to {:.4g} s, and the clip from 0 s to {:.4g} s: it does "
                    "not move; cache_start and cache_offset say when it begins",
                    motion.times.front(), motion.times.back(), clip_end));
  return motion;
}

void animate(const TriangleMesh& mesh, MeshMotion motion, std::optional<double> thickness, Obstacle& obstacle,
             std::vector<std::string>& notes) {
  const Hull hull = hull_of(mesh);
  const double extent = (mesh.positions.colwise().maxCoeff() - mesh.positions.colwise().minCoeff()).maxCoeff();
  TriangleShape shape;
  shape.surface = std::make_shared<const RestSurface>(make_rest_surface(mesh.positions, hull.triangles));
  if (shape.surface->triangles.rows() == 0)
    throw Error(Fault::bad_data,
                {.where = "mesh", .what = "has no triangles with area", .remedy = "give another mesh"});
  shape.is_closed = hull.is_closed;
  shape.thickness = thickness.value_or(hull.is_closed ? 0 : share_of_thickness * extent);
  if (!hull.is_closed && !thickness)
    notes.push_back(fmt::format(
        "its mesh is open: both of its sides push, as a sheet of {:.2g} m; thickness says otherwise", shape.thickness));
  if (hull.is_closed) shape.edge_points = riders_on(mesh, extent / edge_points_along_extent);
  obstacle.shape = shape;
  obstacle.deformation = std::make_shared<const Deformation>(std::move(motion), std::move(shape));
}

}  // namespace umax
