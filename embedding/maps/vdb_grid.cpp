#include "embedding/maps/vdb_grid.h"

#include <fmt/format.h>
#include <openvdb/io/DelayedLoadMetadata.h>
#include <openvdb/openvdb.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <fstream>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <variant>

#include "core/base/error.h"
#include "embedding/maps/vdb_promises.h"
#include "embedding/scanning/file_checks.h"

namespace umax {
namespace {

using Path = std::filesystem::path;
using openvdb::FloatGrid;
using openvdb::Vec3SGrid;

[[noreturn]] void refuse(const Path& path, const std::string& what, const std::string& value,
                         const std::string& remedy) {
  throw Error(Fault::bad_data, {path.string(), what, value, remedy});
}

/// Calls work; what OpenVDB throws says that the file is damaged.
template <class Work>
auto reading(const Path& path, Work work) {
  try {
    return work();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    refuse(path, "is no sound OpenVDB file", error.what(), "it is truncated or damaged: write it again");
  }
}

struct Named {
  std::string name, type;
};

std::string names_text(const std::vector<Named>& grids, bool with_types) {
  std::vector<std::string> texts;
  for (const auto& [name, type] : grids)
    texts.push_back(with_types ? fmt::format("\"{}\" ({})", name, type) : '"' + name + '"');
  return texts.empty() ? "none" : fmt::format("{}", fmt::join(texts, ", "));
}

std::vector<Named> list_grids(openvdb::io::File& file) {
  std::vector<Named> grids;
  for (auto name = file.beginName(); name != file.endName(); ++name)
    grids.push_back({name.gridName(), file.readGridMetadata(name.gridName())->valueType()});
  return grids;
}

/// The name of the grid to read.
std::string choose(const Path& path, const std::vector<Named>& grids, const std::string& wanted,
                   const std::string& type) {
  std::vector<Named> fitting;
  for (const Named& grid : grids)
    if (grid.type == type) fitting.push_back(grid);
  const std::string remedy = fitting.empty() ? "write one of this type; the file has " + names_text(grids, true)
                                             : "its " + type + " grids are " + names_text(fitting, false);
  if (wanted.empty()) {
    if (fitting.empty()) refuse(path, fmt::format("has no {} grid", type), "", remedy);
    if (fitting.size() > 1)
      refuse(path, fmt::format("has {} {} grids: which one is meant?", fitting.size(), type), "",
             "name one: " + names_text(fitting, false));
    return fitting.front().name;
  }
  for (const Named& grid : grids) {
    if (grid.name != wanted) continue;
    if (grid.type != type)
      refuse(path, fmt::format("the grid \"{}\" is not of type {}", wanted, type), grid.type, remedy);
    return wanted;
  }
  refuse(path, "has no grid of this name", '"' + wanted + '"', remedy);
}

bool is_sound(float value) {
  return std::isfinite(value) && value >= 0;
}
bool is_sound(const openvdb::Vec3s& value) {
  return std::isfinite(value[0]) && std::isfinite(value[1]) && std::isfinite(value[2]);
}
std::string text_of(float value) {
  return fmt::format("{:g}", value);
}
std::string text_of(const openvdb::Vec3s& value) {
  return fmt::format("({:g}, {:g}, {:g})", value[0], value[1], value[2]);
}

template <class Grid>
void require_sound_values(const Path& path, const std::string& name, const Grid& grid) {
  if (grid.activeVoxelCount() == 0)
    refuse(path, fmt::format("the grid \"{}\" is empty", name), "no active voxel", "write it again");
  long long num_bad = 0;
  std::string first;
  for (auto at = grid.cbeginValueOn(); at; ++at) {
    if (is_sound(*at) || num_bad++ > 0) continue;
    const openvdb::Coord ijk = at.getCoord();
    first = fmt::format("{} at voxel [{}, {}, {}]", text_of(*at), ijk.x(), ijk.y(), ijk.z());
  }
  const bool numbers = std::is_same_v<Grid, FloatGrid>;
  if (num_bad > 0)
    refuse(path,
           fmt::format("the grid \"{}\" has {} active value{} not finite{}", name, num_bad,
                       num_bad == 1 ? " that is" : "s that are", numbers ? " or negative" : ""),
           "first " + first, numbers ? "write factors, 1 where nothing shall change" : "write finite vectors");
}

using Row = Eigen::Matrix<double, 1, 6>;

void add(double weight, float value, Row& sum) {
  sum[0] += weight * double(value);
}
void add(double weight, const openvdb::Vec3s& f, Row& sum) {
  Vector3d v(f[0], f[1], f[2]);
  v.normalize();  // zero stays zero
  Row product;
  product << v[0] * v[0], v[1] * v[1], v[2] * v[2], v[0] * v[1], v[0] * v[2], v[1] * v[2];
  sum += weight * product;
}

/// Trilinear between the active ones of the eight voxels around a point; `at` is in index space.
template <class Accessor>
Row blend(const Accessor& voxels, const openvdb::Vec3d& at) {
  const openvdb::Coord low = openvdb::Coord::floor(at);
  Row sum = Row::Zero();
  double all = 0;
  for (int n = 0; n < 8; ++n) {
    const openvdb::Coord corner = low.offsetBy(n >> 2, n >> 1 & 1, n & 1);
    typename Accessor::ValueType value;
    if (!voxels.probeValue(corner, value)) continue;
    double weight = 1;
    for (int axis = 0; axis < 3; ++axis) weight *= 1 - std::abs(at[axis] - corner[axis]);
    add(weight, value, sum);
    all += weight;
  }
  return all > 0 ? Row(sum / all) : Row(Row::Zero());
}

template <class Grid>
GridSamples sample_grid(const Grid& grid, const Points& points) {
  constexpr int columns = std::is_same_v<Grid, FloatGrid> ? 1 : 6;
  GridSamples samples{std::vector<char>(std::size_t(points.rows()), 0), MatrixXd::Zero(points.rows(), columns)};
  const auto voxels = grid.getConstAccessor();
  for (Eigen::Index p = 0; p < points.rows(); ++p) {
    const openvdb::Vec3d at = grid.worldToIndex({points(p, 0), points(p, 1), points(p, 2)});
    if (!std::isfinite(at[0] + at[1] + at[2]) || !voxels.isValueOn(openvdb::Coord::round(at))) continue;
    samples.inside[std::size_t(p)] = 1;
    samples.values.row(p) = blend(voxels, at).head(columns);
  }
  return samples;
}

}  // namespace

struct VdbGrid::Data {
  std::variant<FloatGrid::Ptr, Vec3SGrid::Ptr> grid;
  std::string name;
};

VdbGrid::VdbGrid(const Path& path, const std::string& name, Kind kind) : data_(std::make_unique<Data>()) {
  require_readable_file(path, "map file");
  openvdb::initialize();
  openvdb::io::DelayedLoadMetadata::unregisterType();  // has counts that nobody checks, and is not used
  const openvdb::GridBase::Ptr base = reading(path, [&] {
    check_vdb_promises(path);
    openvdb::io::File file(path.string());
    file.open(/*delayLoad=*/false);
    data_->name = choose(path, list_grids(file), name, kind == Kind::number ? "float" : "vec3s");
    return file.readGrid(data_->name);
  });
  if (kind == Kind::number) {
    if (base->getGridClass() == openvdb::GRID_LEVEL_SET)
      refuse(path, fmt::format("the grid \"{}\" is a level set: it holds distances", data_->name), "",
             "give a grid of factors, such as a fog volume");
    data_->grid = openvdb::gridPtrCast<FloatGrid>(base);
  } else {
    data_->grid = openvdb::gridPtrCast<Vec3SGrid>(base);
  }
  std::visit([&](const auto& grid) { require_sound_values(path, data_->name, *grid); }, data_->grid);
}

VdbGrid::~VdbGrid() = default;
VdbGrid::VdbGrid(VdbGrid&&) noexcept = default;
VdbGrid& VdbGrid::operator=(VdbGrid&&) noexcept = default;

GridSamples VdbGrid::sample(const Points& points) const {
  return std::visit([&](const auto& grid) { return sample_grid(*grid, points); }, data_->grid);
}

Eigen::AlignedBox3d VdbGrid::box() const {
  Eigen::AlignedBox3d box;
  std::visit(
      [&](const auto& grid) {
        const openvdb::CoordBBox voxels = grid->evalActiveVoxelBoundingBox();
        for (int n = 0; n < 8; ++n) {
          openvdb::Vec3d corner;
          for (int axis = 0; axis < 3; ++axis)
            corner[axis] = n >> axis & 1 ? voxels.max()[axis] + 0.5 : voxels.min()[axis] - 0.5;
          const openvdb::Vec3d at = grid->indexToWorld(corner);
          box.extend(Vector3d(at[0], at[1], at[2]));
        }
      },
      data_->grid);
  return box;
}

const std::string& VdbGrid::name() const {
  return data_->name;
}

bool is_vdb_file(const Path& path) {
  return lower_ending(path) == "vdb";
}

}  // namespace umax
