#include "core/model/hex_limits.h"

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/element/material.h"

namespace umax {
namespace {

constexpr std::array<EnergyPart, num_energy_parts> all_parts{EnergyPart::whole, EnergyPart::volumetric,
                                                             EnergyPart::deviatoric, EnergyPart::fibre};

template <class Options, class Parts>
Options& choose(Options& whole, Parts& parts, EnergyPart part) {
  switch (part) {
    case EnergyPart::whole:
      break;
    case EnergyPart::volumetric:
      return parts.volumetric;
    case EnergyPart::deviatoric:
      return parts.deviatoric;
    case EnergyPart::fibre:
      return parts.fibre;
  }
  return whole;
}

bool measures_whole_mean(EnergyPart part, LimitMeasure measure) {
  return part == EnergyPart::whole && measure == LimitMeasure::mean;
}

void append_fibres(const Body& body, Eigen::Index first_hex, Model& model) {
  const Eigen::Index count = body.lattice.num_hexes();
  model.fibre_directions.conservativeResize(first_hex + count, 3);
  for (Eigen::Index e = 0; e < count; ++e)
    model.fibre_directions.row(first_hex + e) = body.fibre_directions.rows() > 0
                                                    ? body.fibre_directions.row(e).normalized()
                                                    : body.part_limits.fibre_direction.transpose().normalized();
}

// the forms of a body's limit on a part: one, or one for each quadrature point
void append_forms(const HexShape& shape, EnergyPart part, LimitMeasure measure, const Vector3d& fibre,
                  std::vector<Matrix24d>& forms) {
  if (measure == LimitMeasure::mean)
    forms.push_back(part_stiffness(shape, part, fibre));
  else
    for (int q = 0; q < 8; ++q) forms.push_back(part_stiffness_at(shape, part, fibre, q));
}

// Index of the first form of a hex's limit on a part; equal hexes share them.
int first_form(const Body& body, Eigen::Index first_hex, Eigen::Index hex, EnergyPart part, LimitMeasure measure,
               Model& model) {
  const bool own_fibre = part == EnergyPart::fibre && body.fibre_directions.rows() > 0;
  if (!own_fibre && hex > first_hex && model.hex_shape[hex] == model.hex_shape[hex - 1])
    for (int l = model.limit_starts[hex - 1]; l < model.limit_starts[hex]; ++l)
      if (model.limits[l].part == part) return model.limits[l].form;
  const int first = int(model.limit_forms.size());
  append_forms(model.shapes[model.hex_shape[hex]], part, measure, model.fibre_directions.row(hex).transpose(),
               model.limit_forms);
  return first;
}

void append_hex_limits(const Body& body, Eigen::Index first_hex, Eigen::Index hex, EnergyPart part, Model& model) {
  const EnergyLimitOptions& options = limit_on(body.limit, body.part_limits, part);
  if (options.kind == LimitKind::none) return;
  HexLimit limit{.hex = int(hex), .part = part, .kind = options.kind};
  if (measures_whole_mean(part, options.measure)) {
    model.limits.push_back(limit);
    return;
  }
  limit.form = first_form(body, first_hex, hex, part, options.measure, model);
  for (int i = 0; i < (options.measure == LimitMeasure::mean ? 1 : 8); ++i, ++limit.form) model.limits.push_back(limit);
}

}  // namespace

EnergyLimitOptions& limit_on(EnergyLimitOptions& whole, PartLimitOptions& parts, EnergyPart part) {
  return choose(whole, parts, part);
}
const EnergyLimitOptions& limit_on(const EnergyLimitOptions& whole, const PartLimitOptions& parts, EnergyPart part) {
  return choose(whole, parts, part);
}

void append_limits(const Body& body, Eigen::Index first_hex, Model& model) {
  const Eigen::Index count = body.lattice.num_hexes();
  append_fibres(body, first_hex, model);
  model.limit_starts.conservativeResize(first_hex + count + 1);
  for (Eigen::Index e = first_hex; e < first_hex + count; ++e) {
    for (const EnergyPart part : all_parts) append_hex_limits(body, first_hex, e, part, model);
    model.limit_starts[e + 1] = int(model.limits.size());
  }
}

double energy_limit_at(const Model& model, Eigen::Index hex, double time, EnergyPart part) {
  const Model::BodyRange& body = body_of(model, hex);
  const EnergyLimitOptions& limit = limit_on(body.limit, body.part_limits, part);
  if (limit.kind == LimitKind::none) return std::numeric_limits<double>::infinity();
  const double value = limit.value.at(time);
  const HexShape& shape = model.shapes[model.hex_shape[hex]];
  switch (limit.unit) {
    case LimitUnit::energy:
      return value * model.limit_factor[hex];
    case LimitUnit::density:
      return value * shape.volume * model.limit_factor[hex];
    case LimitUnit::stretch:
      break;
  }
  return uniaxial_share(part, shape.poisson) * density_from_stretch(young_at(model, hex, time), value) * shape.volume *
         model.limit_factor[hex];
}

void require_measurable(const Model& model, EnergyMeasure measure) {
  if (measure == EnergyMeasure::true_energy) return;
  for (const Model::BodyRange& body : model.bodies)
    for (const EnergyPart part : all_parts) {
      const EnergyLimitOptions& limit = limit_on(body.limit, body.part_limits, part);
      if (limit.kind == LimitKind::none || measures_whole_mean(part, limit.measure)) continue;
      const std::string name = "body." + body.name + "." + limit_name(part);
      throw Error(Fault::bad_data, {.where = part == EnergyPart::whole ? name + ".measure" : name,
                                    .what = "limits a part or a peak, which only the true energy has",
                                    .value = "solver.energy = \"paper\"",
                                    .remedy = "set solver.energy = \"true\", or leave this limit out"});
    }
}

double limited_energy(const Model& model, EnergyMeasure measure, const HexLimit& limit, double young,
                      const CorotatedHex& hex) {
  const HexShape& shape = model.shapes[model.hex_shape[limit.hex]];
  return elastic_energy(limit.form < 0 ? measured_stiffness(shape, measure) : model.limit_forms[limit.form], young,
                        hex);
}

double limit_value(const Model& model, EnergyMeasure measure, const HexLimit& limit, double young, double max_energy,
                   const CorotatedHex& hex) {
  return 1 - limited_energy(model, measure, limit, young, hex) / max_energy;
}

Vector24d limited_gradient(const Model& model, EnergyMeasure measure, LimitJacobian jacobian, RotationEstimate estimate,
                           const HexLimit& limit, double young, const CorotatedHex& hex) {
  const HexShape& shape = model.shapes[model.hex_shape[limit.hex]];
  if (limit.form < 0) return -energy_limit_jacobian(shape, measure, jacobian, estimate, young, 1.0, hex);
  const Matrix24d& K = model.limit_forms[limit.form];
  return jacobian == LimitJacobian::exact ? exact_gradient(K, young, shape.rotation_gradients[int(estimate)], hex)
                                          : warped_gradient(K, young, hex);
}

VectorXd largest_by_hex(const Model& model, const VectorXd& of_limits) {
  VectorXd largest = VectorXd::Zero(model.num_hexes());
  for (std::size_t l = 0; l < model.limits.size(); ++l) {
    const double value = of_limits[Eigen::Index(l)];
    double& of_hex = largest[model.limits[l].hex];
    if (value > of_hex || std::isnan(value)) of_hex = value;  // what is no number must show
  }
  return largest;
}

int count_hexes(const Model& model, const VectorXd& of_limits) {
  return int((largest_by_hex(model, of_limits).array() > 0).count());
}

}  // namespace umax
