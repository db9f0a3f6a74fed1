// Alembic's tree of objects and properties in an Ogawa file: samples are written as they come, the tree at the end.
//
// archive    group: version 0, library version, top object, its metadata, time samplings, table of metadata
// object     group: its properties, its children, and their headers with 32 bytes of hashes
// compound   group: its properties, and their headers
// array      group: for each sample its data (16 bytes of its key before them) and its dimensions (empty: one)
// scalar     group: for each sample its data, likewise
// A header says type, numbers and name of a property: the bits are in alembic_archive.cpp.
#pragma once

#include <deque>

#include "embedding/caches/murmur_hash.h"
#include "embedding/caches/ogawa_file.h"

namespace umax {

/// Types of numbers, as Alembic counts them.
enum class AlembicPod : std::uint8_t { boolean = 0, uint8 = 1, uint32 = 5, int32 = 6, float32 = 10, float64 = 11 };

enum class AlembicKind : std::uint8_t { compound = 0, scalar = 1, array = 2 };

struct AlembicProperty {
  std::string name;
  AlembicKind kind = AlembicKind::compound;
  std::string metadata = {};  // "interpretation=point"
  AlembicPod pod = AlembicPod::float32;
  int extent = 1;                                // numbers of one value
  bool is_timed = false;                         // its samples are the clip's; else it has one
  bool is_constant = true;                       // all samples are the first one
  std::vector<AlembicProperty> properties = {};  // of a compound

  std::vector<OgawaChild> samples = {};
  std::uint64_t largest_sample = 0;  // [values]
  Hash128 hash{0, 0};                // of all samples' keys
};

struct AlembicObject {
  std::string name;
  std::string metadata;  // "schema=…"
  std::vector<AlembicProperty> properties = {};
  std::vector<AlembicObject> children = {};
};

/// When the clip's samples are.
struct AlembicTimes {
  std::vector<double> times;  // [s]
};

class AlembicArchive {
 public:
  explicit AlembicArchive(const std::filesystem::path& path) : file_(path) {}

  /// Adds a sample to a property that is no compound.
  void add_sample(AlembicProperty& property, std::string_view bytes);

  /// Writes the tree; objects are those at the top.
  void finish(const std::vector<AlembicObject>& objects, const AlembicTimes& times, const std::string& description);

 private:
  unsigned metadata_index(const std::string& metadata);
  OgawaChild add_property(const AlembicProperty& property);
  OgawaChild add_compound(const std::vector<AlembicProperty>& properties);
  OgawaChild add_object(const std::vector<AlembicProperty>& properties, const std::vector<AlembicObject>& children,
                        Hash128& hash);
  std::string property_header(const AlembicProperty& property);
  std::string object_header(const AlembicObject& object);

  OgawaFile file_;
  std::vector<std::string> metadata_;  // by its index - 1
  std::uint32_t num_samples_ = 1;      // of the clip
};

}  // namespace umax
