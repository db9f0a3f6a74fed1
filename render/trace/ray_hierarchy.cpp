#include "render/trace/ray_hierarchy.h"

#if UMAX_EMBREE_VERSION >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <limits>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace umax {
namespace {

constexpr int packet_size = RayHierarchy::packet_size;

RTCScene scene_of(void* scene) {
  return static_cast<RTCScene>(scene);
}

// --- what goes with a call of the library, down to the clusters

#if UMAX_EMBREE_VERSION >= 4
using LibraryContext = RTCRayQueryContext;
#else
using LibraryContext = RTCIntersectContext;
#endif

struct Context {
  LibraryContext library;
  const ShearedRay* sheared;  // of each ray, by its number
};

Context make_context(const ShearedRay* sheared, bool coherent) {
  Context context;
#if UMAX_EMBREE_VERSION >= 4
  rtcInitRayQueryContext(&context.library);
  (void)coherent;
#else
  rtcInitIntersectContext(&context.library);
  if (coherent) context.library.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
#endif
  context.sheared = sheared;
  return context;
}

#if UMAX_EMBREE_VERSION >= 4
// RTCIntersectArguments or RTCOccludedArguments, set by the library's own function
template <class Arguments>
Arguments make_arguments(void (*set_up)(Arguments*), Context& context, bool coherent) {
  Arguments arguments;
  set_up(&arguments);
  arguments.context = &context.library;
  if (coherent) arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  return arguments;
}
#endif

// --- clusters, as the library asks for them

void give_bounds(const RTCBoundsFunctionArguments* of) {
  const auto& clusters = *static_cast<const MovingClusters*>(of->geometryUserPtr);
  const MovingClusters::Box& box = clusters.box(of->primID, of->timeStep);
  *of->bounds_o = {.lower_x = box.low[0],
                   .lower_y = box.low[1],
                   .lower_z = box.low[2],
                   .align0 = 0,
                   .upper_x = box.high[0],
                   .upper_y = box.high[1],
                   .upper_z = box.high[2],
                   .align1 = 0};
}

template <class Arguments>
ClusterHit hit_cluster(const Arguments* of, RTCRayN* rays, unsigned i) {
  const auto& clusters = *static_cast<const MovingClusters*>(of->geometryUserPtr);
  const auto& context = *reinterpret_cast<const Context*>(of->context);
  return clusters.hit(of->primID, context.sheared[RTCRayN_id(rays, of->N, i)], RTCRayN_time(rays, of->N, i),
                      RTCRayN_tfar(rays, of->N, i));
}

void intersect_cluster(const RTCIntersectFunctionNArguments* of) {
  RTCRayN* rays = RTCRayHitN_RayN(of->rayhit, of->N);
  RTCHitN* hits = RTCRayHitN_HitN(of->rayhit, of->N);
  for (unsigned i = 0; i < of->N; ++i) {
    if (!of->valid[i]) continue;
    const ClusterHit hit = hit_cluster(of, rays, i);
    if (!hit.found()) continue;
    RTCRayN_tfar(rays, of->N, i) = hit.distance;
    RTCHitN_u(hits, of->N, i) = hit.u;
    RTCHitN_v(hits, of->N, i) = hit.v;
    RTCHitN_geomID(hits, of->N, i) = of->geomID;
    RTCHitN_primID(hits, of->N, i) = unsigned(hit.triangle);
  }
}

void occlude_by_cluster(const RTCOccludedFunctionNArguments* of) {
  for (unsigned i = 0; i < of->N; ++i)
    if (of->valid[i] && hit_cluster(of, of->ray, i).found())
      RTCRayN_tfar(of->ray, of->N, i) = -std::numeric_limits<float>::infinity();
}

// --- single rays

struct Single {
  RTCRayHit query;
  ShearedRay sheared;

  Single(const Ray& ray, bool has_motion) {
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
    if (has_motion) sheared = shear(ray.origin.data(), ray.direction.data());
  }

  void intersect(RTCScene scene) {
    Context context = make_context(&sheared, false);
#if UMAX_EMBREE_VERSION >= 4
    RTCIntersectArguments arguments = make_arguments(rtcInitIntersectArguments, context, false);
    rtcIntersect1(scene, &query, &arguments);
#else
    rtcIntersect1(scene, &context.library, &query);
#endif
  }
  void occluded(RTCScene scene) {
    Context context = make_context(&sheared, false);
#if UMAX_EMBREE_VERSION >= 4
    RTCOccludedArguments arguments = make_arguments(rtcInitOccludedArguments, context, false);
    rtcOccluded1(scene, &query.ray, &arguments);
#else
    rtcOccluded1(scene, &context.library, &query.ray);
#endif
  }
};

// --- several at once

struct Packet {
  alignas(32) int valid[packet_size];
  RTCRayHit8 query;
  ShearedRay sheared[packet_size];

  // the rays of these numbers; the last one fills up
  Packet(const rows::RayRows& rays, const int* numbers, int count, bool has_motion) {
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
      query.ray.id[lane] = unsigned(lane);
      query.ray.flags[lane] = 0;
      query.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
      query.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
    }
    for (int lane = 0; has_motion && lane < count; ++lane) {
      const Ray ray = rays.at(numbers[lane]);
      sheared[lane] = shear(ray.origin.data(), ray.direction.data());
    }
  }

