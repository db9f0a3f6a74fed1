#include "embedding/caches/gltf_file.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

#include "embedding/caches/bytes.h"

namespace umax {
namespace {

constexpr int float_numbers = 5126, unsigned_numbers = 5125;           // component types of glTF
constexpr int no_target = 0, vertex_data = 34962, index_data = 34963;  // targets of its buffer views

/// The values of vertices that may be copies.
FloatPoints split_values(const SplitVertices& split, const FloatPoints& values) {
  FloatPoints out(Eigen::Index(split.source.size()), 3);
  for (Eigen::Index v = 0; v < out.rows(); ++v) out.row(v) = values.row(split.source[std::size_t(v)]);
  return out;
}

/// Exact, as readers compare it with the numbers.
std::string vector_text(const Eigen::RowVector3f& v) {
  return fmt::format("[{},{},{}]", double(v.x()), double(v.y()), double(v.z()));
}

std::string joined(const std::string& list, const std::string& item) {
  return list.empty() ? item : list + ",\n" + item;
}

/// textures: of the file, whose numbers materials name.
std::string material_text(const SurfaceMaterial& material, const std::vector<std::string>& textures) {
  const bool is_white = material.vertex_colors;
  const Vector3f color = is_white ? Vector3f(1, 1, 1) : material.base_color.cwiseMin(1).cwiseMax(0).eval();
  std::string pbr = fmt::format("\"baseColorFactor\":[{},{},{},1],\"metallicFactor\":{},\"roughnessFactor\":{}",
                                color.x(), color.y(), color.z(), material.metallic, material.roughness);
  const auto texture = std::find(textures.begin(), textures.end(), material.texture);
  if (texture != textures.end())
    pbr += fmt::format(",\"baseColorTexture\":{{\"index\":{}}}", texture - textures.begin());
  std::string extensions = fmt::format("\"KHR_materials_ior\":{{\"ior\":{}}}", material.ior);
  if (material.clearcoat > 0)
    extensions += fmt::format(",\"KHR_materials_clearcoat\":{{\"clearcoatFactor\":{},\"clearcoatRoughnessFactor\":{}}}",
                              material.clearcoat, material.clearcoat_roughness);
  return fmt::format("{{\"name\":\"{}\",\"doubleSided\":true,\"pbrMetallicRoughness\":{{{}}},\"extensions\":{{{}}}}}",
                     material.name, pbr, extensions);
}

std::string extensions_used(const std::vector<SurfaceMaterial>& materials) {
  const bool has_coat = std::any_of(materials.begin(), materials.end(),
                                    [](const SurfaceMaterial& material) { return material.clearcoat > 0; });
  return std::string("\"KHR_materials_ior\"") + (has_coat ? ",\"KHR_materials_clearcoat\"" : "");
}

std::string camera_text(const ClipCamera& camera) {
  return fmt::format(
      "\"cameras\":[{{\"type\":\"perspective\",\"perspective\":{{\"aspectRatio\":{},\"yfov\":{},\"znear\":0.01}}}}],\n",
      camera.aspect, camera.vertical_fov_degrees * std::numbers::pi / 180);
}

std::string camera_node(const ClipCamera& camera) {
  const CameraAxes axes = axes_of(camera);
  Matrix3d turn;
  turn << axes.right, axes.up, axes.back;
  const Eigen::Quaterniond q = Eigen::Quaterniond(turn).normalized();
  const Vector3d& p = camera.position;
  return fmt::format(",\n{{\"name\":\"camera\",\"camera\":0,\"translation\":[{},{},{}],\"rotation\":[{},{},{},{}]}}",
                     p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w());
}

/// What the file says of itself and of its clip.
std::string asset_text(const ClipSpace& clip) {
  return fmt::format(
      "{{\"asset\":{{\"version\":\"2.0\",\"generator\":\"umax\",\"extras\":{{\"fps\":{},\"firstFrame\":{},"
      "\"lastFrame\":{}}}}},\n",
      clip.fps, clip.frames.front(), clip.frames.back());
}

}  // namespace

GltfWriter::GltfWriter(const std::filesystem::path& path, const MovingSurface& surface, const ClipSpace& clip,
                       const std::optional<ClipCamera>& camera)
    : surface_(&surface),
      clip_(&clip),
      camera_(camera),
      split_(split_vertices(surface.num_vertices(), surface.triangles, surface.texture_coordinates)),
      json_(path),
      numbers_(std::filesystem::path(path).replace_extension(".bin")) {}

int GltfWriter::add_accessor(std::string_view bytes, Eigen::Index count, const char* type, int component, int target,
                             const std::string& more) {
  std::string view = fmt::format("{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}", numbers_.size(), bytes.size());
  if (target != no_target) view += fmt::format(",\"target\":{}", target);
  views_ = joined(views_, view + "}");
  accessors_ =
      joined(accessors_, fmt::format("{{\"bufferView\":{},\"componentType\":{},\"count\":{},\"type\":\"{}\"{}}}",
                                     num_accessors_, component, count, type, more));
  numbers_.write(bytes);
  return num_accessors_++;
}

int GltfWriter::add_points(const FloatPoints& values, bool with_range) {
  std::string range;
  if (with_range)
    range = fmt::format(",\"min\":{},\"max\":{}", vector_text(values.colwise().minCoeff()),
                        vector_text(values.colwise().maxCoeff()));
  return add_accessor(bytes_of(values), values.rows(), "VEC3", float_numbers, vertex_data, range);
}

/// Of each material its triangles.
void GltfWriter::write_indices() {
  for (std::size_t material = 0; material < surface_->materials.size(); ++material) {
    const std::vector<int> triangles = surface_->triangles_of(material);
    if (triangles.empty()) continue;
    std::vector<std::uint32_t> corners;
    corners.reserve(3 * triangles.size());
    for (const int t : triangles)
      for (int k = 0; k < 3; ++k) corners.push_back(std::uint32_t(split_.triangles(t, k)));
    parts_.push_back({material, add_accessor(bytes_of(corners), Eigen::Index(corners.size()), "SCALAR",
                                             unsigned_numbers, index_data)});
  }
}

void GltfWriter::write_first(const SurfaceFrame& frame) {
  write_indices();
  first_positions_ = split_values(split_, frame.positions);
  first_normals_ = split_values(split_, frame.normals);
  attributes_ = fmt::format("\"POSITION\":{},\"NORMAL\":{}", add_points(first_positions_, true),
                            add_points(first_normals_, false));
  if (!split_.coordinates.empty()) {
    TextureCoordinates coordinates(Eigen::Index(split_.coordinates.size()), 2);
    for (Eigen::Index v = 0; v < coordinates.rows(); ++v)  // downwards in glTF
      coordinates.row(v) << split_.coordinates[std::size_t(v)].x(), 1 - split_.coordinates[std::size_t(v)].y();
    attributes_ += fmt::format(",\"TEXCOORD_0\":{}", add_accessor(bytes_of(coordinates), coordinates.rows(), "VEC2",
                                                                  float_numbers, vertex_data));
  }
  if (surface_->materials.front().vertex_colors)
    attributes_ += fmt::format(",\"COLOR_0\":{}", add_points(split_values(split_, surface_->colors), false));
}

void GltfWriter::append(const SurfaceFrame& frame) {
  times_.push_back(float(frame.time));
  if (times_.size() == 1) {
    write_first(frame);
    return;
  }
  const FloatPoints positions = split_values(split_, frame.positions) - first_positions_,
                    normals = split_values(split_, frame.normals) - first_normals_;
  targets_ = joined(targets_, fmt::format("{{\"POSITION\":{},\"NORMAL\":{}}}", add_points(positions, true),
                                          add_points(normals, false)));
  target_names_ = joined(target_names_, fmt::format("\"frame {}\"", frame.frame));
}

std::string GltfWriter::animation_text() {
  if (times_.size() < 2) return {};
  const int input =
      add_accessor(bytes_of(times_), Eigen::Index(times_.size()), "SCALAR", float_numbers, no_target,
                   fmt::format(",\"min\":[{}],\"max\":[{}]", double(times_.front()), double(times_.back())));
  // row i: the weights of all targets in frame i
  const std::size_t num_targets = times_.size() - 1;
  const long long start = numbers_.size();
  for (std::size_t i = 0; i < times_.size(); ++i) {
    std::vector<float> weights(num_targets, 0.0f);
    if (i > 0) weights[i - 1] = 1;
    numbers_.write(bytes_of(weights));
  }
  const std::size_t count = times_.size() * num_targets;
  views_ = joined(views_, fmt::format("{{\"buffer\":0,\"byteOffset\":{},\"byteLength\":{}}}", start, 4 * count));
  accessors_ =
      joined(accessors_, fmt::format("{{\"bufferView\":{},\"componentType\":{},\"count\":{},\"type\":\"SCALAR\"}}",
                                     num_accessors_, float_numbers, count));
  return fmt::format(
      "\"animations\":[{{\"name\":\"clip\",\"channels\":[{{\"sampler\":0,\"target\":{{\"node\":0,\"path\":\"weights\"}}"
      "}}],"
      "\"samplers\":[{{\"input\":{},\"output\":{},\"interpolation\":\"LINEAR\"}}]}}],\n",
      input, num_accessors_++);
}

std::string GltfWriter::mesh_text() const {
  std::string primitives;
  for (const Part& part : parts_)
    primitives = joined(
        primitives, fmt::format("{{\"attributes\":{{{}}},\"indices\":{},\"material\":{}{}}}", attributes_, part.indices,
                                part.material, targets_.empty() ? "" : ",\"targets\":[" + targets_ + "]"));
  std::string text = fmt::format("\"meshes\":[{{\"name\":\"{}\",\"primitives\":[{}]", surface_->name, primitives);
  if (!targets_.empty()) {
    std::string zeros = "0";
    for (std::size_t i = 2; i < times_.size(); ++i) zeros += ",0";
    text += ",\"weights\":[" + zeros + "],\"extras\":{\"targetNames\":[" + target_names_ + "]}";
  }
  return text + "}],\n";
}

void GltfWriter::write_materials() {
  const std::vector<std::string> files = surface_->textures();
  std::string materials, textures, images;
  for (const SurfaceMaterial& material : surface_->materials)
    materials = joined(materials, material_text(material, files));
  for (std::size_t i = 0; i < files.size(); ++i) {
    textures = joined(textures, fmt::format("{{\"source\":{}}}", i));
    images = joined(images, fmt::format("{{\"uri\":\"{}\"}}", files[i]));
  }
  json_.write("\"materials\":[" + materials + "],\n");
  if (!files.empty()) json_.write("\"textures\":[" + textures + "],\"images\":[" + images + "],\n");
}

void GltfWriter::finish() {
  const std::string animation = animation_text();
  json_.write(asset_text(*clip_));
  json_.write("\"extensionsUsed\":[" + extensions_used(surface_->materials) + "],\n");
  json_.write(std::string("\"scene\":0,\"scenes\":[{\"nodes\":[0") + (camera_ ? ",1" : "") + "]}],\n");
  json_.write(fmt::format("\"nodes\":[{{\"name\":\"{}\",\"mesh\":0}}", surface_->name));
  if (camera_) json_.write(camera_node(*camera_));
  json_.write("],\n");
  if (camera_) json_.write(camera_text(*camera_));
  write_materials();
  json_.write(mesh_text());
  json_.write(animation);
  json_.write(fmt::format("\"buffers\":[{{\"uri\":\"{}\",\"byteLength\":{}}}],\n", numbers_.path().filename().string(),
                          numbers_.size()));
  json_.write("\"bufferViews\":[\n" + views_ + "],\n\"accessors\":[\n" + accessors_ + "]}\n");
  numbers_.finish();
  json_.finish();
}

}  // namespace umax
