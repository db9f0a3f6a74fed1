// Cameras of glTF 2.0: nodes with their parents, and what animations do to them.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>

#include "core/files/read_file.h"
#include "embedding/cameras/camera_readers.h"
#include "embedding/scanning/raw_numbers.h"

namespace umax::cameras {
namespace {

using nlohmann::json;

struct Document {
  const std::filesystem::path& path;
  json root;
  std::string binary;  // of a .glb
};

std::size_t little_endian(std::string_view bytes, std::size_t at) {
  return std::size_t(decode_number(bytes.data() + at, NumberType::uint32, false));
}

/// The text and the binary chunk of a .glb.
void unpack(std::string_view bytes, std::string_view& text, std::string& binary, const std::filesystem::path& path) {
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    const std::size_t size = little_endian(bytes, at);
    if (size > bytes.size() - at - 8) refuse(path, "is truncated");
    const std::string_view kind = bytes.substr(at + 4, 4), chunk = bytes.substr(at + 8, size);
    if (kind == "JSON") text = chunk;
    if (kind == std::string_view("BIN\0", 4)) binary = chunk;
    at += 8 + size;
  }
}

std::string decode_base64(std::string_view text) {
  static constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    const std::size_t value = letters.find(c);
    if (value == letters.npos) continue;
    bits = bits << 6 | unsigned(value);
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes += char(bits >> count & 255);
  }
  return bytes;
}

