#include "tools/exchange/export_cages.h"

#include "core/files/write_file.h"
#include "core/step/step.h"
#include "embedding/caches/mesh_sequence.h"
#include "embedding/caches/vtu_file.h"
#include "tools/pictures/heat.h"
#include "tools/pictures/hex_stress.h"

namespace umax {
namespace fs = std::filesystem;
namespace {

/// What all hexes of the model hold.
struct HexValues {
  HexStress elastic;
  VectorXd energy_ratio, multiplier;
};

/// World to exported axes.
Matrix3d turn_of(const ExportOptions& options) {
  Matrix3d turn = Matrix3d::Identity();
  if (options.z_up)
    for (int axis = 0; axis < 3; ++axis) turn.col(axis) = z_up_from_y_up(Vector3d::Unit(axis));
  return turn;
}

/// The components of a body's stresses as VTK orders those of symmetric tensors.
MatrixXd stress_components(const BodySetup& body, const HexStress& elastic, const Matrix3d& turn) {
  MatrixXd components(body.lattice.num_hexes(), 6);
  for (Eigen::Index e = 0; e < components.rows(); ++e) {
    const Matrix3d stress = turn * elastic.stress[std::size_t(body.first_hex + e)] * turn.transpose();
    components.row(e) << stress(0, 0), stress(1, 1), stress(2, 2), stress(0, 1), stress(1, 2), stress(0, 2);
  }
  return components;
}

HexFrame cage_of(const Simulation& simulation, std::size_t index, const HexValues& values, const ExportOptions& options,
                 const State& state) {
  const BodySetup& body = simulation.bodies[index];
  const Eigen::Index first = body.first_hex, count = body.lattice.num_hexes();
  const Matrix3d turn = turn_of(options);
  const auto of_nodes = [&](const Points& all) {
    return Points(options.scale * all.middleRows(body.first_node, body.lattice.num_nodes()) * turn.transpose());
  };
  VectorXd distorting(count);
  for (Eigen::Index e = 0; e < count; ++e) distorting[e] = von_mises(values.elastic.stress[std::size_t(first + e)]);

  HexFrame frame;
  frame.time = state.time;
  frame.nodes = of_nodes(state.positions);
  frame.hexes = body.lattice.hexes;
  frame.node_data = {{"velocity", of_nodes(state.velocities)}};
  frame.hex_data = {{"energy", values.elastic.energy.segment(first, count)},
                    {"energy_ratio", values.energy_ratio.segment(first, count)},
                    {"multiplier", values.multiplier.segment(first, count)},
                    {"stress", stress_components(body, values.elastic, turn)},
                    {"von_mises", distorting},
                    {"body", VectorXd::Constant(count, double(index))}};
  return frame;
}

}  // namespace

void write_cages(const Simulation& simulation, const std::vector<ExportedThing>& bodies, const ExportOptions& options,
                 const fs::path& folder, int frame, const State& state) {
  const HexValues values{.elastic = hex_stress(simulation, state),
                         .energy_ratio = heat_values(simulation, state, Heatmap::energy),
                         .multiplier = heat_values(simulation, state, Heatmap::multiplier)};
  for (const ExportedThing& thing : bodies)
    write_file(sequence_file(folder / thing.stem, frame, "vtu"),
               vtu_bytes(cage_of(simulation, *thing.body, values, options, state)));
}

fs::path cage_index_file(const fs::path& folder) {
  return folder / "cages.pvd";
}

void write_cage_index(const ClipDescription& clip, const std::vector<ExportedThing>& bodies, const fs::path& folder) {
  std::vector<PvdEntry> entries;
  std::error_code error;
  for (int frame = 1; frame <= clip.frames; ++frame)
    for (std::size_t part = 0; part < bodies.size(); ++part)
      if (const fs::path file = sequence_file(bodies[part].stem, frame, "vtu"); fs::exists(folder / file, error))
        entries.push_back({(frame - 1) / clip.fps, int(part), file.generic_string()});
  write_file(cage_index_file(folder), pvd_text(entries));
}

}  // namespace umax
