// The lines of an SVG file that Cairo wrote.
#pragma once

#include <boost/property_tree/ptree.hpp>
#include <boost/property_tree/xml_parser.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace umax {

struct SvgPath {
  std::string style;  // all attributes
  std::vector<double> x, y;
};

inline void collect_svg_paths(const boost::property_tree::ptree& element, std::vector<SvgPath>& paths) {
  for (const auto& [name, child] : element) {
    if (name != "path") {
      collect_svg_paths(child, paths);
      continue;
    }
    SvgPath path;
    for (const auto& [attribute, value] : child.get_child("<xmlattr>"))
      if (attribute != "d") path.style += attribute + ":" + value.data() + ";";
    std::istringstream words(child.get<std::string>("<xmlattr>.d"));
    double x = 0, y = 0;
    for (std::string command; words >> command && (command == "M" || command == "L") && words >> x >> y;) {
      path.x.push_back(x);
      path.y.push_back(y);
    }
    paths.push_back(path);
  }
}

/// All paths but letters, as far as they are straight. Throws when the text is no XML.
inline std::vector<SvgPath> svg_paths(const std::string& svg) {
  std::istringstream text(svg);
  boost::property_tree::ptree tree;
  boost::property_tree::read_xml(text, tree);
  std::vector<SvgPath> paths;
  collect_svg_paths(tree.get_child("svg"), paths);
  std::erase_if(paths, [](const SvgPath& path) { return path.style.find("stroke-width") == std::string::npos; });
  return paths;
}

/// Those of them that are `width` pixels wide.
inline std::vector<SvgPath> svg_paths(const std::string& svg, const std::string& width) {
  std::vector<SvgPath> paths = svg_paths(svg);
  std::erase_if(
      paths, [&](const SvgPath& path) { return path.style.find("stroke-width:" + width + ";") == std::string::npos; });
  return paths;
}

}  // namespace umax
