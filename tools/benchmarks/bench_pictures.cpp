// Figures of the path tracer: its rays against bare library calls, and one picture against Blender's Cycles.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <regex>
#include <stdexcept>

#include "core/base/median.h"
#include "embedding/mesh_files/mesh_io.h"
#include "embedding/surface/normals.h"
#include "embedding/surface/placement.h"
#include "embedding/surface/shapes.h"
#include "render/image/image_io.h"
#include "render/trace/path_trace.h"
#include "tools/benchmarks/bench.h"
#include "tools/system/seconds_since.h"
#include "tools/system/subprocess.h"

namespace umax {
namespace {

TriangleMesh standing_armadillo() {
  MeshFile file = load_mesh(model_path("armadillo.obj"));
  Placement placement;
  placement.height = 2;
  place(file.mesh, placement);
  file.mesh.positions.col(1).array() -= file.mesh.positions.col(1).minCoeff();
  compute_normals(file.mesh);
  return file.mesh;
}

TriangleMesh ball_on_ground() {
  TriangleMesh ball = make_sphere(0.9, 7);
  ball.positions.col(1).array() += 0.9;
  compute_normals(ball);
  return ball;
}

// the scene of tools/benchmarks/bench_cycles.py: Blender's (x, y, z) is our (x, z, -y)
RenderScene comparison_scene(TriangleMesh body) {
  RenderScene scene;
  Look body_look, ground_look;
  body_look.base_color = {0.55f, 0.25f, 0.12f};
  body_look.roughness = 0.4f;
  body_look.ior = 1.5f;  // F0 = 0.04, as specular = 0.5 there
  ground_look.base_color = {0.5f, 0.5f, 0.5f};
  ground_look.roughness = 0.9f;
  ground_look.ior = 1.5f;  // F0 = 0.04, as specular = 0.5 there
  scene.objects.push_back({"body", std::make_shared<TriangleMesh>(std::move(body)), body_look});
  scene.objects.push_back({"ground", std::make_shared<TriangleMesh>(make_plane(40)), ground_look});
  const Vector3f centre(3, 5, 3), towards = (Vector3f(0, 1, 0) - centre).normalized();
  const Vector3f right = towards.cross(Vector3f::UnitY()).normalized(), up = right.cross(towards);
  AreaLight light;
  light.edge_u = 2 * up, light.edge_v = 2 * right;  // cross(u, v) looks along `towards`
  if (light.edge_u.cross(light.edge_v).dot(towards) < 0) std::swap(light.edge_u, light.edge_v);
  light.corner = centre - 0.5f * (light.edge_u + light.edge_v);
  light.radiance = Vector3f::Constant(600.0f / 16);  // Cycles: power over four times the area
  scene.lights.push_back(light);
  scene.sky = ConstantSky{{0.35f, 0.45f, 0.6f}};
  scene.camera.position = {0, 1.6f, 5.5f};
  scene.camera.target = {0, 0.9f, 0};
  scene.camera.vertical_fov_degrees = 22.8952f;  // 50 mm lens on a 36 mm wide sensor at 16:9
  return scene;
}

BenchRows rays() {
  const RenderScene scene = comparison_scene(model_path("").empty() ? ball_on_ground() : standing_armadillo());
  const RayScene hierarchy(scene);
  PathTraceOptions options{.width = 320, .height = 180, .samples = 4};
  RayRecording recording;
  options.recording = &recording;
  path_trace(hierarchy, scene, options);
  options.recording = nullptr;
  std::vector<double> traced, replayed;
  ReplayResult replay;
  for (int i = 0; i < 5; ++i) {
    const auto start = std::chrono::steady_clock::now();
    path_trace(hierarchy, scene, options);
    traced.push_back(seconds_since(start));
    replay = hierarchy.replay(recording);
    replayed.push_back(replay.seconds);
  }
  const double ratio = median(replayed) / median(traced);
  return {{"path tracer's rays per second against bare calls",
           fmt::format("{:.3f}, {:.2f} of {:.2f} Mrays/s, checksum {:016x}", ratio,
                       double(replay.num_rays) / median(traced) / 1e6, double(replay.num_rays) / median(replayed) / 1e6,
                       replay.checksum),
           ">= 0.6", ratio >= 0.6}};
}

double root_mean_square(const Image& a, const Image& b) {
  if (a.values.size() != b.values.size()) throw std::runtime_error("pictures differ in size");
  double sum = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) sum += std::pow(double(a.values[i]) - double(b.values[i]), 2);
  return std::sqrt(sum / double(a.values.size()));
}

// keeps three channels
Image rgb(const Image& image) {
  Image three(image.width, image.height, 3);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) std::copy_n(image.pixel(x, y), 3, three.pixel(x, y));
  return three;
}

