// What tests of files of hexes share: a plain file that is easy to spoil, and what is said of spoilt ones.
#pragma once

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>

#include "core/base/error.h"
#include "embedding/hex_files/hex_mesh_io.h"
#include "tests/embedding/hex_files.h"
#include "tests/embedding/meshes.h"
#include "tests/support/catch.h"
#include "tests/support/replaced.h"
#include "tools/system/exit_code.h"

namespace umax::testing {

/// The file is refused with exit code 65, its name and this text.
inline void refuses(const std::string& name, const std::string& content, const std::string& text) {
  CAPTURE(name, text);
  try {
    load_hex_mesh(write_file(name, content));
  } catch (const Error& error) {
    CAPTURE(std::string(error.what()));
    CHECK(exit_code_of(error.fault()) == 65);
    CHECK(std::string(error.what()).find(name) != std::string::npos);
    CHECK(std::string(error.what()).find(text) != std::string::npos);
    CHECK(std::string(error.what()).size() < 700);
    return;
  }
  FAIL_CHECK("was accepted");
}

/// Hexes without the vertex, the factors and the rest.
inline std::string plain_vtk(const HexDocument& mesh) {
  std::string text = fmt::format("# vtk DataFile Version 2.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {} double\n",
                                 mesh.nodes.rows());
  for (const auto& x : mesh.nodes.rowwise()) text += fmt::format("{:.17g} {:.17g} {:.17g}\n", x[0], x[1], x[2]);
  text += fmt::format("CELLS {} {}\n", mesh.hexes.size(), 9 * mesh.hexes.size());
  for (const auto& hex : mesh.hexes) text += fmt::format("8 {}\n", fmt::join(hex, " "));
  text += fmt::format("CELL_TYPES {}\n", mesh.hexes.size());
  for (std::size_t e = 0; e < mesh.hexes.size(); ++e) text += "12\n";
  return text;
}

}  // namespace umax::testing
