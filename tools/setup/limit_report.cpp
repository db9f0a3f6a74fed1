#include "tools/setup/limit_report.h"

#include <fmt/format.h>

#include <cmath>
#include <set>

#include "core/element/material.h"
#include "embedding/cage/hex_cage.h"

namespace umax {
namespace {

constexpr double sudden_rate = 0.5;     // [1/s] of stretch
constexpr double sudden_change = 0.01;  // of stretch: less throws nothing

// time 0, and the keys of whatever changes the limit
std::set<double> telling_times(const BodyDescription& body, const EnergyLimitOptions& limit) {
  std::set<double> times{0};
  for (const Track<double>* track : {&limit.value, &body.material.young})
    for (const double time : track->is_constant() ? std::vector<double>() : track->times)
      if (time > 0) times.insert(time);
  return times;
}

double density_of(const EnergyLimitOptions& limit, EnergyPart part, double time, double young, double poisson,
                  double hex_volume) {
  const double value = limit.value.at(time);
  switch (limit.unit) {
    case LimitUnit::energy:
      return value / hex_volume;
    case LimitUnit::density:
      return value;
    case LimitUnit::stretch:
      break;
  }
  return uniaxial_share(part, poisson) * density_from_stretch(young, value);
}

std::string unit_name(LimitUnit unit) {
  return unit == LimitUnit::energy ? "energy" : unit == LimitUnit::density ? "density" : "stretch";
}

}  // namespace

double mean_hex_volume(const Lattice& lattice) {
  return lattice.is_regular() ? lattice.cell_size.prod() : hex_volumes(lattice).mean();
}

double stretch_of_limit(const BodyDescription& body, EnergyPart part, double value, double time, double hex_volume) {
  EnergyLimitOptions limit = limit_on(body.limit, body.part_limits, part);
  if (limit.unit == LimitUnit::stretch) return value;
  limit.value = value;
  const double young = body.material.young.at(time), poisson = body.material.poisson;
  const double density = density_of(limit, part, time, young, poisson, hex_volume);
  return stretch_from_density(young * uniaxial_share(part, poisson), density);
}

std::vector<LimitReport> limit_reports(const BodyDescription& body, double hex_volume) {
  std::vector<LimitReport> reports;
  const double poisson = body.material.poisson;
  for (const EnergyPart part : {EnergyPart::whole, EnergyPart::volumetric, EnergyPart::deviatoric, EnergyPart::fibre}) {
    const EnergyLimitOptions& limit = limit_on(body.limit, body.part_limits, part);
    if (limit.kind == LimitKind::none) continue;
    for (const double time : telling_times(body, limit)) {
      const double young = body.material.young.at(time);
      const double density = density_of(limit, part, time, young, poisson, hex_volume);
      reports.push_back({.part = part,
                         .kind = limit.kind,
                         .measure = limit.measure,
                         .time = time,
                         .energy = density * hex_volume,
                         .density = density,
                         .strains = equivalents(part, density, young, poisson)});
    }
  }
  return reports;
}

std::string limit_text(const LimitReport& report, const std::string& hex) {
  std::string others;
  const auto add = [&others](double strain, const char* name) {
    if (std::isfinite(strain)) others += fmt::format("{}{:.3g} % {}", others.empty() ? "" : ", ", 100 * strain, name);
  };
  add(report.strains.shear, "shear");
  add(report.strains.volume_change, "volume change");
  const char* along = report.part == EnergyPart::fibre ? " along the fibre" : "";
  return fmt::format("{:.4g} J per {} = {:.4g} J/m^3 = {:.4g} % stretch{}{}", report.energy, hex, report.density,
                     100 * report.strains.stretch, along, others.empty() ? "" : " (by itself: " + others + ")");
}

std::map<std::string, std::string> limit_comments(const Simulation& simulation) {
  std::map<std::string, std::string> comments;
  for (std::size_t i = 0; i < simulation.scene.bodies.size(); ++i) {
    const BodyDescription& body = simulation.scene.bodies[i];
    const Lattice& lattice = simulation.bodies[i].lattice;
    const std::vector<LimitReport> reports = limit_reports(body, mean_hex_volume(lattice));
    for (const LimitReport& report : reports) {
      const EnergyLimitOptions& limit = limit_on(body.limit, body.part_limits, report.part);
      std::string& text = comments["body." + body.name + "." + limit_name(report.part) + "." + unit_name(limit.unit)];
      const bool keyed = telling_times(body, limit).size() > 1;
      text += (text.empty() ? "" : "; ") + (keyed ? fmt::format("at {:g} s: ", report.time) : std::string()) +
              limit_text(report, lattice.is_regular() ? "hex" : "hex of the mean volume");
    }
  }
  return comments;
}

void warn_of_sudden_limits(const Simulation& simulation, std::vector<std::string>& warnings) {
  for (std::size_t i = 0; i < simulation.scene.bodies.size(); ++i) {
    const std::vector<LimitReport> reports =
        limit_reports(simulation.scene.bodies[i], mean_hex_volume(simulation.bodies[i].lattice));
    for (std::size_t r = 1; r < reports.size(); ++r) {
      const LimitReport &from = reports[r - 1], &to = reports[r];
      const double fall = from.strains.stretch - to.strains.stretch;
      if (from.part != to.part || fall <= sudden_change || fall <= sudden_rate * (to.time - from.time)) continue;
      warnings.push_back(
          fmt::format("body.{}.{} falls from {:.4g} % to {:.4g} % stretch between {:g} s and {:g} s: what is stretched "
                      "that far by then is thrown; spread the keys over {:.2g} s or more",
                      simulation.bodies[i].name, limit_name(to.part), 100 * from.strains.stretch,
                      100 * to.strains.stretch, from.time, to.time, fall / sudden_rate));
    }
  }
}

}  // namespace umax
