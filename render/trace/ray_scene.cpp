#include "render/trace/ray_scene.h"

#if UMAX_EMBREE_VERSION >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <chrono>
#include <string>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "render/trace/ray_boxes.h"

namespace umax {
namespace {

RTCRayHit to_library(const Ray& ray) {
  RTCRayHit query;
  query.ray.org_x = ray.origin.x();
  query.ray.org_y = ray.origin.y();
  query.ray.org_z = ray.origin.z();
  query.ray.tnear = 0;
  query.ray.dir_x = ray.direction.x();
  query.ray.dir_y = ray.direction.y();
  query.ray.dir_z = ray.direction.z();
  query.ray.time = ray.time;
  query.ray.tfar = ray.max_distance;
  query.ray.mask = ~0u;
  query.ray.id = 0;
  query.ray.flags = 0;
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  return query;
}

void call_intersect(RTCScene scene, RTCRayHit& query) {
#if UMAX_EMBREE_VERSION >= 4
  rtcIntersect1(scene, &query, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &query);
#endif
}

Hit first_hit(RTCScene scene, const Ray& ray) {
  RTCRayHit query = to_library(ray);
  call_intersect(scene, query);
  return {.object = query.hit.geomID,
          .triangle = query.hit.primID,
          .distance = query.ray.tfar,
          .u = query.hit.u,
          .v = query.hit.v};
}

// rays that the library traces together
constexpr int packet_size = 8;
struct Packet {
  alignas(32) int valid[packet_size];
  RTCRayHit8 query;

  // the rays of these numbers; the last one fills up
  Packet(const rows::RayRows& rays, const int* numbers, int count) {
    for (int lane = 0; lane < packet_size; ++lane) {
      const int i = numbers[lane < count ? lane : count - 1];
      valid[lane] = lane < count ? -1 : 0;
      query.ray.org_x[lane] = rays.origin.x[i];
      query.ray.org_y[lane] = rays.origin.y[i];
      query.ray.org_z[lane] = rays.origin.z[i];
      query.ray.tnear[lane] = 0;
      query.ray.dir_x[lane] = rays.direction.x[i];
      query.ray.dir_y[lane] = rays.direction.y[i];
      query.ray.dir_z[lane] = rays.direction.z[i];
      query.ray.time[lane] = rays.time[i];
      query.ray.tfar[lane] = rays.max_distance[i];
      query.ray.mask[lane] = ~0u;
      query.ray.id[lane] = 0;
      query.ray.flags[lane] = 0;
      query.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
      query.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    }
  }

  void intersect(RTCScene scene) {
#if UMAX_EMBREE_VERSION >= 4
    RTCIntersectArguments arguments;
    rtcInitIntersectArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcIntersect8(valid, scene, &query, &arguments);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcIntersect8(valid, scene, &context, &query);
#endif
  }
  void occluded(RTCScene scene) {
#if UMAX_EMBREE_VERSION >= 4
    RTCOccludedArguments arguments;
    rtcInitOccludedArguments(&arguments);
    arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
    rtcOccluded8(valid, scene, &query.ray, &arguments);
#else
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    rtcOccluded8(valid, scene, &context, &query.ray);
#endif
  }
};

void call_occluded(RTCScene scene, RTCRay& query) {
#if UMAX_EMBREE_VERSION >= 4
  rtcOccluded1(scene, &query, nullptr);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &query);
#endif
}

// hits differ between instruction sets: one is fixed so that pictures do not depend on the machine
RTCDevice make_device() {
  RTCDevice device = rtcNewDevice("isa=avx2");
  if (!device) {
    throw Error(Fault::internal, {.where = "ray tracing",
                                  .what = "Embree cannot start",
                                  .value = "error " + std::to_string(int(rtcGetDeviceError(nullptr))),
                                  .remedy = "a processor with AVX2 is needed"});
  }
  return device;
}

}  // namespace

struct RayScene::Data {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<RTCScene> alone;  // of each object in which light wanders; null of the others
  std::vector<TracedObject> objects;
  RayBoxes boxes;

  Data() = default;
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;
  ~Data() {
    for (RTCScene one : alone)
      if (one) rtcReleaseScene(one);
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }

