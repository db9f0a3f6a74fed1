#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

#include <cassert>
#include <cstring>
#include <map>

#include "render/image/exr_promises.h"
#include "render/image/image_codecs.h"

namespace umax::codec {
namespace {

class MemoryReader : public Imf::IStream {
 public:
  explicit MemoryReader(std::string_view bytes, const std::string& name) : Imf::IStream(name.c_str()), bytes_(bytes) {}
  bool read(char out[], int count) override {
    if (count < 0 || position_ > bytes_.size() || std::size_t(count) > bytes_.size() - position_)
      throw std::runtime_error("the file ends early");
    std::memcpy(out, bytes_.data() + position_, std::size_t(count));
    position_ += std::size_t(count);
    return position_ < bytes_.size();
  }
  uint64_t tellg() override { return position_; }
  void seekg(uint64_t position) override { position_ = std::size_t(position); }

 private:
  std::string_view bytes_;
  std::size_t position_ = 0;
};

class MemoryWriter : public Imf::OStream {
 public:
  explicit MemoryWriter(const std::string& name) : Imf::OStream(name.c_str()) {}
  void write(const char data[], int count) override {
    if (position_ + std::size_t(count) > bytes.size()) bytes.resize(position_ + std::size_t(count));
    std::memcpy(bytes.data() + position_, data, std::size_t(count));
    position_ += std::size_t(count);
  }
  uint64_t tellp() override { return position_; }
  void seekp(uint64_t position) override { position_ = std::size_t(position); }

  std::string bytes;

 private:
  std::size_t position_ = 0;
};

/// "Albedo", 3 channels -> Albedo.R, Albedo.G, Albedo.B; "Z", 1 channel -> Z; "", 1 channel -> Y.
std::vector<std::string> channel_names(const Layer& layer) {
  const int count = layer.image.channels;
  if (count == 1) return {layer.name.empty() ? "Y" : layer.name};
  const bool vector = (count <= 3 && (count == 2 || layer.name == "N" || layer.name == "P")) || layer.name == "Vector";
  const bool cryptomatte = layer.name.rfind("Crypto", 0) == 0;
  const std::string letters = vector ? "XYZW" : cryptomatte ? "rgba" : "RGBA";
  std::vector<std::string> names;
  for (int c = 0; c < count; ++c) {
    assert(c < int(letters.size()));
    names.push_back((layer.name.empty() ? "" : layer.name + ".") + letters[std::size_t(c)]);
  }
  return names;
}

/// Where a channel belongs: layer name and its rank inside the layer.
struct Place {
  std::string layer;
  int rank = 0;
};
Place place_of(const std::string& channel) {
  const auto dot = channel.rfind('.');
  const std::string last = dot == std::string::npos ? channel : channel.substr(dot + 1);
  const std::string prefix = dot == std::string::npos ? "" : channel.substr(0, dot);
  const auto rank = std::string_view("RGBA").find(last), vector_rank = std::string_view("XYZW").find(last);
  const auto crypto_rank = std::string_view("rgba").find(last);
  const bool single = last.size() == 1;
  if (single && rank != std::string_view::npos) return {prefix, int(rank)};
  if (single && dot != std::string::npos && vector_rank != std::string_view::npos) return {prefix, int(vector_rank)};
  if (single && dot != std::string::npos && crypto_rank != std::string_view::npos) return {prefix, int(crypto_rank)};
  if (channel == "Y") return {"", 0};
  return {channel, 0};
}

/// Channel names of each layer, in the order of their ranks.
std::map<std::string, std::map<int, std::string>> group_channels(const Imf::ChannelList& channels) {
  std::map<std::string, std::map<int, std::string>> layers;
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
    const Place place = place_of(channel.name());
    layers[place.layer][place.rank] = channel.name();
  }
  return layers;
}

/// The library's matrices are for row vectors.
Imath::M44f row_matrix(const Eigen::Matrix4f& matrix) {
  Imath::M44f rows;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) rows[i][j] = matrix(j, i);
  return rows;
}

void describe(const ExrHeader& about, Imf::Header& header) {
  for (const auto& [key, text] : about.texts) header.insert(key, Imf::StringAttribute(text));
  if (about.is_rec709) Imf::addChromaticities(header, Imf::Chromaticities());  // by default those of Rec. 709
  if (about.world_to_camera) Imf::addWorldToCamera(header, row_matrix(*about.world_to_camera));
  if (about.world_to_ndc) Imf::addWorldToNDC(header, row_matrix(*about.world_to_ndc));
}

std::vector<Layer> read_layers(std::string_view bytes, const std::string& name) {
  if (const std::string broken = broken_exr_promise(bytes); !broken.empty())
    fail_data(name, "is a damaged EXR (" + broken + ")");
  MemoryReader stream(bytes, name);
  Imf::InputFile file(stream);
  const auto window = file.header().dataWindow();
  const long long width = 1LL + window.max.x - window.min.x, height = 1LL + window.max.y - window.min.y;

  std::vector<Layer> layers;
  const auto groups = group_channels(file.header().channels());
  Imf::FrameBuffer buffer;
  for (const auto& [layer, channels] : groups)
    layers.push_back({layer, Image(int(width), int(height), int(channels.size()))});
  std::size_t index = 0;
  for (const auto& [layer, channels] : groups) {
    Image& image = layers[index++].image;
    const std::size_t stride = sizeof(float) * image.channels;
    int c = 0;
    for (const auto& [rank, channel] : channels) {
      buffer.insert(channel, Imf::Slice::Make(Imf::FLOAT, image.values.data() + c++, file.header().dataWindow(), stride,
                                              stride * std::size_t(width)));
    }
  }
  if (layers.empty()) fail_data(name, "is an EXR without channels");
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  return layers;
}

}  // namespace

bool is_exr(std::string_view bytes) {
  return bytes.substr(0, 4) == std::string_view("\x76\x2f\x31\x01", 4);
}

std::vector<Layer> decode_exr(std::string_view bytes, const std::string& name) {
  try {
    return read_layers(bytes, name);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    fail_data(name, std::string("is a damaged EXR (") + error.what() + ")");
  }
}

std::string encode_exr(const std::vector<Layer>& layers, const ExrHeader& about, const std::string& name) {
  assert(!layers.empty());
  const int width = layers.front().image.width, height = layers.front().image.height;
  Imf::Header header(width, height);
  header.compression() = Imf::ZIP_COMPRESSION;
  describe(about, header);
  Imf::FrameBuffer buffer;
  for (const Layer& layer : layers) {
    assert(layer.image.width == width && layer.image.height == height);
    const auto names = channel_names(layer);
    const std::size_t stride = sizeof(float) * names.size();
    for (std::size_t c = 0; c < names.size(); ++c) {
      header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
      char* base = reinterpret_cast<char*>(const_cast<float*>(layer.image.values.data() + c));  // only read
      buffer.insert(names[c], Imf::Slice(Imf::FLOAT, base, stride, stride * std::size_t(width)));
    }
  }
  MemoryWriter stream(name);
  {
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(buffer);
    file.writePixels(height);
  }
  return std::move(stream.bytes);
}

}  // namespace umax::codec
