#include "render/trace/ray_scene.h"

#include <algorithm>
#include <chrono>
#include <memory>

#include "core/base/parallel.h"
#include "render/trace/ray_boxes.h"

namespace umax {
namespace {

constexpr int packet_size = RayHierarchy::packet_size;

}  // namespace

struct RayScene::Data {
  std::vector<TracedObject> objects;
  std::vector<std::unique_ptr<const MovingClusters>> clusters;  // of each object; null of most that stand still
  RayBoxes boxes;
  std::shared_ptr<const RayDevice> device = std::make_shared<const RayDevice>();
  RayHierarchy hierarchy;
  std::vector<std::unique_ptr<RayHierarchy>> alone;  // of each object in which light wanders; null of the others

  explicit Data(HierarchyBuild build) : hierarchy(device, build) {}

  void add(unsigned object, RayHierarchy& to) const {
    if (objects[object].triangles.empty()) return;
    clusters[object] ? to.add(*clusters[object], object) : to.add(objects[object], object);
  }

  // numbers of the rays that may meet something; returns how many they are
  int candidates(const rows::RayRows& rays, int count, rows::RowOf<int>& numbers) const {
    rows::RowOf<int> may_hit;
    boxes.find(rays, count, may_hit);
    int found = 0;
    for (int i = 0; i < count; ++i) {
      numbers[found] = i;
      found += may_hit[i];
    }
    return found;
  }
};

RayScene::RayScene(const RenderScene& scene, HierarchyBuild build, ClusterCache* cache)
    : data_(std::make_unique<Data>(build)) {
  ClusterCache own;
  for (const RenderObject& object : scene.objects) data_->objects.push_back(make_traced_object(object));
  data_->boxes = RayBoxes(data_->objects);
  for (const TracedObject& object : data_->objects)
    data_->clusters.push_back(
        object.is_moving() || is_sliced(object)
            ? std::make_unique<const MovingClusters>(object, (cache ? *cache : own).clusters_of(object))
            : nullptr);
  for (unsigned i = 0; i < data_->objects.size(); ++i) {
    data_->add(i, data_->hierarchy);
    data_->alone.push_back(nullptr);
    if (!(scene.objects[i].look.subsurface > 0)) continue;
    data_->alone.back() = std::make_unique<RayHierarchy>(data_->device, build);
    data_->add(i, *data_->alone.back());
  }
  data_->hierarchy.build();
  for (const auto& one : data_->alone)
    if (one) one->build();
}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

const std::vector<TracedObject>& RayScene::objects() const {
  return data_->objects;
}

Hit RayScene::intersect(const Ray& ray) const {
  return data_->hierarchy.intersect(ray);
}

Hit RayScene::intersect_object(unsigned object, const Ray& ray) const {
  return data_->alone[object]->intersect(ray);
}

void RayScene::intersect(const rows::RayRows& rays, int count, bool coherent, rows::HitRows& hits) const {
  rows::RowOf<int> numbers;
  const int found = data_->candidates(rays, count, numbers);
  for (int i = 0; i < count; ++i) hits.object[i] = Hit::nothing;
  if (!coherent) {
    for (int k = 0; k < found; ++k) hits.set(numbers[k], intersect(rays.at(numbers[k])));
    return;
  }
  for (int begin = 0; begin < found; begin += packet_size)
    data_->hierarchy.intersect(rays, &numbers[begin], std::min(packet_size, found - begin), hits);
}

bool RayScene::occluded(const Ray& ray) const {
  return data_->hierarchy.occluded(ray);
}

void RayScene::occluded(const rows::RayRows& rays, int count, bool coherent, rows::RowOf<int>& blocked) const {
  rows::RowOf<int> numbers;
  const int found = data_->candidates(rays, count, numbers);
  for (int i = 0; i < count; ++i) blocked[i] = 0;
  // a packet meets every cluster that one of its rays comes near: too many for rays that part
  if (!coherent || data_->hierarchy.has_motion()) {
    for (int k = 0; k < found; ++k) blocked[numbers[k]] = occluded(rays.at(numbers[k])) ? 1 : 0;
    return;
  }
  for (int begin = 0; begin < found; begin += packet_size)
    data_->hierarchy.occluded(rays, &numbers[begin], std::min(packet_size, found - begin), blocked);
}

SurfacePoint RayScene::surface(const Hit& hit, const Vector3f& ray_direction, float time) const {
  rows::RayRows rays;
  rows::HitRows hits;
  SurfacePointRows points;
  rays.set(0, {.direction = ray_direction, .time = time}), hits.set(0, hit);
  SurfacePoints().find(data_->objects, rays, hits, 1, points);
  return {.position = points.position.vector(0),
          .geometric_normal = points.geometric_normal.vector(0),
          .normal = points.normal.vector(0),
          .smooth_position = points.smooth_position.vector(0),
          .offset = points.offset[0],
          .base_color = points.base_color.vector(0)};
}

ReplayResult RayScene::replay(const RayRecording& recording) const {
  std::vector<std::uint64_t> sums(recording.size(), 0);
  const auto start = std::chrono::steady_clock::now();
  parallel_blocks(Eigen::Index(recording.size()), 1, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index tile = begin; tile < end; ++tile) {
      std::uint64_t sum = 0;
      for (const RecordedRay& recorded : recording[tile]) {
        if (recorded.any_hit) {
          sum = sum * 31 + (data_->hierarchy.occluded(recorded.ray) ? 1 : 0);
        } else {
          const Hit hit = data_->hierarchy.intersect(recorded.ray);
          sum = sum * 31 + (hit.found() ? hit.object * 7919ull + hit.triangle + 1 : 0);
        }
      }
      sums[tile] = sum;
    }
  });
  ReplayResult result;
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (std::size_t tile = 0; tile < recording.size(); ++tile) {
    result.num_rays += recording[tile].size();
    result.checksum = result.checksum * 1000003 + sums[tile];
  }
  return result;
}

}  // namespace umax
