#include "tools/setup/pull_file.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/base/error.h"
#include "core/files/sha256.h"
#include "tools/setup/byte_writer.h"

namespace umax {
namespace {

static_assert(std::endian::native == std::endian::little, "files of pulls are little-endian");

constexpr std::string_view pulls_magic = "UMAXPULL";
constexpr std::uint32_t version = 1;
constexpr std::size_t pulls_header_size = 8 + 4 + 4 + 8, pulls_digest_size = 64;
constexpr std::size_t pull_size = sizeof(std::int64_t) + 2 * sizeof(std::int32_t) + 12 * sizeof(double);

int number_of(const std::string& body, const Model& model) {
  const auto found = std::find_if(model.bodies.begin(), model.bodies.end(),
                                  [&](const Model::BodyRange& range) { return range.name == body; });
  return int(found - model.bodies.begin());
}

[[noreturn]] void refuse(const std::string& where, const std::string& what, const std::string& value = "") {
  throw Error(Fault::bad_data,
              {where, what, value, "save the session again with umax live, or leave clip.pulls out of the scene"});
}

template <class T>
T take(std::string_view& bytes) {
  T value;
  std::memcpy(&value, bytes.data(), sizeof value);
  bytes.remove_prefix(sizeof value);
  return value;
}

Pull take_pull(std::string_view& bytes, const std::string& where, const Model& model) {
  const auto body = take<std::int32_t>(bytes), hex = take<std::int32_t>(bytes);
  if (body < 0 || body >= std::int32_t(model.bodies.size()) || hex < 0 || hex >= model.bodies[body].num_hexes)
    refuse(where, "pulls at a hex that the scene does not have", std::to_string(hex));
  Pull pull{.body = model.bodies[body].name, .hex = hex};
  for (double& weight : pull.weights) weight = take<double>(bytes);
  pull.stiffness = take<double>(bytes);
  for (double& coordinate : pull.place) coordinate = take<double>(bytes);
  if (!pull.weights.allFinite() || !pull.place.allFinite() || !std::isfinite(pull.stiffness) || pull.stiffness <= 0)
    refuse(where, "holds a pull that is no spring");
  return pull;
}

}  // namespace

std::string encode_pulls(const RecordedPulls& pulls, const Model& model) {
  ByteWriter out;
  out.bytes.append(pulls_magic);
  std::uint64_t count = 0;
  for (const auto& [step, of_step] : pulls) count += of_step.size();
  out.put_all(version, std::uint32_t(0), count);
  for (const auto& [step, of_step] : pulls)
    for (const Pull& pull : of_step) {
      out.put_all(std::int64_t(step), std::int32_t(number_of(pull.body, model)), std::int32_t(pull.hex));
      for (const double weight : pull.weights) out.put(weight);
      out.put_all(pull.stiffness, pull.place.x(), pull.place.y(), pull.place.z());
    }
  out.bytes.append(sha256_hex(out.bytes));
  return std::move(out.bytes);
}

RecordedPulls decode_pulls(std::string_view bytes, const std::string& where, const Model& model) {
  if (!bytes.starts_with(pulls_magic)) refuse(where, "is no file of pulls");
  if (bytes.size() < pulls_header_size + pulls_digest_size) refuse(where, "is damaged: it ends too early");
  const std::size_t body_size = bytes.size() - pulls_digest_size;
  if (sha256_hex(bytes.substr(0, body_size)) != bytes.substr(body_size))
    refuse(where, "is damaged: its checksum does not fit");
  std::string_view rest = bytes.substr(pulls_magic.size(), body_size - pulls_magic.size());
  const auto found_version = take<std::uint32_t>(rest);
  if (found_version != version) refuse(where, "was written by another version of umax", std::to_string(found_version));
  take<std::uint32_t>(rest);
  const auto count = take<std::uint64_t>(rest);
  if (rest.size() % pull_size != 0 || count != rest.size() / pull_size)
    refuse(where, "is damaged: its length does not fit");
  RecordedPulls pulls;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto step = take<std::int64_t>(rest);
    if (step < 0) refuse(where, "pulls before the first step", std::to_string(step));
    pulls[step].push_back(take_pull(rest, where, model));
  }
  return pulls;
}

}  // namespace umax
