#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>

#include "core/base/error.h"
#include "core/base/srgb.h"
#include "core/files/read_file.h"
#include "core/files/write_file.h"
#include "render/image/image_io.h"
#include "tests/support/catch.h"
#include "tests/support/jpeg_file.h"
#include "tests/support/temporary_folder.h"

using namespace umax;
namespace fs = std::filesystem;

namespace {

Image8 noise_codes(int width, int height, int channels) {
  Image8 image(width, height, channels);
  std::uint32_t state = 1;
  for (auto& value : image.values) value = std::uint8_t((state = state * 1664525u + 1013904223u) >> 24);
  return image;
}

Image wide_range(int width, int height, int channels) {
  Image image(width, height, channels);
  for (std::size_t i = 0; i < image.values.size(); ++i)
    image.values[i] = std::ldexp(1.0f + float(i) / 97.0f, int(i % 41) - 20);
  return image;
}

std::optional<Fault> fault_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.fault();
  }
  return std::nullopt;
}

void write_bytes(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

std::size_t num_files(const fs::path& folder) {
  return std::size_t(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

}  // namespace

TEST_CASE("8-bit codes survive a PNG unchanged") {
  const int channels = GENERATE(1, 3, 4);
  const auto path = output_folder() / "codes.png";
  const Image8 image = noise_codes(37, 21, channels);
  write_png(path, image);
  const Image8 back = read_png8(path);
  CHECK(back.width == 37);
  CHECK(back.height == 21);
  CHECK(back.channels == channels);
  CHECK(back.values == image.values);
}

TEST_CASE("PNG values are read as scene-linear, or as stored when asked") {
  const auto path = output_folder() / "grey.png";
  Image8 image(1, 1, 4);
  image.values = {188, 0, 255, 128};
  write_png(path, image);
  const Image linear = read_image(path), stored = read_image(path, PngValues::as_stored);
  CHECK(linear.values[0] == Approx(0.5029f).epsilon(1e-3));
  CHECK(linear.values[1] == 0.0f);
  CHECK(linear.values[2] == 1.0f);
  CHECK(linear.values[3] == Approx(128.0 / 255));  // alpha is never encoded
  CHECK(stored.values[0] == Approx(188.0 / 255));
}

TEST_CASE("a linear picture written as PNG comes back within half a code") {
  const auto path = output_folder() / "ramp.png";
  Image ramp(256, 1, 3);
  for (std::size_t i = 0; i < ramp.values.size(); ++i) ramp.values[i] = float(i) / float(ramp.values.size() - 1);
  write_png(path, ramp);
  const Image back = read_image(path);
  float worst = 0;
  for (std::size_t i = 0; i < ramp.values.size(); ++i)
    worst = std::max(worst, std::abs(srgb_from_linear(ramp.values[i]) - srgb_from_linear(back.values[i])));
  CHECK(worst <= 0.501f / 255);
}

TEST_CASE("JPEG, baseline and progressive, in colour, grey and four inks, is read as the colours that it shows") {
  const bool progressive = GENERATE(false, true);
  const auto check = [&](test::JpegSample sample, const std::vector<unsigned char>& left,
                         const std::vector<unsigned char>& right) {
    sample.progressive = progressive;
    const Image image = decode_image(test::jpeg_bytes(sample), "picture", PngValues::as_stored);
    REQUIRE(image.width == 37);
    REQUIRE(image.height == 20);
    REQUIRE(image.channels == int(left.size()));
    for (int c = 0; c < image.channels; ++c) {
      CHECK(image.pixel(4, 9)[c] * 255 == Approx(left[std::size_t(c)]).margin(3));
      CHECK(image.pixel(33, 9)[c] * 255 == Approx(right[std::size_t(c)]).margin(3));
    }
  };
  const std::vector<unsigned char> red{230, 20, 10}, blue{10, 30, 200};
  check(test::two_colors(37, 20, red, blue), red, blue);
  check(test::two_colors(37, 20, {200}, {17}), {200}, {17});
  // inks are stored inverted: cyan, magenta, yellow and black of none is 255
  check(test::two_colors(37, 20, {255, 128, 255, 255}, {128, 128, 128, 128}), {255, 128, 255}, {64, 64, 64});
  // linear, as a texture is read
  write_bytes(output_folder() / "grey.jpg", test::jpeg_bytes(test::two_colors(16, 16, {188}, {188})));
  CHECK(read_image(output_folder() / "grey.jpg").pixel(8, 8)[0] == Approx(0.503).margin(0.01));
}

TEST_CASE("JPEG files that are cut or damaged are refused by name") {
  const std::string whole = test::jpeg_bytes(test::two_colors(64, 64, {230, 20, 10}, {10, 30, 200}));
  CHECK(decode_image(whole, "x").width == 64);
  for (std::size_t size = 3; size + 2 < whole.size(); size += 7)
    CHECK(fault_of([&] { decode_image(whole.substr(0, size), "x"); }) == Fault::bad_data);
  std::string huge = whole;
  const std::size_t frame = huge.find("\xff\xc0");
  REQUIRE(frame != huge.npos);
  for (const std::size_t at : {5, 6, 7, 8}) huge[frame + at] = '\xff';
  CHECK(fault_of([&] { decode_image(huge, "x"); }) == Fault::bad_data);
  for (std::size_t at = 2; at < whole.size(); at += 3) {
    std::string spoilt = whole;
    spoilt[at] = char(spoilt[at] ^ 0x55);
    const auto fault = fault_of([&] { decode_image(spoilt, "x"); });
    CHECK((!fault || fault == Fault::bad_data));
  }
}

TEST_CASE("EXR layers come back bit for bit under their names") {
  const auto path = output_folder() / "layers.exr";
  const std::vector<Layer> layers = {{"", wide_range(19, 7, 3)},
                                     {"Albedo", wide_range(19, 7, 3)},
                                     {"N", wide_range(19, 7, 3)},
                                     {"Z", wide_range(19, 7, 1)},
                                     {"variance", wide_range(19, 7, 1)}};
  write_exr(path, layers, {.texts = {{"umax/note", "text"}}});
  const auto back = read_exr(path);
  REQUIRE(back.size() == layers.size());
  for (const Layer& layer : layers) {
    const auto found =
        std::find_if(back.begin(), back.end(), [&](const Layer& other) { return other.name == layer.name; });
    REQUIRE(found != back.end());
    CHECK(found->image.channels == layer.image.channels);
    CHECK(found->image.values == layer.image.values);
  }
  CHECK(read_image(path).values == layers[0].image.values);
  const std::string bytes = read_file(path);
  for (const std::string name : {"Albedo.G", "N.Z", "umax/note"}) CHECK(bytes.find(name) != std::string::npos);
}

TEST_CASE("the same picture gives the same bytes") {
  const auto folder = output_folder();
  const Image image = wide_range(33, 9, 3);
  write_exr(folder / "first.exr", {{"", image}});
  write_exr(folder / "second.exr", {{"", image}});
  CHECK(read_file(folder / "first.exr") == read_file(folder / "second.exr"));
  CHECK(encode_png(noise_codes(40, 40, 3)) == encode_png(noise_codes(40, 40, 3)));
}

TEST_CASE("a PNG that is written in little time holds the same codes") {
  const auto path = output_folder() / "quick.png";
  for (const int channels : {1, 3, 4}) {
    const Image8 codes = noise_codes(37, 21, channels);
    write_png(path, codes, PngEffort::little_time);
    CHECK(read_png8(path).values == codes.values);
  }
  Image8 even(64, 64, 3);
  std::fill(even.values.begin(), even.values.end(), std::uint8_t(7));
  CHECK(encode_png(even, PngEffort::little_time).size() < even.values.size() / 10);
}

TEST_CASE("a run-length coded HDR picture is decoded") {
  const auto path = output_folder() / "sky.hdr";
  std::string bytes = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 8\n";
  bytes += std::string("\x02\x02\x00\x08", 4);
  bytes += std::string("\x88\x80", 2);                              // red: 8 times 128
  bytes += std::string("\x08\x00\x01\x02\x03\x04\x05\x06\x07", 9);  // green: literal 0…7
  bytes += std::string("\x84\x40\x84\x00", 4);                      // blue: 4 times 64, 4 times 0
  bytes += std::string("\x88\x81", 2);                              // exponent 129: scale 1/128
  write_file(path, bytes);
  const Image image = read_image(path);
  REQUIRE(image.width == 8);
  CHECK(image.pixel(0, 0)[0] == Approx(128.5 / 128));
  CHECK(image.pixel(7, 0)[1] == Approx(7.5 / 128));
  CHECK(image.pixel(3, 0)[2] == Approx(64.5 / 128));
  CHECK(image.pixel(4, 0)[2] == Approx(0.5 / 128));
}

TEST_CASE("damaged, missing and unknown pictures are told apart") {
  const auto folder = output_folder();
  CHECK(fault_of([&] { read_image(folder / "absent.png"); }) == Fault::not_found);
  write_file(folder / "empty.png", "");
  CHECK(fault_of([&] { read_image(folder / "empty.png"); }) == Fault::bad_data);
  write_file(folder / "text.png", "not a picture");
  CHECK(fault_of([&] { read_image(folder / "text.png"); }) == Fault::bad_data);

  write_png(folder / "whole.png", noise_codes(64, 64, 3));
  write_exr(folder / "whole.exr", {{"", wide_range(64, 64, 3)}});
  for (const std::string name : {"whole.png", "whole.exr"}) {
    const std::string bytes = read_file(folder / name);
    for (const std::size_t kept : {std::size_t(20), bytes.size() / 2, bytes.size() - 40}) {
      write_file(folder / "cut", std::string_view(bytes).substr(0, kept));
      INFO(name << " cut to " << kept);
      CHECK(fault_of([&] { read_image(folder / "cut"); }) == Fault::bad_data);
    }
  }
}

TEST_CASE("a folder that cannot be written to is error 73") {
  CHECK(fault_of([&] { write_png(output_folder() / "no/such/folder.png", noise_codes(4, 4, 3)); }) ==
        Fault::cannot_create);
  CHECK(fault_of([&] { write_png("/proc/self/picture.png", noise_codes(4, 4, 3)); }) == Fault::cannot_create);
  const auto locked = output_folder() / "locked";
  fs::create_directories(locked);
  fs::permissions(locked, fs::perms::owner_read | fs::perms::owner_exec);
  if (::geteuid() != 0)  // root may write anywhere
    CHECK(fault_of([&] { write_png(locked / "picture.png", noise_codes(4, 4, 3)); }) == Fault::cannot_create);
  fs::permissions(locked, fs::perms::owner_all);
}

TEST_CASE("a full disk keeps the old file whole and leaves no other") {
  const auto folder = output_folder() / "full";
  fs::remove_all(folder);
  fs::create_directories(folder);
  write_file(folder / "frame.png", "the old one");

  // a limit on file sizes stands in for the full disk: the write stops in the middle
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit limit = before;
  limit.rlim_cur = 5000;
  ::setrlimit(RLIMIT_FSIZE, &limit);
  const auto fault = fault_of([&] { write_png(folder / "frame.png", noise_codes(100, 100, 3)); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);

  CHECK(fault == Fault::cannot_create);
  CHECK(read_file(folder / "frame.png") == "the old one");
  CHECK(num_files(folder) == 1);
}
