// Point caches of other programs, read whole: the formats of point_cache.h.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace umax {

/// Positions of all vertices at some instants, as a file has them.
struct PointSamples {
  std::vector<double> times;      // [s], or [frames] where the file counts these; strictly increasing
  bool are_frames = false;        // the times are frames
  Eigen::Index num_vertices = 0;  // #V
  std::vector<float> positions;   // one instant after another, #V x 3
};

/// Whether the file is a point cache by its name: .pc2 or .mdd.
bool is_point_cache(const std::filesystem::path& path);

/// Throws Error: not_found, io_error; bad_data that says what is wrong: not of the format, cut off, longer than it says,
/// without frames, of another number of vertices, times that do not increase, coordinates that are not finite. A PC2's
/// `sampling` of half a second and more is in frames, as most programs write it. num_used: of the mesh file's vertices those
/// that it may be of as well, as programs write it that drop vertices without a triangle; -1: all are.
PointSamples read_point_cache(const std::filesystem::path& path, Eigen::Index num_vertices, Eigen::Index num_used = -1);

/// Throws Error (bad_data) naming the vertex unless all of the instant's coordinates are finite.
void require_finite_sample(const std::filesystem::path& path, const PointSamples& samples, std::size_t instant);

/// The first of two neighbouring instants that are farther apart than one and a half times what is usual, and than that
/// many `frame` (in the unit of the times); -1: none.
int find_gap(const std::vector<double>& times, double frame);

}  // namespace umax