/// "my%20shot.bin" is "my shot.bin".
std::string without_escapes(const std::string& uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    unsigned code = 0;
    const char* digits = uri.data() + i + 1;
    if (uri[i] == '%' && i + 2 < uri.size() && std::from_chars(digits, digits + 2, code, 16).ptr == digits + 2) {
      text += char(code);
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

std::string buffer_of(const Document& document, std::size_t index) {
  const json& buffer = document.root.at("buffers").at(index);
  if (!buffer.contains("uri")) return document.binary;
  const std::string uri = buffer.at("uri").get<std::string>();
  if (uri.starts_with("data:"))
    return decode_base64(std::string_view(uri).substr(std::min(uri.find(',') + 1, uri.size())));
  const std::filesystem::path beside = document.path.parent_path() / without_escapes(uri);
  if (std::error_code failed; !std::filesystem::is_regular_file(beside, failed))
    refuse(document.path, "names a file that is not there", beside.string(), "put it beside the glTF file");
  return read_file(beside);
}

struct Component {
  NumberType type;
  double largest;  // that stands for 1 where numbers are normalised
};

Component component_of(const Document& document, int code) {
  static const std::map<int, Component> components{
      {5120, {NumberType::int8, 127}},     {5121, {NumberType::uint8, 255}}, {5122, {NumberType::int16, 32767}},
      {5123, {NumberType::uint16, 65535}}, {5125, {NumberType::uint32, 1}},  {5126, {NumberType::float32, 1}}};
  const auto found = components.find(code);
  if (found == components.end()) refuse(document.path, "has numbers of an unknown kind", std::to_string(code));
  return found->second;
}

/// An accessor's numbers, `width` to an element.
std::vector<double> numbers_of(const Document& document, std::size_t index, int width) {
  const json& accessor = document.root.at("accessors").at(index);
  if (accessor.contains("sparse") || !accessor.contains("bufferView"))
    refuse(document.path, "has a sparse animation", "", "export it without sparse accessors");
  const json& view = document.root.at("bufferViews").at(accessor.at("bufferView").get<std::size_t>());
  const Component component = component_of(document, accessor.at("componentType").get<int>());
  const std::string bytes = buffer_of(document, view.at("buffer").get<std::size_t>());
  const auto count = accessor.at("count").get<std::size_t>(), size = std::size_t(size_of(component.type)),
             element = size * std::size_t(width), stride = view.value("byteStride", element),
             first = view.value("byteOffset", std::size_t(0)) + accessor.value("byteOffset", std::size_t(0));
  if (count == 0 || first > bytes.size() || stride < element || count > bytes.size() / stride + 1 ||
      (count - 1) * stride + element > bytes.size() - first)
    refuse(document.path, "has animations beyond the end of its data");
  const double scale = accessor.value("normalized", false) ? 1 / component.largest : 1;
  std::vector<double> numbers;
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t c = 0; c < std::size_t(width); ++c)
      numbers.push_back(scale * decode_number(bytes.data() + first + i * stride + c * size, component.type, false));
  return numbers;
}

Samples samples_of(const Document& document, const json& sampler, int width, bool turns) {
  Samples samples{.times = numbers_of(document, sampler.at("input").get<std::size_t>(), 1),
                  .values = numbers_of(document, sampler.at("output").get<std::size_t>(), width),
                  .width = width};
  const std::string kind = sampler.value("interpolation", "LINEAR");
  samples.between = kind == "STEP"          ? Samples::Between::steps
                    : kind == "CUBICSPLINE" ? Samples::Between::spline
                    : turns                 ? Samples::Between::turns
                                            : Samples::Between::linear;
  const std::size_t each = std::size_t(width) * (kind == "CUBICSPLINE" ? 3 : 1);
  if (samples.values.size() != each * samples.times.size())
    refuse(document.path, "has an animation with another number of values than of times");
  const auto& times = samples.times;
  const bool rises = std::adjacent_find(times.begin(), times.end(), std::greater_equal<>()) == times.end();
  const auto is_finite = [](double number) { return std::isfinite(number); };
  if (!rises || !std::all_of(times.begin(), times.end(), is_finite) ||
      !std::all_of(samples.values.begin(), samples.values.end(), is_finite))
    refuse(document.path, "has an animation whose times do not increase, or numbers that are not finite");
  return samples;
}

/// A node and what moves it.
struct Node {
  std::optional<Eigen::Matrix4d> matrix;
  std::map<std::string, Samples> parts;  // "translation", "rotation", "scale"; fixed ones have one sample
};

Samples fixed(std::vector<double> values) {
  const int width = int(values.size());
  return {.times = {0}, .values = std::move(values), .width = width};
}

Node node_of(const Document& document, std::size_t index) {
  const json& node = document.root.at("nodes").at(index);
  Node made;
  if (node.contains("matrix")) {
    const auto m = node.at("matrix").get<std::array<double, 16>>();
    made.matrix = Eigen::Map<const Eigen::Matrix4d>(m.data());  // by columns, both
  }
  made.parts["translation"] = fixed(node.value("translation", std::vector<double>{0, 0, 0}));
  made.parts["rotation"] = fixed(node.value("rotation", std::vector<double>{0, 0, 0, 1}));
  made.parts["scale"] = fixed(node.value("scale", std::vector<double>{1, 1, 1}));
  for (const auto& [part, samples] : made.parts)
    if (samples.width != (part == "rotation" ? 4 : 3)) refuse(document.path, "has a node with a damaged " + part);
  return made;
}

/// Lets the animations move a node; the first one that moves a part counts.
void animate(const Document& document, std::size_t index, Node& node) {
  if (!document.root.contains("animations")) return;
  for (const json& animation : document.root.at("animations"))
    for (const json& channel : animation.at("channels")) {
      const json& target = channel.at("target");
      const std::string part = target.value("path", "");
      if (target.value("node", std::size_t(-1)) != index || node.parts.count(part) == 0) continue;
      if (node.parts[part].times.size() > 1) continue;
      const bool turns = part == "rotation";
      node.parts[part] = samples_of(document, animation.at("samplers").at(channel.at("sampler").get<std::size_t>()),
                                    turns ? 4 : 3, turns);
      node.matrix.reset();
    }
}

Eigen::Matrix4d matrix_at(const Node& node, double time) {
  if (node.matrix) return *node.matrix;
  const auto value = [&](const char* part) { return node.parts.at(part).at(time); };
  const std::vector<double> move = value("translation"), turn = value("rotation"), scale = value("scale");
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
  matrix.topLeftCorner<3, 3>() =
      Eigen::Quaterniond(turn[3], turn[0], turn[1], turn[2]).normalized().toRotationMatrix() *
      Vector3d(scale[0], scale[1], scale[2]).asDiagonal();
  matrix.topRightCorner<3, 1>() = Vector3d(move[0], move[1], move[2]);
  return matrix;
}

/// The node, its parent and so on.
std::vector<Node> chain_of(const Document& document, std::size_t index) {
  const json& nodes = document.root.at("nodes");
  std::vector<std::size_t> parents(nodes.size(), nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i)
    for (const json& child : nodes[i].value("children", json::array())) parents.at(child.get<std::size_t>()) = i;
  std::vector<Node> chain;
  for (; index < nodes.size(); index = parents[index]) {
    if (chain.size() > nodes.size()) refuse(document.path, "has nodes that hold themselves");
    chain.push_back(node_of(document, index));
    animate(document, index, chain.back());
  }
  return chain;
}

/// Time of the first key of all animations; 0 without any.
double start_of(const Document& document) {
  std::optional<double> first;
  for (const json& animation : document.root.value("animations", json::array()))
    for (const json& sampler : animation.at("samplers")) {
      const json& input = document.root.at("accessors").at(sampler.at("input").get<std::size_t>());
      const double time = input.contains("min") ? input.at("min").at(0).get<double>()
                                                : numbers_of(document, sampler.at("input").get<std::size_t>(), 1)[0];
      first = std::min(first.value_or(time), time);
    }
  return first.value_or(0);
}

MovingCamera camera_of(const Document& document, const std::string& wanted) {
  std::vector<std::vector<std::string>> names;
  std::vector<std::size_t> places;
  const json nodes = document.root.value("nodes", json::array());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if (!nodes[i].contains("camera")) continue;
    const json& camera = document.root.at("cameras").at(nodes[i].at("camera").get<std::size_t>());
    names.push_back({nodes[i].value("name", "node " + std::to_string(i)), camera.value("name", "")});
    places.push_back(i);
  }
  const std::size_t chosen = choose(document.path, names, wanted), node = places[chosen];
  const json& camera = document.root.at("cameras").at(nodes[node].at("camera").get<std::size_t>());
  if (camera.value("type", "") != "perspective")
    refuse(document.path, "has a camera without perspective", names[chosen].front(), "make it a perspective camera");
  const double fov = camera.at("perspective").at("yfov").get<double>() * 180 / std::numbers::pi;
  return {.name = names[chosen].front(),
          .start = start_of(document),
          .at = [chain = chain_of(document, node), fov](double time) {
            Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
            for (const Node& one : chain) matrix = matrix_at(one, time) * matrix;
            return place_from(matrix, fov);
          }};
}

}  // namespace

MovingCamera read_gltf(const std::filesystem::path& path, std::string_view bytes, const std::string& name) {
  Document document{path, {}, {}};
  std::string_view text = bytes;
  if (bytes.starts_with("glTF")) unpack(bytes, text, document.binary, path);
  try {
    document.root = json::parse(text);
    return camera_of(document, name);
  } catch (const json::exception& error) {
    refuse(path, "is damaged glTF", error.what());
  } catch (const std::out_of_range&) {
    refuse(path, "is damaged glTF", "a node that is not there");
  }
}

}  // namespace umax::cameras
