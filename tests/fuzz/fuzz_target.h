// What hostile bytes are given to: a reader of the program, with what must hold whatever it is given.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>

namespace umax::fuzz {

/// Reads the bytes as the program would. Ends the process where what is promised does not hold.
using Target = void (*)(std::string_view bytes);

void read_scene(std::string_view bytes);         // TOML to a scene, written out and read again
void read_quantity(std::string_view bytes);      // "500 kPa"
void read_presets(std::string_view bytes);       // a file of the user's materials
void read_state(std::string_view bytes);         // behind their checksum: states, and pulls
void read_measurements(std::string_view bytes);  // CSV for umax fit
void read_hexes(std::string_view bytes);         // .msh, .vtk, .vtu
void read_mesh(std::string_view bytes);          // .obj, .ply, .off, .stl
void read_cache(std::string_view bytes);         // .pc2, .mdd
void read_picture(std::string_view bytes);       // PNG, EXR, HDR, JPEG
void read_camera(std::string_view bytes);        // .usda, .gltf, .glb
void read_messages(std::string_view bytes);      // what a browser tells a live session, a message a line

/// Says what does not hold, and ends the process.
[[noreturn]] void break_off(const std::string& what);
inline void require(bool holds, const char* what) {
  if (!holds) break_off(what);
}

/// Calls read(); it may refuse by an Error of bad data that says where, what and the remedy, or of a file that is not
/// there. False: it did. All else that it throws ends the process.
bool accepts(const std::function<void()>& read);

/// Puts the bytes into a file of this process's own, always the same by that name; gone when the process ends.
std::filesystem::path as_file(std::string_view bytes, const std::string& name);

}  // namespace umax::fuzz
