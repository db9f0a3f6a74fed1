#include "embedding/caches/alembic_archive.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "embedding/caches/bytes.h"

namespace umax {
namespace {

// bits of a property's header
constexpr std::uint32_t scalar_like_bit = 0x1, timed_bit = 0x100, homogenous_bit = 0x400, constant_bit = 0x800;
constexpr int size_shift = 2, pod_shift = 4, extent_shift = 12, metadata_shift = 20;

constexpr std::int32_t library_version = 10809;                      // of which this is the format: 1.8.9
constexpr double acyclic = std::numeric_limits<double>::max() / 32;  // time of a cycle where there is none

int size_of_number(AlembicPod pod) {
  switch (pod) {
    case AlembicPod::boolean:
    case AlembicPod::uint8:
      return 1;
    case AlembicPod::uint32:
    case AlembicPod::int32:
    case AlembicPod::float32:
      return 4;
    case AlembicPod::float64:
      return 8;
  }
  return 0;
}

std::string_view bytes_of_hash(const Hash128& hash) {
  return bytes_of(hash);
}

/// A number in 1, 2 or 4 bytes: hint 0, 1, 2.
void append_sized(std::string& out, std::uint32_t value, int hint) {
  std::string bytes;
  append_bytes(bytes, value);
  out += bytes.substr(0, std::size_t(1) << hint);
}

Hash128 joined(const Hash128& a, const Hash128& b) {
  std::string both(bytes_of_hash(a));
  both += bytes_of_hash(b);
  return murmur_hash(both);
}

Hash128 hash_of(const std::vector<AlembicProperty>& properties) {
  Hash128 hash{0, 0};
  for (const AlembicProperty& property : properties) {
    hash = joined(hash, murmur_hash(property.name + property.metadata));
    hash = joined(hash, property.kind == AlembicKind::compound ? hash_of(property.properties) : property.hash);
  }
  return hash;
}

/// How often the samples of one time sampling come, and when.
void append_sampling(std::string& out, std::uint32_t num_samples, double cycle, const std::vector<double>& times) {
  append_bytes(out, num_samples);
  append_bytes(out, cycle);
  append_bytes(out, std::uint32_t(times.size()));
  for (const double time : times) append_bytes(out, time);
}

bool is_uniform(const std::vector<double>& times) {
  const double step = (times.back() - times.front()) / double(times.size() - 1);
  for (std::size_t i = 1; i < times.size(); ++i)
    if (std::abs(times[i] - times.front() - step * double(i)) > 1e-9 * step) return false;
  return true;
}

std::string samplings_of(const std::vector<double>& times, std::uint32_t num_samples) {
  std::string out;
  append_sampling(out, 1, 1, {0});
  if (times.size() < 2)
    append_sampling(out, num_samples, 1, times);
  else if (is_uniform(times))
    append_sampling(out, num_samples, (times.back() - times.front()) / double(times.size() - 1), {times.front()});
  else
    append_sampling(out, num_samples, acyclic, times);
  return out;
}

}  // namespace

void AlembicArchive::add_sample(AlembicProperty& property, std::string_view bytes) {
  assert(property.kind != AlembicKind::compound);
  const Hash128 key = murmur_hash(bytes);
  property.hash = joined(property.hash, key);
  property.largest_sample =
      std::max(property.largest_sample, bytes.size() / std::uint64_t(property.extent * size_of_number(property.pod)));
  property.samples.push_back(bytes.empty() ? empty_ogawa_data : file_.add_data({bytes_of_hash(key), bytes}));
  if (property.kind == AlembicKind::array) property.samples.push_back(empty_ogawa_data);  // of one dimension
}

unsigned AlembicArchive::metadata_index(const std::string& metadata) {
  if (metadata.empty()) return 0;
  const auto found = std::find(metadata_.begin(), metadata_.end(), metadata);
  const auto index = unsigned(found - metadata_.begin()) + 1;
  if (found == metadata_.end()) metadata_.push_back(metadata);
  assert(metadata.size() < 256 && index < 255);
  return index;
}

std::string AlembicArchive::property_header(const AlembicProperty& property) {
  const std::uint32_t num_samples = property.is_timed ? num_samples_ : 1;
  const std::size_t largest =
      std::max({property.name.size(), property.metadata.size(),
                property.kind == AlembicKind::compound ? std::size_t(0) : std::size_t(num_samples)});
  const int hint = largest < 256 ? 0 : largest < 65536 ? 1 : 2;
  std::uint32_t info = std::uint32_t(property.kind) | std::uint32_t(hint) << size_shift |
                       metadata_index(property.metadata) << metadata_shift;
  std::string out;
  if (property.kind != AlembicKind::compound) {
    info |= std::uint32_t(property.pod) << pod_shift | std::uint32_t(property.extent) << extent_shift;
    if (property.kind == AlembicKind::scalar || property.largest_sample == 1) info |= scalar_like_bit;
    if (property.kind == AlembicKind::scalar || property.extent == 1) info |= homogenous_bit;
    if (property.is_constant || num_samples == 1) info |= constant_bit;
    if (property.is_timed) info |= timed_bit;
    append_bytes(out, info);
    append_sized(out, num_samples, hint);
    if (property.is_timed) append_sized(out, 1, hint);  // the clip's sampling is the one behind the default
  } else {
    append_bytes(out, info);
  }
  append_sized(out, std::uint32_t(property.name.size()), hint);
  return out + property.name;
}

std::string AlembicArchive::object_header(const AlembicObject& object) {
  std::string out;
  append_bytes(out, std::uint32_t(object.name.size()));
  out += object.name;
  out += char(metadata_index(object.metadata));
  return out;
}

OgawaChild AlembicArchive::add_property(const AlembicProperty& property) {
  return property.kind == AlembicKind::compound ? add_compound(property.properties) : file_.add_group(property.samples);
}

OgawaChild AlembicArchive::add_compound(const std::vector<AlembicProperty>& properties) {
  std::vector<OgawaChild> children;
  std::string headers;
  for (const AlembicProperty& property : properties) {
    children.push_back(add_property(property));
    headers += property_header(property);
  }
  if (!properties.empty()) children.push_back(file_.add_data({headers}));
  return file_.add_group(children);
}

OgawaChild AlembicArchive::add_object(const std::vector<AlembicProperty>& properties,
                                      const std::vector<AlembicObject>& children, Hash128& hash) {
  std::vector<OgawaChild> parts{add_compound(properties)};
  std::string headers;
  Hash128 of_children{0, 0};
  for (const AlembicObject& child : children) {
    Hash128 of_child{0, 0};
    parts.push_back(add_object(child.properties, child.children, of_child));
    headers += object_header(child);
    of_children = joined(of_children, of_child);
  }
  const Hash128 of_properties = hash_of(properties);
  parts.push_back(file_.add_data({headers, bytes_of_hash(of_properties), bytes_of_hash(of_children)}));
  hash = joined(of_properties, of_children);
  return file_.add_group(parts);
}

void AlembicArchive::finish(const std::vector<AlembicObject>& objects, const AlembicTimes& times,
                            const std::string& description) {
  num_samples_ = std::uint32_t(times.times.size());
  std::string version, library, table;
  append_bytes(version, std::int32_t(0));
  append_bytes(library, library_version);
  std::vector<OgawaChild> archive{file_.add_data({version}), file_.add_data({library})};
  Hash128 hash{0, 0};
  archive.push_back(add_object({}, objects, hash));
  archive.push_back(
      file_.add_data({"_ai_AlembicVersion=Alembic 1.8.9;_ai_Application=umax;_ai_Description=", description}));
  archive.push_back(file_.add_data({samplings_of(times.times, num_samples_)}));
  for (const std::string& metadata : metadata_) {
    table += char(metadata.size());
    table += metadata;
  }
  archive.push_back(file_.add_data({table}));
  file_.finish(file_.add_group(archive));
}

}  // namespace umax
