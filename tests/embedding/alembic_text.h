// Reads an Alembic file, by code that shares nothing with its writer, and tells it as tests/clients/alembic_dump.cpp does.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace umax::test {

class AlembicText {
 public:
  explicit AlembicText(const std::string& bytes) : file_(bytes) {
    if (file_.substr(0, 5) != "Ogawa" || file_.at(5) != '\xff') throw std::runtime_error("not a finished Ogawa file");
    const std::vector<std::uint64_t> root = group(number<std::uint64_t>(8));
    read_samplings(data(root.at(4)));
    const std::string table = data(root.at(5));
    metadata_.emplace_back();
    for (std::size_t at = 0; at < table.size(); at += 1 + std::size_t(std::uint8_t(table[at])))
      metadata_.push_back(table.substr(at + 1, std::uint8_t(table[at])));
    tell_children(group(root.at(2)), "");
  }

  const std::string& text() const { return text_; }

 private:
  struct Sampling {
    double cycle = 0;
    std::vector<double> times;
  };

  template <class T>
  T number(std::size_t at) const {
    return number_in<T>(file_, at);
  }
  template <class T>
  static T number_in(const std::string& bytes, std::size_t at) {
    T value{};
    if (at + sizeof value > bytes.size()) throw std::runtime_error("the file ends too early");
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
  }
  std::vector<std::uint64_t> group(std::uint64_t position) const {
    if (position >> 63) throw std::runtime_error("data where a group should be");
    std::vector<std::uint64_t> children;
    if (position == 0) return children;
    const auto count = number<std::uint64_t>(position);
    for (std::uint64_t i = 0; i < count; ++i) children.push_back(number<std::uint64_t>(position + 8 + 8 * i));
    return children;
  }
  std::string data(std::uint64_t child) const {
    if (!(child >> 63)) throw std::runtime_error("a group where data should be");
    const std::uint64_t position = child & ~(std::uint64_t(1) << 63);
    return position == 0 ? std::string() : file_.substr(position + 8, number<std::uint64_t>(position));
  }

  void read_samplings(const std::string& bytes) {
    for (std::size_t at = 0; at < bytes.size();) {
      Sampling sampling{.cycle = number_in<double>(bytes, at + 4), .times = {}};
      const auto count = number_in<std::uint32_t>(bytes, at + 12);
      at += 16;
      for (std::uint32_t i = 0; i < count; ++i, at += 8) sampling.times.push_back(number_in<double>(bytes, at));
      samplings_.push_back(sampling);
    }
  }

  void tell_children(const std::vector<std::uint64_t>& object, const std::string& path) {
    const std::string headers = data(object.back());
    std::size_t at = 0;
    for (std::size_t i = 1; i + 1 < object.size(); ++i) {
      const auto length = number_in<std::uint32_t>(headers, at);
      const std::string name = headers.substr(at + 4, length);
      const std::string& metadata = metadata_.at(std::uint8_t(headers.at(at + 4 + length)));
      at += 5 + length;
      text_ += fmt::format("object {}/{} [{}]\n", path, name, metadata);
      const std::vector<std::uint64_t> child = group(object[i]);
      tell_properties(child.at(0));
      tell_children(child, path + "/" + name);
    }
    if (headers.size() != at + 32) throw std::runtime_error("an object's headers have another length");
  }

  void tell_properties(std::uint64_t position) {
    const std::vector<std::uint64_t> children = group(position);
    if (children.empty()) return;
    const std::string headers = data(children.back());
    std::size_t at = 0;
    for (std::size_t i = 0; i + 1 < children.size(); ++i) {
      const auto info = number_in<std::uint32_t>(headers, at);
      at += 4;
      const std::size_t width = std::size_t(1) << (info >> 2 & 3);
      const auto sized = [&] {
        std::uint32_t value = 0;
        std::memcpy(&value, headers.substr(at, width).data(), width);
        at += width;
        return value;
      };
      const bool is_compound = (info & 3) == 0;
      const std::uint32_t num_samples = is_compound ? 0 : sized(), sampling = info & 0x100 ? sized() : 0;
      if (info & 0x200) throw std::runtime_error("first and last change are not expected");
      const std::uint32_t length = sized();
      const std::string name = headers.substr(at, length);
      at += length;
      const std::string& metadata = metadata_.at(info >> 20 & 0xff);
      if (is_compound) {
        text_ += fmt::format("compound {} [{}]\n", name, metadata);
        tell_properties(children[i]);
        text_ += "end of " + name + "\n";
      } else {
        tell_samples(info, name, metadata, num_samples, samplings_.at(sampling), group(children[i]));
      }
    }
    if (at != headers.size()) throw std::runtime_error("headers of properties have another length");
  }

  void tell_samples(std::uint32_t info, const std::string& name, const std::string& metadata, std::uint32_t num_samples,
                    const Sampling& sampling, const std::vector<std::uint64_t>& samples) {
    // a scalar is told from an array of one value by what stands between samples: nothing, or empty dimensions
    const bool is_array = (info & 3) != 1, is_constant = (info & 0x800) != 0;
    const std::uint32_t pod = info >> 4 & 15, extent = info >> 12 & 0xff;
    static const char* const pods[] = {"bool_t",  "uint8_t",  "int8_t",  "uint16_t",  "int16_t",   "uint32_t",
                                       "int32_t", "uint64_t", "int64_t", "float16_t", "float32_t", "float64_t"};
    text_ += fmt::format("{} {}: {} x {}, samples {}{}, cycle {:.9g}, start {:.9g} [{}]\n",
                         is_array ? "array" : "scalar", name, pods[pod], extent, num_samples,
                         is_constant ? " constant" : "", sampling.cycle, sampling.times.at(0), metadata);
    const std::size_t count = is_constant ? 1 : num_samples, stride = is_array ? 2 : 1;
    if (samples.size() != count * stride) throw std::runtime_error(name + " has another number of samples");
    for (std::size_t s = 0; s < count; ++s) {
      const std::string bytes = data(samples[s * stride]);
      if (is_array) {
        text_ += " ";
        for (std::size_t i = 0; i < 16; ++i) text_ += fmt::format("{:02x}", std::uint8_t(bytes.at(i)));
        text_ += ":";
      }
      tell_numbers(bytes.substr(16), pod);
      text_ += "\n";
    }
  }

  void tell_numbers(const std::string& bytes, std::uint32_t pod) {
    const std::size_t size = pod <= 1 ? 1 : pod == 11 ? 8 : 4;
    for (std::size_t at = 0; at < bytes.size(); at += size) {
      if (pod <= 1) text_ += fmt::format(" {}", std::uint8_t(bytes[at]));
      if (pod == 5) text_ += fmt::format(" {}", number_in<std::uint32_t>(bytes, at));
      if (pod == 6) text_ += fmt::format(" {}", number_in<std::int32_t>(bytes, at));
      if (pod == 10) text_ += fmt::format(" {:.9g}", number_in<float>(bytes, at));
      if (pod == 11) text_ += fmt::format(" {:.17g}", number_in<double>(bytes, at));
    }
  }

  std::string file_, text_;
  std::vector<std::string> metadata_;
  std::vector<Sampling> samplings_;
};

}  // namespace umax::test
