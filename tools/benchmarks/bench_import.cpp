// What it costs that foreign mesh formats are read by a program of their own.
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "embedding/foreign_files/foreign_file.h"
#include "embedding/mesh_files/foreign_mesh.h"
#include "tools/benchmarks/bench.h"
#include "tools/system/seconds_since.h"

namespace umax {
namespace {

constexpr int side = 708;  // quads: a million triangles

template <class T>
std::string raw(T value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

Eigen::Vector3f hill(int i, int j) {
  const float x = float(i) / side, z = float(j) / side;
  return {x, 0.1f * std::sin(9 * x) * std::cos(7 * z), z};
}

std::string hill_glb() {
  std::string buffer;
  for (int i = 0; i <= side; ++i)
    for (int j = 0; j <= side; ++j) buffer += raw(hill(i, j).x()) + raw(hill(i, j).y()) + raw(hill(i, j).z());
  const std::size_t vertex_bytes = buffer.size();
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j) {
      const int a = i * (side + 1) + j, b = a + side + 1;
      for (const int corner : {a, a + 1, b + 1, a, b + 1, b}) buffer += raw(std::uint32_t(corner));
    }
  std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],"meshes":[{{"primitives":[
{{"attributes":{{"POSITION":0}},"indices":1}}]}}],"buffers":[{{"byteLength":{0}}}],"bufferViews":[{{"buffer":0,"byteOffset":0,
"byteLength":{1}}},{{"buffer":0,"byteOffset":{1},"byteLength":{2}}}],"accessors":[{{"bufferView":0,"componentType":5126,
"count":{3},"type":"VEC3","min":[0,-1,0],"max":[1,1,1]}},{{"bufferView":1,"componentType":5125,"count":{4},"type":"SCALAR"}}]}})",
      buffer.size(), vertex_bytes, buffer.size() - vertex_bytes, vertex_bytes / 12, 6 * side * side);
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::string chunks = raw(std::uint32_t(json.size())) + "JSON" + json + raw(std::uint32_t(buffer.size())) +
                             std::string("BIN\0", 4) + buffer;
  return "glTF" + raw(std::uint32_t(2)) + raw(std::uint32_t(12 + chunks.size())) + chunks;
}

/// [s] that read() takes in a process of its own, as a program that reads one mesh has it: memory that was used before
/// is faster.
template <class Read>
double fresh_time(const Read& read) {
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  if (child == 0) {
    read();
    ::_exit(0);
  }
  int status = 0;
  if (child < 0 || ::waitpid(child, &status, 0) != child || status != 0)
    throw std::runtime_error("the mesh is not read");
  return seconds_since(start);
}

BenchRows foreign_formats() {
  constexpr int times = 11;
  const auto path = std::filesystem::temp_directory_path() / "umax-bench-import.glb";
  std::ofstream(path, std::ios::binary) << hill_glb();
  std::vector<double> here, apart;
  for (int i = 0; i < times; ++i) {
    here.push_back(fresh_time([&] { read_with_assimp(path, "glb"); }));
    apart.push_back(fresh_time([&] { read_foreign(path, "glb", import_limits(path)); }));
  }
  std::filesystem::remove(path);
  std::sort(here.begin(), here.end());
  std::sort(apart.begin(), apart.end());
  return {at_most("glTF of a million triangles: by umax-import over in the process", apart[times / 2] / here[times / 2],
                  1.1, "x", fmt::format("{:.0f} ms over {:.0f} ms", 1e3 * apart[times / 2], 1e3 * here[times / 2]))};
}

}  // namespace

std::vector<Benchmark> import_benchmarks() {
  return {{.name = "import", .run = foreign_formats}};
}

}  // namespace umax
