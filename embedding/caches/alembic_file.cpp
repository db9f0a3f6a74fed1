#include "embedding/caches/alembic_file.h"

#include <array>
#include <cmath>
#include <numbers>

#include "embedding/caches/bytes.h"
#include "embedding/caches/corner_values.h"

namespace umax {
namespace {

constexpr const char* xform_object = "schema=AbcGeom_Xform_v3;schemaObjTitle=AbcGeom_Xform_v3:.xform";
constexpr const char* xform_schema = "schema=AbcGeom_Xform_v3";
constexpr const char* mesh_object =
    "schema=AbcGeom_PolyMesh_v1;schemaBaseType=AbcGeom_GeomBase_v1;schemaObjTitle=AbcGeom_PolyMesh_v1:.geom";
constexpr const char* mesh_schema = "schema=AbcGeom_PolyMesh_v1;schemaBaseType=AbcGeom_GeomBase_v1";
constexpr const char* faces_object =
    "schema=AbcGeom_FaceSet_v1;schemaBaseType=AbcGeom_GeomBase_v1;schemaObjTitle=AbcGeom_FaceSet_v1:.faceset";
constexpr const char* faces_schema = "schema=AbcGeom_FaceSet_v1;schemaBaseType=AbcGeom_GeomBase_v1";
constexpr const char* camera_object = "schema=AbcGeom_Camera_v1;schemaObjTitle=AbcGeom_Camera_v1:.geom";
constexpr const char* camera_schema = "schema=AbcGeom_Camera_v1";

std::string geom_param(const std::string& scope, const std::string& interpretation, int extent) {
  return "arrayExtent=1;geoScope=" + scope + ";interpretation=" + interpretation +
         ";isGeomParam=true;podExtent=" + std::to_string(extent) + ";podName=float32_t";
}

AlembicProperty array(const std::string& name, AlembicPod pod, int extent, const std::string& metadata = {}) {
  return {
      .name = name, .kind = AlembicKind::array, .metadata = metadata, .pod = pod, .extent = extent, .is_timed = true};
}

AlembicProperty scalar(const std::string& name, AlembicPod pod, int extent, const std::string& metadata = {}) {
  return {.name = name, .kind = AlembicKind::scalar, .metadata = metadata, .pod = pod, .extent = extent};
}

AlembicProperty compound(const std::string& name, const std::string& metadata,
                         std::vector<AlembicProperty> properties) {
  return {.name = name, .metadata = metadata, .properties = std::move(properties)};
}

/// A transform with what it holds.
AlembicObject transform(const std::string& name, std::vector<AlembicProperty> properties, AlembicObject child) {
  return {.name = name,
          .metadata = xform_object,
          .properties = {compound(".xform", xform_schema, std::move(properties))},
          .children = {std::move(child)}};
}

/// Position of a corner among its triangle's in the file: faces are clockwise there.
Eigen::Index turned_corner(Eigen::Index corner) {
  return corner - corner % 3 + (2 - corner % 3);
}

/// Rows: what the camera's axes are, and where it stands.
Eigen::Matrix<double, 4, 4, Eigen::RowMajor> world_from_camera(const ClipCamera& camera) {
  const CameraAxes axes = axes_of(camera);
  Eigen::Matrix<double, 4, 4, Eigen::RowMajor> matrix = Eigen::Matrix4d::Identity();
  matrix.block<1, 3>(0, 0) = axes.right.transpose();
  matrix.block<1, 3>(1, 0) = axes.up.transpose();
  matrix.block<1, 3>(2, 0) = axes.back.transpose();
  matrix.block<1, 3>(3, 0) = camera.position.transpose();
  return matrix;
}

/// focal length [mm], film's width [cm], offset, height, offset, squeeze, 4 x overscan, f-stop, focus, shutter [s],
/// clipping
std::array<double, 16> lens_of(const ClipCamera& camera, const ClipSpace& clip) {
  constexpr double film = 2.4, pinhole = 1e3;  // [cm] of its height; f-stop
  const double focal = 10 * film / 2 / std::tan(camera.vertical_fov_degrees * std::numbers::pi / 360);
  const double stop = camera.aperture_radius > 0 ? focal / 1000 / clip.unit / (2 * camera.aperture_radius) : pinhole;
  return {focal,
          film * camera.aspect,
          0,
          film,
          0,
          1,
          0,
          0,
          0,
          0,
          stop,
          camera.focus_distance,
          0,
          1 / clip.fps,
          0.01 / clip.unit,
          1e4 / clip.unit};
}

template <class T>
std::string_view bytes_of_value(const T& value) {
  return {reinterpret_cast<const char*>(&value), sizeof value};
}

}  // namespace

AlembicWriter::AlembicWriter(const std::filesystem::path& path, const MovingSurface& surface, const ClipSpace& clip)
    : surface_(&surface),
      clip_(&clip),
      archive_(path),
      bounds_(scalar(".selfBnds", AlembicPod::float64, 6, "interpretation=box")),
      positions_(array("P", AlembicPod::float32, 3, "geoScope=vtx;interpretation=point")),
      indices_(array(".faceIndices", AlembicPod::int32, 1)),
      counts_(array(".faceCounts", AlembicPod::int32, 1)),
      velocities_(array(".velocities", AlembicPod::float32, 3, "interpretation=vector")),
      normals_(array("N", AlembicPod::float32, 3, geom_param("vtx", "normal", 3))),
      texture_(compound("uv", geom_param("fvr", "vector", 2), {})),
      colors_(array("Cd", AlembicPod::float32, 3, geom_param("vtx", "rgb", 3))) {
  bounds_.is_timed = true;
  for (AlembicProperty* moving : {&bounds_, &positions_, &velocities_, &normals_}) moving->is_constant = false;
}

void AlembicWriter::write_first() {
  const Eigen::Index num_corners = 3 * surface_->triangles.rows();
  std::vector<std::int32_t> indices(static_cast<std::size_t>(num_corners));
  for (Eigen::Index corner = 0; corner < num_corners; ++corner)
    indices[std::size_t(turned_corner(corner))] = surface_->triangles(corner / 3, corner % 3);
  archive_.add_sample(indices_, bytes_of(indices));
  archive_.add_sample(counts_, bytes_of(std::vector<std::int32_t>(std::size_t(num_corners / 3), 3)));
  if (surface_->texture_coordinates.rows() > 0) {
    const CornerValues texture = distinct_values(surface_->texture_coordinates);
    std::vector<std::uint32_t> corners(static_cast<std::size_t>(num_corners));
    for (Eigen::Index corner = 0; corner < num_corners; ++corner)
      corners[std::size_t(turned_corner(corner))] = std::uint32_t(texture.index[std::size_t(corner)]);
    std::string values;
    for (const Eigen::RowVector2f& uv : texture.values) values += bytes_of(uv);
    texture_.properties = {array(".vals", AlembicPod::float32, 2, texture_.metadata),
                           array(".indices", AlembicPod::uint32, 1)};
    archive_.add_sample(texture_.properties[0], values);
    archive_.add_sample(texture_.properties[1], bytes_of(corners));
  }
  if (surface_->colors.rows() > 0) archive_.add_sample(colors_, bytes_of(surface_->colors));
}

void AlembicWriter::append(const SurfaceFrame& frame) {
  if (times_.times.empty()) write_first();
  times_.times.push_back(frame.frame / clip_->fps);
  const Eigen::RowVector3d low = frame.positions.colwise().minCoeff().cast<double>(),
                           high = frame.positions.colwise().maxCoeff().cast<double>();
  const std::array<double, 6> box{low[0], low[1], low[2], high[0], high[1], high[2]};
  archive_.add_sample(bounds_, bytes_of(box));
  archive_.add_sample(positions_, bytes_of(frame.positions));
  archive_.add_sample(velocities_, bytes_of(frame.velocities));
  archive_.add_sample(normals_, bytes_of(frame.normals));
}

/// Which faces each material has, where there are several.
std::vector<AlembicObject> AlembicWriter::face_sets() {
  std::vector<AlembicObject> sets;
  if (surface_->materials.size() < 2) return sets;
  const std::array<double, 6> box{};  // unknown
  for (std::size_t i = 0; i < surface_->materials.size(); ++i) {
    AlembicProperty bounds = scalar(".selfBnds", AlembicPod::float64, 6, "interpretation=box"),
                    faces = array(".faces", AlembicPod::int32, 1);
    faces.is_timed = false;
    archive_.add_sample(bounds, bytes_of(box));
    archive_.add_sample(faces, bytes_of(surface_->triangles_of(i)));
    sets.push_back({.name = surface_->materials[i].name,
                    .metadata = faces_object,
                    .properties = {compound(".faceset", faces_schema, {bounds, faces})}});
  }
  return sets;
}

void AlembicWriter::finish() {
  std::vector<AlembicProperty> geometry{bounds_, positions_, indices_, counts_, velocities_};
  if (!texture_.properties.empty()) geometry.push_back(texture_);
  geometry.push_back(normals_);
  if (!colors_.samples.empty()) geometry.push_back(compound(".arbGeomParams", {}, {colors_}));
  const AlembicObject mesh{.name = surface_->name + "Shape",
                           .metadata = mesh_object,
                           .properties = {compound(".geom", mesh_schema, std::move(geometry))},
                           .children = face_sets()};
  archive_.finish({transform(surface_->name, {}, mesh)}, times_, surface_->name);
}

void write_alembic_camera(const std::filesystem::path& path, const ClipCamera& camera, const ClipSpace& clip) {
  constexpr std::uint8_t yes = 1, a_matrix = 0x30;
  AlembicArchive archive(path);
  AlembicProperty inherits = scalar(".inherits", AlembicPod::boolean, 1), ops = scalar(".ops", AlembicPod::uint8, 1),
                  values = scalar(".vals", AlembicPod::float64, 16),
                  turned = scalar("isNotConstantIdentity", AlembicPod::boolean, 1),
                  core = scalar(".core", AlembicPod::float64, 16);
  archive.add_sample(inherits, bytes_of_value(yes));
  archive.add_sample(ops, bytes_of_value(a_matrix));
  archive.add_sample(values, bytes_of(world_from_camera(camera)));
  archive.add_sample(turned, bytes_of_value(yes));
  archive.add_sample(core, bytes_of(lens_of(camera, clip)));
  const AlembicObject shape{
      .name = "cameraShape", .metadata = camera_object, .properties = {compound(".geom", camera_schema, {core})}};
  archive.finish({transform("camera", {inherits, ops, values, turned}, shape)}, {.times = {1 / clip.fps}}, "camera");
}

}  // namespace umax
