// A test specimen of a few of the program's own hexes, loaded by dead weights and brought to rest by core's step().
//
// Tension, compression: a square block stands on a grip that follows its width (so that it is strained uniformly, as
// the middle of a long specimen is), and weights pull or push its far face.
// Shear: two layers between three plates. The outer plates are held, weights pull the middle one along itself.
#pragma once

#include <limits>
#include <memory>
#include <optional>

namespace umax {

enum class Loading { tension, compression, shear };

inline constexpr double no_limit = std::numeric_limits<double>::infinity();

struct SpecimenOptions {
  Loading loading = Loading::tension;
  double poisson = 0.3;             // [-]
  double limit_stretch = no_limit;  // [-] limit.stretch of every hex: 0.2 for 20 %
};

/// What is read off a specimen. Each is positive in tension and in shear, stretch is negative in compression.
struct SpecimenReading {
  double stretch = 0;  // [-] change of length over length; shear: motion of the middle plate over a layer's height
  double lateral_stretch = 0;  // [-] change of width over width, opposite in sign to stretch; shear: 0
  double peak_stretch = 0;     // [-] uniaxial stretch with the energy density of the hex that has most
};

/// Owns the model and its state: loads are best applied in ascending order, each starts from the last.
class Specimen {
 public:
  explicit Specimen(const SpecimenOptions& options);
  ~Specimen();
  Specimen(Specimen&&) noexcept;
  Specimen(const Specimen&) = delete;

  /// The specimen at rest under a load >= 0 [-]: nominal stress over Young's modulus. Nothing where no such rest is
  /// found, as when the load flattens the specimen; the specimen is then as it was.
  std::optional<SpecimenReading> at(double load);

 private:
  struct Rig;
  std::unique_ptr<Rig> rig_;
};

}  // namespace umax
