// Reads and writes picture files: PNG (8 and 16 bit), OpenEXR with layers; JPEG and Radiance .hdr (reading only).
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "render/image/image.h"

namespace umax {

/// What the numbers of a PNG or JPEG become: scene-linear values, or the stored sRGB values in [0, 1] (masks, comparisons).
enum class PngValues { linear, as_stored };

/// Reads PNG, JPEG, EXR or .hdr, told apart by content. 1, 3 or 4 channels; of an EXR with layers, the colour (else the
/// first layer). Throws Error 66 (missing), 65 (not a picture, truncated, absurd size), 74.
Image read_image(const std::filesystem::path& path, PngValues png_values = PngValues::linear);

/// The same of a file's bytes; name: what messages call it.
Image decode_image(std::string_view bytes, const std::string& name, PngValues png_values = PngValues::linear);

/// All layers of an EXR file, the colour first, then by name.
std::vector<Layer> read_exr(const std::filesystem::path& path);

/// Reads a PNG as 8-bit codes; 16-bit files are rounded. Errors as read_image().
Image8 read_png8(const std::filesystem::path& path);

/// What a PNG's bytes are squeezed for: few of them, or little time.
enum class PngEffort { small_file, little_time };

/// Writes the codes as they are. The same picture gives the same bytes. Throws Error 73, 74; never leaves half a file.
void write_png(const std::filesystem::path& path, const Image8& image, PngEffort effort = PngEffort::small_file);

/// Writes a scene-linear picture with the plain sRGB curve, clipped to [0, 1]; for a filmic look use tone_map() first.
void write_png(const std::filesystem::path& path, const Image& linear);

/// Metadata of an EXR: (key, text), for example a cryptomatte manifest.
using ExrTexts = std::vector<std::pair<std::string, std::string>>;

/// What an EXR says beside its pixels.
struct ExrHeader {
  ExrTexts texts = {};
  bool is_rec709 = false;  // whether it says which primaries and white the colours have: those of Rec. 709
  // The standard's attributes of these names, for column vectors (p, 1): to the camera's right, up and forward [m]; to the
  // picture, (0, 0) its upper left and (1, 1) its lower right corner, after division by the fourth.
  std::optional<Eigen::Matrix4f> world_to_camera = {}, world_to_ndc = {};
};

/// Writes all layers, of one size, into one file: ZIP compression, 32-bit float. Channel names: colour "R", "G", "B";
/// three-channel layers "Albedo.R" (but "N.X", "P.X" for layers N, P), four-channel layers "A.R" (but "Vector.X" and,
/// in layers that begin with "Crypto", "CryptoObject00.r"), single-channel layers their own name ("Z", "Object.X").
void write_exr(const std::filesystem::path& path, const std::vector<Layer>& layers, const ExrHeader& header = {});

/// By extension: .png (plain sRGB), .exr. Throws Error 2 for others.
void write_image(const std::filesystem::path& path, const Image& linear);

/// The PNG file's bytes, for pages that carry their pictures in themselves.
std::string encode_png(const Image8& image, PngEffort effort = PngEffort::small_file);

}  // namespace umax
