#include "core/step/multigrid_system.h"

#include <algorithm>
#include <utility>

#include "core/base/parallel.h"

namespace umax {
namespace {

constexpr Eigen::Index grain = 4096;

// calls put(value in bricks, value given) for the body's part of what is given per node of the model
template <class T, class Put>
void to_bricks(const Model::BodyRange& body, const std::vector<int>& slots, const double* values,
               AlignedArray<T>& bricks, const Put& put) {
  parallel_blocks(body.num_nodes, grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index node = begin; node < end; ++node)
      for (int c = 0; c < 3; ++c)
        put(bricks[slot_offset(slots[node], vector_components) + std::size_t(c) * brick_lanes],
            values[3 * (body.first_node + node) + c]);
  });
}

// the other way, times a factor
void from_bricks(const Model::BodyRange& body, const std::vector<int>& slots, const AlignedArray<float>& bricks,
                 double factor, VectorXd& values) {
  parallel_blocks(body.num_nodes, grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index node = begin; node < end; ++node)
      for (int c = 0; c < 3; ++c)
        values[3 * (body.first_node + node) + c] =
            factor * double(bricks[slot_offset(slots[node], vector_components) + std::size_t(c) * brick_lanes]);
  });
}

const RankOneTerms& finest_terms(const BodyGrid& grid) {
  return grid.terms.levels.front().terms;
}

double largest_value(const Model::BodyRange& body, const VectorXd& values) {
  return values.segment(3 * Eigen::Index(body.first_node), 3 * Eigen::Index(body.num_nodes)).cwiseAbs().maxCoeff();
}

BodyGrid make_body_grid(const Model& model, const Model::BodyRange& body) {
  BodyGrid grid;
  grid.multigrid = make_multigrid(make_brick_lattice(body.cells, body.cell_edges), body.material.poisson);
  const BrickLattice& lattice = grid.multigrid.levels.front().lattice();
  grid.cell_slots = cell_slots(lattice, body.cells);
  Hexes hexes = model.hexes.middleRows(body.first_hex, body.num_hexes);
  hexes.array() -= body.first_node;
  grid.node_slots = node_slots(lattice, body.cells, hexes, body.num_nodes);
  grid.stiffness = AlignedArray<float>(lattice.num_slots());
  grid.positions = AlignedArray<double>(lattice.num_slots() * vector_components);
  grid.point = make_saddle_point(grid.multigrid);
  return grid;
}

void set_up_matrix(const StepProblem& problem, const Model::BodyRange& body, const Points& positions,
                   const VectorXd& stiffening, BodyGrid& grid) {
  const Model& model = *problem.model;
  const double h = problem.h;
  MultigridLevel& level = grid.multigrid.levels.front();
  parallel_blocks(body.num_hexes, grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index e = begin; e < end; ++e) {
      const Eigen::Index hex = body.first_hex + e;
      grid.stiffness[grid.cell_slots[e]] =
          float(problem.materials.young[hex] * (1 + stiffening[hex] + problem.damping_stiffness[hex] / h));
    }
  });
  parallel_blocks(body.num_nodes, grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) {
      const Eigen::Index node = body.first_node + i;
      const float w = float(model.node_mass[node] * (1 / (h * h) + problem.damping_mass[node] / h));
      level.matrix.diagonal[grid.node_slots[i]] = model.node_fixed[node] ? -w : w;
    }
  });
  to_bricks(body, grid.node_slots, positions.data(), grid.positions, [](double& in, double given) { in = given; });
  set_frames(level.op, grid.positions, grid.stiffness, level.matrix);
  set_up_levels(grid.multigrid);
}

void set_terms(const Model& model, const std::vector<RankOneTerm>& terms, MultigridSystem& system) {
  std::vector<std::vector<RankOneTerm>> of_body(system.bodies.size());
  std::vector<std::vector<int>> sources(system.bodies.size());
  system.offset_force.setZero(3 * model.num_nodes());
  for (std::size_t t = 0; t < terms.size(); ++t) {
    const RankOneTerm& term = terms[t];
    const int b = model.hex_body[term.hex];
    of_body[b].push_back({term.hex - model.bodies[b].first_hex, term.vector, term.offset, term.group});
    sources[b].push_back(int(t));
    for (int n = 0; n < 8; ++n)
      system.offset_force.segment<3>(3 * model.hexes(term.hex, n)) += term.offset * term.vector.segment<3>(3 * n);
  }
  clear_fixed(model, system.offset_force);
  for (std::size_t b = 0; b < system.bodies.size(); ++b) {
    const Model::BodyRange& body = model.bodies[b];
    BodyGrid& grid = system.bodies[b];
    const MultigridLevel& level = grid.multigrid.levels.front();
    RankOneTerms sorted =
        make_rank_one_terms(of_body[b], body.cells, model.hexes.middleRows(body.first_hex, body.num_hexes),
                            body.first_node, grid.node_slots, level.matrix.diagonal);
    for (int& source : sorted.sources) source = sources[b][source];
    set_up(grid.multigrid, std::move(sorted), grid.terms);
  }
}

}  // namespace

