#include "embedding/scanning/file_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "core/base/error.h"
#include "core/files/read_file.h"

namespace umax {
namespace {

constexpr double largest_coordinate = 1e9;

}  // namespace

void refuse_mesh(const std::filesystem::path& path, const std::string& what, const std::string& value,
                 const std::string& remedy) {
  throw Error(Fault::bad_data, {path.string(), what, value, remedy});
}

std::string lower_ending(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  if (!ending.empty()) ending.erase(0, 1);
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return ending;
}

void require_readable_file(const std::filesystem::path& path, const std::string& thing) {
  std::error_code error;
  const auto refuse_input = [&](const std::string& what, const char* remedy) {
    throw Error(Fault::not_found, {path.string(), what, "", remedy});
  };
  if (!std::filesystem::exists(path, error)) refuse_input("the " + thing + " does not exist", "check the path");
  if (std::filesystem::is_directory(path, error)) refuse_input("is a folder, not a " + thing, "name a file in it");
  if (!is_readable(path)) refuse_input("the " + thing + " cannot be read", "check its permissions");
  if (std::filesystem::is_regular_file(path, error) && std::filesystem::file_size(path, error) == 0)
    refuse_mesh(path, "the " + thing + " is empty", "0 bytes", "export it again");
}

void require_finite(const std::filesystem::path& path, const Points& positions) {
  long long num_bad = 0;
  Eigen::Index first = -1;
  for (Eigen::Index v = 0; v < positions.rows(); ++v)
    if (!positions.row(v).allFinite() && num_bad++ == 0) first = v;
  if (num_bad > 0)
    refuse_mesh(path,
                fmt::format("{} of {} vertices are not finite numbers, the first is vertex {}", num_bad,
                            positions.rows(), first),
                fmt::format("({}, {}, {})", positions(first, 0), positions(first, 1), positions(first, 2)),
                "repair or export the mesh again");
}

void require_sensible_box(const std::filesystem::path& path, const Points& positions) {
  const double largest = positions.cwiseAbs().maxCoeff();
  if (largest > largest_coordinate)
    refuse_mesh(path, "coordinates are absurdly large (more than 1e9)", fmt::format("{:g}", largest),
                "check the file's unit, or scale it down");
  const Eigen::RowVector3d extent = positions.colwise().maxCoeff() - positions.colwise().minCoeff();
  if (!(extent.maxCoeff() > 1e-12 * std::max(largest, 1e-12)))
    refuse_mesh(path, "all vertices lie in one point", fmt::format("extent {:g}", extent.maxCoeff()),
                "give a mesh with an extent");
}

}  // namespace umax
