#include "tests/support/vdb_files.h"

#include <openvdb/openvdb.h>

namespace umax::test {
namespace {

template <class Grid, class ValueAt>
openvdb::GridBase::Ptr fill(const VdbContent& content, const typename Grid::ValueType& background, ValueAt value_at) {
  const auto grid = Grid::create(background);
  grid->setName(content.name);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(content.voxel));
  if (content.is_level_set) grid->setGridClass(openvdb::GRID_LEVEL_SET);
  auto voxels = grid->getAccessor();
  for (int i = content.first[0]; i <= content.last[0]; ++i)
    for (int j = content.first[1]; j <= content.last[1]; ++j)
      for (int k = content.first[2]; k <= content.last[2]; ++k)
        voxels.setValueOn(openvdb::Coord(i, j, k), value_at(Vector3d(content.voxel * Vector3d(i, j, k))));
  return grid;
}

openvdb::GridBase::Ptr make_grid(const VdbContent& content) {
  if (content.is_integer) return fill<openvdb::Int32Grid>(content, -777, [](const Vector3d&) { return 1; });
  if (content.direction)
    return fill<openvdb::Vec3SGrid>(content, openvdb::Vec3s(-777), [&](const Vector3d& at) {
      const Vector3d value = content.direction(at);
      return openvdb::Vec3s(float(value[0]), float(value[1]), float(value[2]));
    });
  return fill<openvdb::FloatGrid>(content, -777.0f, [&](const Vector3d& at) { return float(content.number(at)); });
}

}  // namespace

void write_vdb(const std::filesystem::path& path, const std::vector<VdbContent>& grids) {
  openvdb::initialize();
  openvdb::GridPtrVec content;
  for (const VdbContent& grid : grids) content.push_back(make_grid(grid));
  std::filesystem::create_directories(path.parent_path());
  openvdb::io::File(path.string()).write(content);
}

}  // namespace umax::test