double multigrid_slots(const Cells& cells) {
  return cells.rows() > 0 ? double(make_brick_lattice(cells, Vector3d::Ones()).num_slots()) : 0;
}

MultigridSystem make_multigrid_system(const Model& model) {
  MultigridSystem system;
  for (const Model::BodyRange& body : model.bodies) system.bodies.push_back(make_body_grid(model, body));
  return system;
}

void set_up(const StepProblem& problem, const Points& positions, const VectorXd& stiffening,
            const std::vector<RankOneTerm>& terms, MultigridSystem& system) {
  for (std::size_t b = 0; b < system.bodies.size(); ++b)
    set_up_matrix(problem, problem.model->bodies[b], positions, stiffening, system.bodies[b]);
  set_terms(*problem.model, terms, system);
}

void begin(const Model& model, const VectorXd& b, MultigridSystem& system) {
  for (std::size_t i = 0; i < system.bodies.size(); ++i) {
    BodyGrid& grid = system.bodies[i];
    const VectorXd& offsets = finest_terms(grid).offsets;
    VectorXd c = VectorXd::Zero(offsets.size());
    grid.unit = largest_value(model.bodies[i], b);
    if (!offsets.isZero(0)) {
      if (grid.unit == 0) grid.unit = 1;
      c = -offsets / grid.unit;
    }
    begin(c, grid.point);
  }
  add_force(model, b, system);
}

void add_force(const Model& model, const VectorXd& force, MultigridSystem& system) {
  for (std::size_t i = 0; i < system.bodies.size(); ++i) {
    const Model::BodyRange& body = model.bodies[i];
    BodyGrid& grid = system.bodies[i];
    if (grid.unit == 0) grid.unit = largest_value(body, force);
    if (grid.unit == 0) continue;
    grid.point.pushed = true;
    const double factor = 1 / grid.unit;
    to_bricks(body, grid.node_slots, force.data(), grid.point.residual,
              [factor](float& in, double given) { in += float(factor * given); });
  }
}

void add_contact_forces(const Model& model, const std::vector<Contact>& contacts, const VectorXd& forces,
                        MultigridSystem& system) {
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const Vector3d force = forces.segment<3>(3 * Eigen::Index(i));
    if (force.isZero(0)) continue;
    for_each_support(contacts[i], [&](const Support& support, double sign) {
      const int body = model.hex_body[support.hex];
      BodyGrid& grid = system.bodies[body];
      if (grid.unit == 0) grid.unit = force.cwiseAbs().maxCoeff();
      grid.point.pushed = true;
      for (int n = 0; n < 8; ++n) {
        const int node = model.hexes(support.hex, n);
        if (model.node_fixed[node]) continue;
        const std::size_t at = slot_offset(grid.node_slots[node - model.bodies[body].first_node], vector_components);
        for (int c = 0; c < 3; ++c)
          grid.point.residual[at + std::size_t(c) * brick_lanes] +=
              float(sign * support.weights[n] * force[c] / grid.unit);
      }
    });
  }
}

SaddlePointReport improve(const SaddlePointOptions& options, MultigridSystem& system) {
  SaddlePointReport of_all;
  for (BodyGrid& grid : system.bodies) {
    if (grid.unit == 0) continue;
    const SaddlePointReport report = solve(grid.multigrid, grid.terms, options, grid.point);
    of_all.iterations += report.iterations;
    of_all.started = std::max(of_all.started, report.started);
    of_all.error = std::max(of_all.error, report.error);
  }
  return of_all;
}

VectorXd contact_motions(const Model& model, const std::vector<Contact>& contacts, const MultigridSystem& system) {
  VectorXd motions = VectorXd::Zero(3 * Eigen::Index(contacts.size()));
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    for_each_support(contacts[i], [&](const Support& support, double sign) {
      const int body = model.hex_body[support.hex];
      const BodyGrid& grid = system.bodies[body];
      for (int n = 0; n < 8; ++n) {
        const int node = model.hexes(support.hex, n) - model.bodies[body].first_node;
        const std::size_t at = slot_offset(grid.node_slots[node], vector_components);
        for (int c = 0; c < 3; ++c)
          motions[3 * Eigen::Index(i) + c] +=
              grid.unit * (sign * support.weights[n]) * double(grid.point.x[at + std::size_t(c) * brick_lanes]);
      }
    });
  }
  return motions;
}

LinearSolution solution_of(const Model& model, const MultigridSystem& system) {
  LinearSolution solution{.x = VectorXd::Zero(3 * model.num_nodes()), .products = {}};
  Eigen::Index num_terms = 0;
  for (const BodyGrid& grid : system.bodies) num_terms += Eigen::Index(finest_terms(grid).vectors.size());
  solution.products.setZero(num_terms);
  for (std::size_t i = 0; i < system.bodies.size(); ++i) {
    const BodyGrid& grid = system.bodies[i];
    if (grid.unit == 0) continue;
    const VectorXd products = grid.unit * (grid.point.y + grid.point.c);
    for (Eigen::Index t = 0; t < products.size(); ++t) solution.products[finest_terms(grid).sources[t]] = products[t];
    from_bricks(model.bodies[i], grid.node_slots, grid.point.x, grid.unit, solution.x);
  }
  return solution;
}

}  // namespace umax
