#include "render/trace/ray_scene.h"

#if UMAX_EMBREE_VERSION >= 4
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <string>

#include "core/base/error.h"
#include "core/base/parallel.h"

namespace umax {
namespace {

// a vertex in half a cache line; Embree reads the position in place
struct alignas(32) Vertex {
  float position[3], unused = 0;
  float normal[3], unused2 = 0;
};
struct Corners {
  unsigned index[3];
};

struct ObjectData {
  std::vector<Vertex> vertices;
  std::vector<Corners> triangles;
  std::vector<Vector3f> colors;               // per vertex, or empty
  std::vector<Vector2f> texture_coordinates;  // per triangle corner, or empty
  std::vector<int> paint;                     // per triangle, or empty: the first
  std::vector<Paint> paints;
  bool has_normals = false;
};

Vector3f load(const float* values) {
  return {values[0], values[1], values[2]};
}

[[noreturn]] void throw_bad_mesh(const RenderObject& object, const std::string& what, Eigen::Index row) {
  throw Error(Fault::bad_data, {.where = "object " + object.name,
                                .what = what,
                                .value = "row " + std::to_string(row),
                                .remedy = "repair the mesh"});
}

void copy_vertices(const RenderObject& object, ObjectData& data) {
  const TriangleMesh& mesh = *object.mesh;
  data.has_normals = mesh.normals.rows() == mesh.num_vertices() && mesh.num_vertices() > 0;
  data.vertices.resize(mesh.num_vertices());
  for (Eigen::Index i = 0; i < mesh.num_vertices(); ++i) {
    for (int c = 0; c < 3; ++c) {
      data.vertices[i].position[c] = float(mesh.positions(i, c));
      data.vertices[i].normal[c] = data.has_normals ? float(mesh.normals(i, c)) : 0.0f;
    }
    if (!load(data.vertices[i].position).allFinite()) throw_bad_mesh(object, "a vertex is not finite", i);
  }
}

void copy_triangles(const RenderObject& object, ObjectData& data) {
  const TriangleMesh& mesh = *object.mesh;
  data.triangles.resize(mesh.num_triangles());
  for (Eigen::Index t = 0; t < mesh.num_triangles(); ++t) {
    for (int c = 0; c < 3; ++c) {
      const int index = mesh.triangles(t, c);
      if (index < 0 || index >= mesh.num_vertices()) throw_bad_mesh(object, "a triangle has a corner too many", t);
      data.triangles[t].index[c] = unsigned(index);
    }
  }
}

void copy_paints(const RenderObject& object, ObjectData& data) {
  data.paints = object.paints();
  if (!object.has_paints()) return;
  data.paint = object.mesh->materials;
  for (std::size_t t = 0; t < data.paint.size(); ++t)
    if (data.paint[t] < 0 || data.paint[t] >= int(data.paints.size()))
      throw_bad_mesh(object, "a triangle has a material too many", Eigen::Index(t));
}

void copy_colors(const RenderObject& object, ObjectData& data) {
  const TriangleMesh& mesh = *object.mesh;
  copy_paints(object, data);
  if (object.look.vertex_colors && mesh.colors.rows() == mesh.num_vertices()) {
    data.colors.resize(mesh.num_vertices());
    for (Eigen::Index i = 0; i < mesh.num_vertices(); ++i)
      data.colors[i] = mesh.colors.row(i).cast<float>().transpose();
  }
  bool has_texture = false;
  for (Paint& paint : data.paints) {
    if (paint.texture && paint.texture->values.empty()) paint.texture = nullptr;
    has_texture |= paint.texture != nullptr;
  }
  if (has_texture && mesh.texture_coordinates.rows() == 3 * mesh.num_triangles()) {
    data.texture_coordinates.resize(mesh.texture_coordinates.rows());
    for (Eigen::Index i = 0; i < mesh.texture_coordinates.rows(); ++i)
      data.texture_coordinates[i] = mesh.texture_coordinates.row(i).transpose();
  }
}

// bilinear look-up, repeating; v runs upwards
Vector3f texture_color(const Image& image, const Vector2f& uv) {
  const float x = (uv.x() - std::floor(uv.x())) * float(image.width) - 0.5f;
  const float y = (1 - (uv.y() - std::floor(uv.y()))) * float(image.height) - 0.5f;
  const int x0 = int(std::floor(x)), y0 = int(std::floor(y));
  const auto wrap = [](int i, int n) { return i < 0 ? i + n : i >= n ? i - n : i; };
  const auto texel = [&](int i, int j) {
    const float* p = image.pixel(wrap(i, image.width), wrap(j, image.height));
    return image.channels >= 3 ? Vector3f(p[0], p[1], p[2]) : Vector3f(p[0], p[0], p[0]);
  };
  const float fx = x - float(x0), fy = y - float(y0);
  return (1 - fy) * ((1 - fx) * texel(x0, y0) + fx * texel(x0 + 1, y0)) +
         fy * ((1 - fx) * texel(x0, y0 + 1) + fx * texel(x0 + 1, y0 + 1));
}

Vector3f color_at(const ObjectData& object, const Hit& hit, float w) {
  const Paint& paint = object.paints[object.paint.empty() ? 0 : std::size_t(object.paint[hit.triangle])];
  Vector3f color = paint.base_color;
  if (!object.colors.empty()) {
    const Corners& corners = object.triangles[hit.triangle];
    color = w * object.colors[corners.index[0]] + hit.u * object.colors[corners.index[1]] +
            hit.v * object.colors[corners.index[2]];
  }
  if (paint.texture && !object.texture_coordinates.empty()) {
    const Vector2f* uv = &object.texture_coordinates[3 * std::size_t(hit.triangle)];
    color = color.cwiseProduct(texture_color(*paint.texture, w * uv[0] + hit.u * uv[1] + hit.v * uv[2]));
  }
  return color;
}

// how far the tangent plane at a vertex lies outside the triangle's point
Vector3f lift_to_tangent(const Vector3f& point, const Vector3f& vertex, const Vector3f& normal) {
  const float height = (point - vertex).dot(normal);
  return height < 0 ? Vector3f(-height * normal) : Vector3f(0, 0, 0);
}

// shading normal on the viewer's side of both surfaces, so that no point of a silhouette is black
Vector3f bend_towards(const Vector3f& normal, const Vector3f& to_viewer) {
  constexpr float least_cosine = 0.02f;
  const float cosine = normal.dot(to_viewer);
  return cosine >= least_cosine ? normal : (normal + (least_cosine - cosine) * to_viewer).normalized();
}

void interpolate_normal(const Vertex& a, const Vertex& b, const Vertex& c, const Hit& hit, float w, SurfacePoint& point,
                        const Vector3f& to_viewer, bool flipped) {
  const float side = flipped ? -1.0f : 1.0f;
  const Vector3f na = side * load(a.normal), nb = side * load(b.normal), nc = side * load(c.normal);
  const Vector3f sum = w * na + hit.u * nb + hit.v * nc;
  const float length2 = sum.squaredNorm();
  if (!(length2 > 1e-12f)) return;
  point.normal = bend_towards(sum / std::sqrt(length2), to_viewer);
  point.smooth_position += w * lift_to_tangent(point.position, load(a.position), na) +
                           hit.u * lift_to_tangent(point.position, load(b.position), nb) +
                           hit.v * lift_to_tangent(point.position, load(c.position), nc);
}

RTCRayHit to_library(const Ray& ray) {
  RTCRayHit query;
  query.ray.org_x = ray.origin.x();
  query.ray.org_y = ray.origin.y();
  query.ray.org_z = ray.origin.z();
  query.ray.tnear = 0;
  query.ray.dir_x = ray.direction.x();
  query.ray.dir_y = ray.direction.y();
  query.ray.dir_z = ray.direction.z();
  query.ray.time = 0;
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

void set_lane(RTCRayHit8& query, int i, const Ray& ray) {
  query.ray.org_x[i] = ray.origin.x();
  query.ray.org_y[i] = ray.origin.y();
  query.ray.org_z[i] = ray.origin.z();
  query.ray.tnear[i] = 0;
  query.ray.dir_x[i] = ray.direction.x();
  query.ray.dir_y[i] = ray.direction.y();
  query.ray.dir_z[i] = ray.direction.z();
  query.ray.time[i] = 0;
  query.ray.tfar[i] = ray.max_distance;
  query.ray.mask[i] = ~0u;
  query.ray.id[i] = 0;
  query.ray.flags[i] = 0;
  query.hit.geomID[i] = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
}

void call_intersect8(const int* valid, RTCScene scene, RTCRayHit8& query) {
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
  std::vector<ObjectData> objects;

  Data() = default;
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;
  ~Data() {
    if (scene) rtcReleaseScene(scene);
    if (device) rtcReleaseDevice(device);
  }

  void attach(ObjectData& object, unsigned id) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, object.vertices.data(), 0,
                               sizeof(Vertex), object.vertices.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, object.triangles.data(), 0,
                               sizeof(Corners), object.triangles.size());
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
  }
};

RayScene::RayScene(const RenderScene& scene) : data_(std::make_unique<Data>()) {
  data_->objects.resize(scene.objects.size());
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    copy_vertices(scene.objects[i], data_->objects[i]);
    copy_triangles(scene.objects[i], data_->objects[i]);
    copy_colors(scene.objects[i], data_->objects[i]);
  }
  data_->device = make_device();
  data_->scene = rtcNewScene(data_->device);
  rtcSetSceneFlags(data_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(data_->scene, RTC_BUILD_QUALITY_MEDIUM);
  for (std::size_t i = 0; i < data_->objects.size(); ++i)
    if (!data_->objects[i].triangles.empty()) data_->attach(data_->objects[i], unsigned(i));
  rtcCommitScene(data_->scene);
}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;
RayScene& RayScene::operator=(RayScene&&) noexcept = default;

Hit RayScene::intersect(const Ray& ray) const {
  RTCRayHit query = to_library(ray);
  call_intersect(data_->scene, query);
  return {.object = query.hit.geomID,
          .triangle = query.hit.primID,
          .distance = query.ray.tfar,
          .u = query.hit.u,
          .v = query.hit.v};
}

void RayScene::intersect_coherent(const Ray* rays, int count, Hit* hits) const {
  constexpr int width = 8;
  for (int begin = 0; begin < count; begin += width) {
    RTCRayHit8 query;
    alignas(32) int valid[width];
    for (int i = 0; i < width; ++i) {
      valid[i] = begin + i < count ? -1 : 0;
      set_lane(query, i, rays[std::min(begin + i, count - 1)]);
    }
    call_intersect8(valid, data_->scene, query);
    for (int i = 0; i < std::min(width, count - begin); ++i) {
      hits[begin + i] = {.object = query.hit.geomID[i],
                         .triangle = query.hit.primID[i],
                         .distance = query.ray.tfar[i],
                         .u = query.hit.u[i],
                         .v = query.hit.v[i]};
    }
  }
}

bool RayScene::occluded(const Ray& ray) const {
  RTCRayHit query = to_library(ray);
  call_occluded(data_->scene, query.ray);
  return query.ray.tfar < 0;
}

SurfacePoint RayScene::surface(const Hit& hit, const Vector3f& ray_direction) const {
  const ObjectData& object = data_->objects[hit.object];
  const Corners& corners = object.triangles[hit.triangle];
  const Vertex &a = object.vertices[corners.index[0]], &b = object.vertices[corners.index[1]],
               &c = object.vertices[corners.index[2]];
  const Vector3f pa = load(a.position), pb = load(b.position), pc = load(c.position);
  const float w = 1 - hit.u - hit.v;
  SurfacePoint point;
  point.position = w * pa + hit.u * pb + hit.v * pc;
  Vector3f normal = (pb - pa).cross(pc - pa);
  const float twice_area = normal.norm();
  normal = twice_area > 1e-18f ? Vector3f(normal / twice_area) : normal.stableNormalized();
  const bool flipped = normal.dot(ray_direction) > 0;
  if (flipped) normal = -normal;
  point.geometric_normal = point.normal = normal;
  point.smooth_position = point.position;
  point.offset = 4e-6f * (pa.cwiseAbs().maxCoeff() + pb.cwiseAbs().maxCoeff() + pc.cwiseAbs().maxCoeff());
  if (object.has_normals) interpolate_normal(a, b, c, hit, w, point, -ray_direction, flipped);
  point.base_color = color_at(object, hit, w);
  return point;
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
