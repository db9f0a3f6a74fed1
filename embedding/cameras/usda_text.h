// USD as text: the tree of prims with their attributes, as far as cameras need them.
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace umax::cameras {

/// Numbers (of a list or tuple all, in their order), or words.
struct UsdValue {
  std::vector<double> numbers;
  std::vector<std::string> words;
};

struct UsdAttribute {
  std::string type;  // "double3"
  UsdValue value;    // what stands where there are no samples
  std::map<double, UsdValue> samples;
};

struct UsdPrim {
  std::string type, name;  // "Camera", "shot"; the file itself has neither
  std::map<std::string, UsdAttribute> attributes;
  std::map<std::string, UsdValue> metadata;  // read of the file itself
  std::vector<UsdPrim> children;
};

/// Throws Error (bad_data) with the line.
UsdPrim parse_usda(const std::filesystem::path& path, std::string_view text);

}  // namespace umax::cameras
