#include "tools/run/clip.h"

#include <fmt/format.h>

#include <cstdlib>
#include <string>
#include <string_view>

#include "core/base/error.h"
#include "core/files/file_writer.h"
#include "core/files/read_file.h"
#include "embedding/scanning/compression.h"
#include "tools/system/subprocess.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

constexpr const char* install_remedy =
    "install it (apt-get install ffmpeg), or use umax simulate and umax render elsewhere";

std::uint32_t big_endian(std::string_view bytes) {
  std::uint32_t value = 0;
  for (int i = 0; i < 4; ++i) value = value << 8 | static_cast<unsigned char>(bytes[std::size_t(i)]);
  return value;
}

[[noreturn]] void fail_png(const fs::path& path, const std::string& what) {
  throw Error(Fault::bad_data, {path.string(), what, "", "render it again (delete it and use umax render --resume)"});
}

/// Walks the chunks of a PNG: signature, lengths, checksums, end.
void check_png_bytes(const fs::path& path, std::string_view bytes, int width, int height) {
  constexpr std::string_view signature("\x89PNG\r\n\x1a\n", 8);
  if (bytes.substr(0, 8) != signature || bytes.size() < 33) fail_png(path, "is not a PNG file");
  const std::uint32_t found_width = big_endian(bytes.substr(16)), found_height = big_endian(bytes.substr(20));
  if (int(found_width) != width || int(found_height) != height)
    fail_png(path, fmt::format("is {}x{}, the clip {}x{}", found_width, found_height, width, height));

  bytes.remove_prefix(signature.size());
  while (bytes.size() >= 12) {
    const std::size_t length = big_endian(bytes);
    if (length > bytes.size() - 12) break;
    const std::string_view type = bytes.substr(4, 4), checked = bytes.substr(4, length + 4);
    if (crc32_of(checked) != big_endian(bytes.substr(length + 8)))
      fail_png(path, "is damaged: a checksum does not fit");
    if (type == "IEND") return;
    bytes.remove_prefix(length + 12);
  }
  fail_png(path, "is damaged: it ends too early");
}

constexpr const char* no_space = "the disk may have no space left: free some, then go on with --resume";

[[noreturn]] void fail_encoding(const fs::path& clip, const ProcessResult& result) {
  const std::string messages = result.messages.substr(0, result.messages.find('\n'));
  throw Error(Fault::io_error,
              {clip.string(), fmt::format("ffmpeg failed with exit code {}", result.exit_code), messages, no_space});
}

std::vector<std::string> encode_command(const fs::path& target, const ClipOptions& options) {
  std::vector<std::string> command{"ffmpeg", "-nostdin", "-loglevel", "error", "-y"};
  const auto add = [&](std::initializer_list<const char*> words) {
    command.insert(command.end(), words.begin(), words.end());
  };
  add({"-f", "image2pipe", "-c:v", "png", "-framerate"});
  command.push_back(fmt::format("{}", options.fps));
  add({"-i", "pipe:0", "-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact"});
  const std::string over_black = options.transparent ? "format=gbrap,premultiply=inplace=1,format=gbrp," : "";
  command.emplace_back("-vf");
  command.push_back(
      over_black +
      "scale=in_range=full:out_range=tv:out_color_matrix=bt709:flags=accurate_rnd+full_chroma_int,format=yuv420p");
  add({"-c:v", "libx264", "-preset", "medium", "-threads", "2", "-crf"});
  command.push_back(std::to_string(options.constant_rate_factor));
  add({"-color_primaries", "bt709", "-color_trc", "bt709", "-colorspace", "bt709", "-color_range", "tv"});
  add({"-fps_mode", "passthrough", "-movflags", "+faststart"});
  command.push_back(target.string());
  return command;
}

long long count_frames(const fs::path& clip) {
  const ProcessResult result = run_process({"ffprobe", "-v", "error", "-count_frames", "-select_streams", "v:0",
                                            "-show_entries", "stream=nb_read_frames", "-of", "csv=p=0", clip.string()});
  return result.exit_code == 0 ? std::strtoll(result.output.c_str(), nullptr, 10) : -1;
}

}  // namespace

void require_clip_encoder() {
  for (const char* program : {"ffmpeg", "ffprobe"})
    if (!find_program(program))
      throw Error(Fault::unavailable,
                  {program, "is needed to encode the clip and is not installed", "", install_remedy});
  const ProcessResult encoders = run_process({"ffmpeg", "-hide_banner", "-loglevel", "error", "-encoders"});
  if (encoders.output.find("libx264") == std::string::npos)
    throw Error(Fault::unavailable, {"ffmpeg", "has no H.264 encoder (libx264)", "", install_remedy});
}

void require_even_size(int width, int height) {
  if (width % 2 == 0 && height % 2 == 0) return;
  throw Error(Fault::usage, {"--size", "a clip needs an even width and height", fmt::format("{}x{}", width, height),
                             fmt::format("use {}x{}", width + width % 2, height + height % 2)});
}

void check_png(const fs::path& path, int width, int height) {
  check_png_bytes(path, read_file(path), width, height);
}

void encode_clip(const fs::path& clip, std::size_t num_pictures, const PictureSource& picture,
                 const ClipOptions& options) {
  // ffmpeg tells the format by the ending
  const fs::path temporary = temporary_beside(clip, ".mp4");
  const auto next_picture = [&, index = std::size_t(0)]() mutable {
    return index == num_pictures ? std::string() : picture(index++);
  };

  std::error_code error;
  try {
    const ProcessResult result = run_process(encode_command(temporary, options), next_picture);
    if (result.exit_code != 0) fail_encoding(clip, result);
    const long long count = count_frames(temporary);
    if (count != static_cast<long long>(num_pictures))
      throw Error(Fault::io_error, {clip.string(),
                                    count < 0 ? "ffmpeg wrote what cannot be read"
                                              : fmt::format("ffmpeg wrote {} frames of {}", count, num_pictures),
                                    "", no_space});
    put_in_place(temporary, clip);
  } catch (...) {
    fs::remove(temporary, error);
    throw;
  }
}

void encode_clip(const fs::path& clip, const std::vector<fs::path>& pictures, const ClipOptions& options) {
  encode_clip(
      clip, pictures.size(),
      [&](std::size_t index) {
        std::string bytes = read_file(pictures[index]);
        check_png_bytes(pictures[index], bytes, options.width, options.height);
        return bytes;
      },
      options);
}

void decode_clip(const fs::path& clip, const fs::path& folder) {
  if (!find_program("ffmpeg"))
    throw Error(Fault::unavailable, {"ffmpeg", "is needed to read the frames of a clip and is not installed", "",
                                     "install it (apt-get install ffmpeg), or compare the folders of pictures"});
  const ProcessResult result = run_process({"ffmpeg", "-nostdin", "-loglevel", "error", "-i", "file:" + clip.string(),
                                            "-fps_mode", "passthrough", (folder / "%04d.png").string()});
  if (result.exit_code != 0)
    throw Error(Fault::bad_data, {clip.string(), "is no clip that ffmpeg reads",
                                  result.messages.substr(0, result.messages.find('\n')), "give another file"});
}

}  // namespace umax