  void attach(TracedObject& object, unsigned id, HierarchyBuild build) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    if (build == HierarchyBuild::fast) rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_LOW);
    if (object.is_moving()) {
      rtcSetGeometryTimeStepCount(geometry, unsigned(object.num_instants));
      rtcSetGeometryTimeRange(geometry, object.first, object.last);
    }
    for (int k = 0; k < object.num_instants; ++k)
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, unsigned(k), RTC_FORMAT_FLOAT3,
                                 object.vertices.data() + std::size_t(k) * object.num_vertices, 0,
                                 sizeof(TracedObject::Vertex), object.num_vertices);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, object.triangles.data(), 0,
                               sizeof(TracedObject::Corners), object.triangles.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    if (alone[id]) rtcAttachGeometryByID(alone[id], geometry, id);
    rtcReleaseGeometry(geometry);
  }

  RTCScene new_scene(HierarchyBuild build) const {
    RTCScene made = rtcNewScene(device);
    const bool is_fast = build == HierarchyBuild::fast;
    // the library builds fast only what it takes for changing
    rtcSetSceneFlags(made,
                     is_fast ? RTCSceneFlags(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC) : RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(made, is_fast ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
    return made;
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

RayScene::RayScene(const RenderScene& scene, HierarchyBuild build) : data_(std::make_unique<Data>()) {
  for (const RenderObject& object : scene.objects) data_->objects.push_back(make_traced_object(object));
  data_->boxes = RayBoxes(data_->objects);
  data_->device = make_device();
  data_->scene = data_->new_scene(build);
  for (const RenderObject& object : scene.objects)
    data_->alone.push_back(object.look.subsurface > 0 ? data_->new_scene(build) : nullptr);
  for (std::size_t i = 0; i < data_->objects.size(); ++i)
    if (!data_->objects[i].triangles.empty()) data_->attach(data_->objects[i], unsigned(i), build);
  rtcCommitScene(data_->scene);
  for (RTCScene one : data_->alone)
    if (one) rtcCommitScene(one);
}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

const std::vector<TracedObject>& RayScene::objects() const {
  return data_->objects;
}

Hit RayScene::intersect(const Ray& ray) const {
  return first_hit(data_->scene, ray);
}

Hit RayScene::intersect_object(unsigned object, const Ray& ray) const {
  return first_hit(data_->alone[object], ray);
}

void RayScene::intersect(const rows::RayRows& rays, int count, bool coherent, rows::HitRows& hits) const {
  rows::RowOf<int> numbers;
  const int found = data_->candidates(rays, count, numbers);
  for (int i = 0; i < count; ++i) hits.object[i] = Hit::nothing;
  if (!coherent) {
    for (int k = 0; k < found; ++k) hits.set(numbers[k], intersect(rays.at(numbers[k])));
    return;
  }
  for (int begin = 0; begin < found; begin += packet_size) {
    const int size = std::min(packet_size, found - begin);
    Packet packet(rays, &numbers[begin], size);
    packet.intersect(data_->scene);
    for (int lane = 0; lane < size; ++lane) {
      hits.set(numbers[begin + lane], {.object = packet.query.hit.geomID[lane],
                                       .triangle = packet.query.hit.primID[lane],
                                       .distance = packet.query.ray.tfar[lane],
                                       .u = packet.query.hit.u[lane],
                                       .v = packet.query.hit.v[lane]});
    }
  }
}

bool RayScene::occluded(const Ray& ray) const {
  RTCRayHit query = to_library(ray);
  call_occluded(data_->scene, query.ray);
  return query.ray.tfar < 0;
}

void RayScene::occluded(const rows::RayRows& rays, int count, bool coherent, rows::RowOf<int>& blocked) const {
  rows::RowOf<int> numbers;
  const int found = data_->candidates(rays, count, numbers);
  for (int i = 0; i < count; ++i) blocked[i] = 0;
  if (!coherent) {
    for (int k = 0; k < found; ++k) blocked[numbers[k]] = occluded(rays.at(numbers[k])) ? 1 : 0;
    return;
  }
  for (int begin = 0; begin < found; begin += packet_size) {
    const int size = std::min(packet_size, found - begin);
    Packet packet(rays, &numbers[begin], size);
    packet.occluded(data_->scene);
    for (int lane = 0; lane < size; ++lane) blocked[numbers[begin + lane]] = packet.query.ray.tfar[lane] < 0 ? 1 : 0;
  }
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
        RTCRayHit query = to_library(recorded.ray);
        if (recorded.any_hit) {
          call_occluded(data_->scene, query.ray);
          sum = sum * 31 + (query.ray.tfar < 0 ? 1 : 0);
        } else {
          call_intersect(data_->scene, query);
          const bool found = query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
          sum = sum * 31 + (found ? query.hit.geomID * 7919ull + query.hit.primID + 1 : 0);
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