// seconds that Cycles says it took; the picture is at `path`
double run_cycles(const std::filesystem::path& path, int samples, int width, int height, int seed = 1) {
  const char* source = std::getenv("UMAX_SOURCE");
  if (!source) throw std::runtime_error("run this one through tools/bench");
  const ProcessResult result = run_process({"blender", "-b", "--factory-startup", "-P",
                                            std::string(source) + "/tools/benchmarks/bench_cycles.py", "--",
                                            model_path("armadillo.obj"), std::to_string(samples), "2", path.string(),
                                            std::to_string(width), std::to_string(height), std::to_string(seed)});
  std::smatch match;
  if (!std::regex_search(result.output, match, std::regex("SECONDS ([0-9.]+)")))
    throw std::runtime_error("blender did not render: " + result.messages);
  return std::stod(match[1]);
}

Image ours(int samples, int width, int height, unsigned seed, double& seconds, const std::filesystem::path& path) {
  const TriangleMesh body = standing_armadillo();
  const auto start = std::chrono::steady_clock::now();
  const RenderScene scene = comparison_scene(body);
  const TracedImage traced =
      path_trace(scene, {.width = width, .height = height, .samples = samples, .bounces = 4, .seed = seed});
  write_exr(path, {{"", traced.color}});
  seconds = seconds_since(start);
  return traced.color;
}

BenchRows cycles() {
  if (!find_program("blender")) return {{"picture against Cycles", "skipped: blender is not here", "", true}};
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  const std::filesystem::path our_file = folder / "umax-bench-ours.exr", their_file = folder / "umax-bench-cycles.exr";
  std::vector<double> ours_seconds, their_seconds;
  for (int i = 0; i < 3; ++i) {
    double seconds = 0;
    ours(16, 1280, 720, 1, seconds, our_file);
    ours_seconds.push_back(seconds);
    their_seconds.push_back(run_cycles(their_file, 16, 1280, 720));
  }
  const double ratio = median(ours_seconds) / median(their_seconds);
  return {at_most("armadillo 1280x720, 16 samples: seconds over Cycles'", ratio, 1, "x",
                  fmt::format("{:.2f} s against {:.2f} s", median(ours_seconds), median(their_seconds)))};
}

// each against its own converged picture, in a smaller format
BenchRows cycles_noise() {
  if (!find_program("blender")) return {{"noise against Cycles", "skipped: blender is not here", "", true}};
  const std::filesystem::path folder = std::filesystem::temp_directory_path();
  const std::filesystem::path file = folder / "umax-bench-noise.exr";
  constexpr int width = 320, height = 180;
  double seconds = 0;
  const Image our_reference = ours(4096, width, height, 2, seconds, file);
  const double our_noise = root_mean_square(ours(16, width, height, 1, seconds, file), our_reference);
  run_cycles(file, 4096, width, height);
  const Image their_reference = rgb(read_image(file));
  run_cycles(file, 16, width, height);
  const double their_noise = root_mean_square(rgb(read_image(file)), their_reference);
  return {at_most("armadillo 320x180, 16 samples: RMSE over Cycles'", our_noise / their_noise, 1, "x",
                  fmt::format("{:.5f} against {:.5f}; converged ones {:.5f} apart", our_noise, their_noise,
                              root_mean_square(our_reference, their_reference)))};
}

// What a picture of the same noise takes: seconds and variance of 16 samples, as time grows with samples and variance falls
// with them. The references have an equal share of noise of their own, which leaves the ratio as it is.
BenchRows cycles_same_noise() {
  if (!find_program("blender")) return {{"time to the noise of Cycles", "skipped: blender is not here", "", true}};
  const std::filesystem::path file = std::filesystem::temp_directory_path() / "umax-bench-same-noise.exr";
  constexpr int width = 1280, height = 720, samples = 16, reference_samples = 256;
  double seconds = 0, our_seconds = 0;
  const Image our_reference = ours(reference_samples, width, height, 2, seconds, file);
  const double our_noise = root_mean_square(ours(samples, width, height, 1, our_seconds, file), our_reference);
  run_cycles(file, reference_samples, width, height, 2);
  const Image their_reference = rgb(read_image(file));
  const double their_seconds = run_cycles(file, samples, width, height);
  const double their_noise = root_mean_square(rgb(read_image(file)), their_reference);
  const double variance_ratio = our_noise * our_noise / (their_noise * their_noise);
  return {at_most("armadillo 1280x720: seconds to the same RMSE over Cycles'",
                  our_seconds / their_seconds * variance_ratio, 0.3, "x",
                  fmt::format("16 samples: {:.2f} s, RMSE {:.5f}, against {:.2f} s, {:.5f}", our_seconds, our_noise,
                              their_seconds, their_noise))};
}

}  // namespace

std::vector<Benchmark> picture_benchmarks() {
  return {{"rays", false, false, rays},
          {"cycles", false, true, cycles},
          {"cycles-noise", true, true, cycles_noise},
          {"cycles-same-noise", true, true, cycles_same_noise}};
}

}  // namespace umax