  void intersect(RTCScene scene) {
    Context context = make_context(sheared, true);
#if UMAX_EMBREE_VERSION >= 4
    RTCIntersectArguments arguments = make_arguments(rtcInitIntersectArguments, context, true);
    rtcIntersect8(valid, scene, &query, &arguments);
#else
    rtcIntersect8(valid, scene, &context.library, &query);
#endif
  }
  void occluded(RTCScene scene) {
    Context context = make_context(sheared, true);
#if UMAX_EMBREE_VERSION >= 4
    RTCOccludedArguments arguments = make_arguments(rtcInitOccludedArguments, context, true);
    rtcOccluded8(valid, scene, &query.ray, &arguments);
#else
    rtcOccluded8(valid, scene, &context.library, &query.ray);
#endif
  }
};

}  // namespace

// hits differ between instruction sets: one is fixed so that pictures do not depend on the machine
RayDevice::RayDevice() : device_(rtcNewDevice("isa=avx2")) {
  if (device_) return;
  throw Error(Fault::internal, {.where = "ray tracing",
                                .what = "Embree cannot start",
                                .value = "error " + std::to_string(int(rtcGetDeviceError(nullptr))),
                                .remedy = "a processor with AVX2 is needed"});
}
RayDevice::~RayDevice() {
  rtcReleaseDevice(static_cast<RTCDevice>(device_));
}

RayHierarchy::RayHierarchy(std::shared_ptr<const RayDevice> device, HierarchyBuild build)
    : device_(std::move(device)), build_(build) {
  RTCScene scene = rtcNewScene(static_cast<RTCDevice>(device_->get()));
  const bool is_fast = build == HierarchyBuild::fast;
  // the library builds fast only what it takes for changing
  rtcSetSceneFlags(scene,
                   is_fast ? RTCSceneFlags(RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC) : RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, is_fast ? RTC_BUILD_QUALITY_LOW : RTC_BUILD_QUALITY_MEDIUM);
  scene_ = scene;
}
RayHierarchy::~RayHierarchy() {
  rtcReleaseScene(scene_of(scene_));
}

void RayHierarchy::add(const TracedObject& object, unsigned id) {
  RTCGeometry geometry = rtcNewGeometry(static_cast<RTCDevice>(device_->get()), RTC_GEOMETRY_TYPE_TRIANGLE);
  if (build_ == HierarchyBuild::fast) rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_LOW);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, object.vertices.data(), 0,
                             sizeof(TracedObject::Vertex), object.num_vertices);
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, object.triangles.data(), 0,
                             sizeof(TracedObject::Corners), object.triangles.size());
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene_of(scene_), geometry, id);
  rtcReleaseGeometry(geometry);
}

void RayHierarchy::add(const MovingClusters& clusters, unsigned id) {
  RTCGeometry geometry = rtcNewGeometry(static_cast<RTCDevice>(device_->get()), RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryTimeStepCount(geometry, unsigned(clusters.num_steps()));
  rtcSetGeometryUserPrimitiveCount(geometry, unsigned(clusters.count()));
  rtcSetGeometryUserData(geometry, const_cast<MovingClusters*>(&clusters));
  rtcSetGeometryBoundsFunction(geometry, give_bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect_cluster);
  rtcSetGeometryOccludedFunction(geometry, occlude_by_cluster);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene_of(scene_), geometry, id);
  rtcReleaseGeometry(geometry);
  has_motion_ = true;
}

void RayHierarchy::build() {
  rtcCommitScene(scene_of(scene_));
}

Hit RayHierarchy::intersect(const Ray& ray) const {
  Single single(ray, has_motion_);
  single.intersect(scene_of(scene_));
  return {.object = single.query.hit.geomID,
          .triangle = single.query.hit.primID,
          .distance = single.query.ray.tfar,
          .u = single.query.hit.u,
          .v = single.query.hit.v};
}

bool RayHierarchy::occluded(const Ray& ray) const {
  Single single(ray, has_motion_);
  single.occluded(scene_of(scene_));
  return single.query.ray.tfar < 0;
}

void RayHierarchy::intersect(const rows::RayRows& rays, const int* numbers, int count, rows::HitRows& hits) const {
  Packet packet(rays, numbers, count, has_motion_);
  packet.intersect(scene_of(scene_));
  for (int lane = 0; lane < count; ++lane) {
    hits.set(numbers[lane], {.object = packet.query.hit.geomID[lane],
                             .triangle = packet.query.hit.primID[lane],
                             .distance = packet.query.ray.tfar[lane],
                             .u = packet.query.hit.u[lane],
                             .v = packet.query.hit.v[lane]});
  }
}

void RayHierarchy::occluded(const rows::RayRows& rays, const int* numbers, int count, rows::RowOf<int>& blocked) const {
  Packet packet(rays, numbers, count, has_motion_);
  packet.occluded(scene_of(scene_));
  for (int lane = 0; lane < count; ++lane) blocked[numbers[lane]] = packet.query.ray.tfar[lane] < 0 ? 1 : 0;
}

}  // namespace umax
