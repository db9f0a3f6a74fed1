#include "tests/support/vdb_files.h"

#include <openvdb/openvdb.h>

namespace umax::test {
namespace {

template <class Grid, class ValueAt>
void fill(const VdbContent& content, const typename Grid::ValueType& background, ValueAt value_at,
          openvdb::GridBase& grid) {
  auto& tree = static_cast<Grid&>(grid).tree();
  tree.root().setBackground(background, /*updateChildNodes=*/false);
  for (int i = content.first[0]; i <= content.last[0]; ++i)
    for (int j = content.first[1]; j <= content.last[1]; ++j)
      for (int k = content.first[2]; k <= content.last[2]; ++k) {
        const openvdb::Coord voxel(i, j, k);
        tree.touchLeaf(voxel)->setValueOn(voxel, value_at(Vector3d(content.voxel * Vector3d(i, j, k))));
      }
}

const char* grid_type(const VdbContent& content) {
  if (content.is_integer) return "Tree_int32_5_4_3";
  return content.direction ? "Tree_vec3s_5_4_3" : "Tree_float_5_4_3";
}

openvdb::GridBase::Ptr make_grid(const VdbContent& content) {
  // by name, in libopenvdb: a grid made here would have our compiler make all that a tree can do
  const openvdb::GridBase::Ptr grid = openvdb::GridBase::createGrid(grid_type(content));
  grid->setName(content.name);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(content.voxel));
  grid->setSaveFloatAsHalf(content.as_halves);
  if (content.is_level_set) grid->setGridClass(openvdb::GRID_LEVEL_SET);
  if (content.direction) {
    const auto value_at = [&](const Vector3d& at) {
      const Vector3d value = content.direction(at);
      return openvdb::Vec3s(float(value[0]), float(value[1]), float(value[2]));
    };
    fill<openvdb::Vec3SGrid>(content, openvdb::Vec3s(-777), value_at, *grid);
  } else if (content.number) {
    fill<openvdb::FloatGrid>(content, -777.0f, [&](const Vector3d& at) { return float(content.number(at)); }, *grid);
  }
  return grid;
}

}  // namespace

void write_vdb(const std::filesystem::path& path, const std::vector<VdbContent>& grids, VdbCompression compression) {
  openvdb::initialize();
  openvdb::GridPtrVec content;
  for (const VdbContent& grid : grids) content.push_back(make_grid(grid));
  std::filesystem::create_directories(path.parent_path());
  openvdb::io::File file(path.string());
  using namespace openvdb::io;
  if (compression == VdbCompression::none) file.setCompression(COMPRESS_ACTIVE_MASK);
  if (compression == VdbCompression::zip) file.setCompression(COMPRESS_ZIP | COMPRESS_ACTIVE_MASK);
  if (compression == VdbCompression::blosc) file.setCompression(COMPRESS_BLOSC | COMPRESS_ACTIVE_MASK);
  file.write(content);
}

}  // namespace umax::test
