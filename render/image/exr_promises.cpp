#include "render/image/exr_promises.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <map>

#include "render/image/image_codecs.h"

namespace umax::codec {
namespace {

constexpr std::uint32_t multipart_flag = 0x1000;
constexpr std::size_t most_per_byte = 8192;  // of any compression, in pictures of one colour

/// Thrown where the file is not as it says.
struct Broken {
  const char* what;
};

/// What decides how much memory a picture takes.
struct Picture {
  long long width = 0, height = 0;            // [px]
  long long tile_width = 0, tile_height = 0;  // [px] 0: rows, not tiles
  long long lines = 1;                        // that are compressed together
  long long chunks = 0;                       // 0: the file does not say
  std::size_t num_channels = 0;
};

class Walk {
 public:
  explicit Walk(std::string_view bytes) : rest_(bytes), file_bytes_(bytes.size()) {}

  void files_headers() {
    take(4);  // magic
    const bool has_parts = number<std::uint32_t>() & multipart_flag;
    header();
    while (has_parts && !rest_.starts_with('\0')) header();
  }

 private:
  std::string_view take(std::size_t count) {
    if (count > rest_.size()) throw Broken{"it ends within its header"};
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }
  template <class T>
  T number() {
    T value;
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  std::string_view word() {
    const std::string_view text = take(std::min(rest_.find('\0'), rest_.size()));
    take(1);
    return text;
  }

  void header() {
    Picture picture;
    while (true) {
      const std::string_view name = word();
      if (name.empty()) break;
      const std::string_view type = word();
      const auto size = number<std::int32_t>();
      if (size < 0 || std::size_t(size) > rest_.size()) throw Broken{"an attribute is longer than the file"};
      const std::size_t left = rest_.size();
      attribute(name, type, std::size_t(size), picture);
      if (left - rest_.size() != std::size_t(size)) throw Broken{"an attribute is not as long as its kind is"};
    }
    check(picture);
  }

  void attribute(std::string_view name, std::string_view type, std::size_t size, Picture& picture) {
    if (type == "chlist") return channels(picture);
    if (type == "preview") return preview();
    if (type == "stringvector") return texts(size);
    if (type == "idmanifest") return manifest(size);
    const std::string_view value = take(fixed_size(type, size));
    if (name == "dataWindow" && type == "box2i") window(value, picture);
    if (name == "tiles" && type == "tiledesc") tiles(value, picture);
    if (name == "compression" && type == "compression") picture.lines = lines_of(value[0]);
    if (name == "chunkCount" && type == "int") picture.chunks = at<std::int32_t>(value, 0);
  }

  /// Of types that are always as long; of others as the attribute says.
  static std::size_t fixed_size(std::string_view type, std::size_t size) {
    static const std::map<std::string_view, std::size_t> sizes{
        {"box2i", 16},      {"box2f", 16},    {"chromaticities", 32},
        {"compression", 1}, {"double", 8},    {"float", 4},
        {"int", 4},         {"lineOrder", 1}, {"m33f", 36},
        {"m33d", 72},       {"m44f", 64},     {"m44d", 128},
        {"v2i", 8},         {"v2f", 8},       {"v2d", 16},
        {"v3i", 12},        {"v3f", 12},      {"v3d", 24},
        {"envmap", 1},      {"keycode", 28},  {"deepImageState", 1},
        {"timecode", 8},    {"tiledesc", 9},  {"rational", 8}};
    const auto found = sizes.find(type);
    return found == sizes.end() ? size : found->second;
  }

  template <class T>
  static T at(std::string_view value, std::size_t place) {
    T number;
    std::memcpy(&number, value.data() + place, sizeof number);
    return number;
  }

  void channels(Picture& picture) {
    constexpr std::size_t channel_size = 16;
    for (; !word().empty(); ++picture.num_channels) take(channel_size);
  }

  void preview() {
    const std::uint64_t width = number<std::uint32_t>(), height = number<std::uint32_t>();
    if (width * height > rest_.size() / 4) throw Broken{"its preview is larger than the file"};
    take(4 * width * height);
  }

  void texts(std::size_t size) {
    for (const std::size_t end = rest_.size() - size; rest_.size() > end;) {
      const auto length = number<std::int32_t>();
      take(length < 0 ? rest_.size() + 1 : std::size_t(length));
    }
  }

  /// Compressed; what it says of its length behind that is its reader's to check.
  void manifest(std::size_t size) {
    constexpr std::size_t most_deflated = 1032;
    if (size < 4) throw Broken{"its manifest is too short"};
    const auto length = number<std::int32_t>();
    if (length < 0 || !can_hold(size, std::size_t(length), most_deflated)) throw Broken{"its manifest is too long"};
    take(size - 4);
  }

  static void window(std::string_view box, Picture& picture) {
    picture.width = 1LL + at<std::int32_t>(box, 8) - at<std::int32_t>(box, 0);
    picture.height = 1LL + at<std::int32_t>(box, 12) - at<std::int32_t>(box, 4);
  }

  static void tiles(std::string_view value, Picture& picture) {
    picture.tile_width = at<std::uint32_t>(value, 0);
    picture.tile_height = at<std::uint32_t>(value, 4);
    if (picture.tile_width < 1 || picture.tile_height < 1) throw Broken{"its tiles have no size"};
  }

  static long long lines_of(char compression) {
    static constexpr int lines[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};  // none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, …
    return compression >= 0 && compression < 10 ? lines[int(compression)] : 1;
  }

  void check(const Picture& picture) const {
    const auto [width, height, tile_width, tile_height, lines, said_chunks, num_channels] = picture;
    if (width < 1 || height < 1 || width > max_extent || height > max_extent ||
        width * height > (long long)(max_pixels))
      throw Broken{"absurd size"};
    if (tile_width > max_extent || tile_height > max_extent) throw Broken{"absurd size of its tiles"};
    const bool tiled = tile_width > 0;
    const long long across = tiled ? (width + tile_width - 1) / tile_width : 1, high = tiled ? tile_height : lines,
                    down = (height + high - 1) / high, chunks = std::max(said_chunks, across * down);
    if (said_chunks < 0 || chunks > (long long)(file_bytes_ / sizeof(std::uint64_t)))
      throw Broken{"it promises more parts than it can hold"};
    const auto taken = std::size_t(std::max(width, tile_width) * std::max(height, high));  // a part is taken as a whole
    if (!can_hold(file_bytes_, taken * num_channels * sizeof(float), most_per_byte))
      throw Broken{"it promises more pixels than it can hold"};
  }

  std::string_view rest_;
  std::size_t file_bytes_;
};

}  // namespace

std::string broken_exr_promise(std::string_view bytes) {
  try {
    Walk(bytes).files_headers();
    return {};
  } catch (const Broken& broken) {
    return broken.what;
  }
}

}  // namespace umax::codec
