// Figures of the matrix-free solver: single products, and linearised steps of blocks of hexes.
#include <fmt/format.h>
#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <numbers>

#include "core/element/elastic_energy.h"
#include "core/linear/multigrid/multigrid.h"
#include "tests/support/conjugate_gradient.h"
#include "tools/benchmarks/bench.h"

namespace umax {
namespace {

constexpr double young = 500e3, poisson = 0.3, density = 500, time_step = 1.0 / 60;

Cells block_cells(const Vector3i& size) {
  const Eigen::Index count = Eigen::Index(size[0]) * size[1] * size[2];
  Cells cells(count, 3);
  Eigen::Index e = 0;
  for (int i = 0; i < size[0]; ++i)
    for (int j = 0; j < size[1]; ++j)
      for (int k = 0; k < size[2]; ++k) cells.row(e++) << i, j, k;
  return cells;
}

// milliseconds of calls, ascending
template <class Call>
std::vector<double> time_calls(int calls, const Call& call) {
  std::vector<double> ms;
  for (int i = 0; i < calls; ++i) {
    const auto start = std::chrono::steady_clock::now();
    call();
    ms.push_back(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count());
  }
  std::sort(ms.begin(), ms.end());
  return ms;
}

// calls visit(slot, grid point) for the set bits of masks
template <class Visit>
void for_each_point(const BrickLattice& lattice, const std::vector<std::uint16_t>& masks, const Visit& visit) {
  for (std::size_t b = 1; b < lattice.bricks.size(); ++b)
    for (int slot = 0; slot < brick_slots; ++slot) {
      const int line = slot / brick_lanes, lane = slot % brick_lanes;
      const std::int32_t* place = lattice.bricks[b].place;
      if (masks[b * brick_lines + line] >> lane & 1)
        visit(int(b) * brick_slots + slot,
              Vector3i(brick_edge * place[0] + line / brick_edge, brick_edge * place[1] + line % brick_edge,
                       brick_lanes * place[2] + lane));
    }
}

// a number in [0, 1) for each cell
double scatter(const Vector3i& cell) {
  std::uint32_t h =
      std::uint32_t(cell[0]) * 73856093u ^ std::uint32_t(cell[1]) * 19349663u ^ std::uint32_t(cell[2]) * 83492791u;
  h = (h ^ h >> 16) * 0x45d9f3bu;
  h = (h ^ h >> 16) * 0x45d9f3bu;
  return double((h ^ h >> 16) % 100000) / 100000;
}

// bytes that it has allocated
std::size_t memory(const Multigrid& multigrid) {
  std::size_t bytes = 0;
  for (const MultigridLevel& level : multigrid.levels) {
    bytes += sizeof(float) * (level.matrix.frames.size() + level.matrix.diagonal.size() + level.inverse.size() +
                              level.b.size() + level.x[0].size() + level.x[1].size());
    bytes += sizeof(Brick) * level.lattice().bricks.size() + 4 * level.lattice().cell_masks.size() +
             sizeof(BrickParents) * level.parents.size() + sizeof(BrickChildren) * level.children.size();
  }
  bytes +=
      multigrid.stiff_cell_smoother.nodes.size() * (sizeof(StiffCellSmoother::Matrix24f) + sizeof(std::array<int, 8>)) +
      multigrid.stiff_cell_smoother.rows.size() * (sizeof(StiffCellSmoother::Rows) + sizeof(std::array<int, 64>)) +
      sizeof(float) * (multigrid.corrected.size() + multigrid.rest.size());
  return bytes + sizeof(double) * multigrid.dense_slots.size() * multigrid.dense_slots.size() * 9;
}

// A block of cubes, 1 m along x, clamped at x = 0, stepped once by a linearised implicit Euler step.
class LinearStep {
 public:
  LinearStep(const Vector3i& size, double bend, bool hard)
      : multigrid_(make_multigrid(make_brick_lattice(block_cells(size), Vector3d::Constant(1.0 / size[0])), poisson,
                                  {.degree = hard ? 3 : 2})),
        workspace_(test::make_workspace(multigrid_)) {
    const BrickLattice& lattice = this->lattice();
    stiffness_ = AlignedArray<float>(lattice.num_slots());
    for (AlignedArray<double>* v : {&positions_, &b_, &x_})
      *v = AlignedArray<double>(lattice.num_slots() * vector_components);
    for_each_point(lattice, lattice.cell_masks, [&](int slot, const Vector3i& cell) {
      const double choice = scatter(cell);
      stiffness_[std::size_t(slot)] = float(young * (!hard ? 1 : choice < 0.01 ? 301 : choice < 0.11 ? 11 : 1));
    });
    const double h = 1.0 / size[0];
    for_each_point(lattice, lattice.node_masks, [&](int slot, const Vector3i& node) {
      double share = 1;  // of the full mass: half at each face
      for (int axis = 0; axis < 3; ++axis) share *= node[axis] == 0 || node[axis] == size[axis] ? 0.5 : 1;
      const double w = share * density * h * h * h / (time_step * time_step);
      multigrid_.levels.front().matrix.diagonal[std::size_t(slot)] = float(node[0] == 0 ? -w : w);
      const Vector3d place = bent(h * node.cast<double>(), bend);
      set_node_value(slot, place, positions_);
    });
    right_hand_side();
  }

  const BrickLattice& lattice() const { return multigrid_.levels.front().lattice(); }

  test::ConjugateGradientReport run(double tolerance) {
    MultigridLevel& level = multigrid_.levels.front();
    const auto start = std::chrono::steady_clock::now();
    set_frames(level.op, positions_, stiffness_, level.matrix);
    const auto assembled = std::chrono::steady_clock::now();
    set_up(multigrid_);
    const auto ready = std::chrono::steady_clock::now();
    const test::ConjugateGradientReport report =
        test::solve(multigrid_, nullptr, {.tolerance = tolerance}, b_, workspace_, x_);
    frames_ms = std::chrono::duration<double, std::milli>(assembled - start).count();
    set_up_ms = std::chrono::duration<double, std::milli>(ready - assembled).count();
    return report;
  }

  double megabytes() const {
    return 1e-6 * double(memory(multigrid_) + 4 * (3 * workspace_.step.size() + stiffness_.size()) +
                         8 * 3 * positions_.size());
  }

  double frames_ms = 0, set_up_ms = 0;

 private:
  static Vector3d bent(const Vector3d& p, double angle) {
    if (angle == 0) return p;
    const double phi = angle * p[0], radius = 1 / angle - (p[1] - 0.5);
    const Vector3d wave = 0.01 * Vector3d(std::sin(11 * p[1]), std::sin(13 * p[2]), std::sin(17 * p[0]));
    return Vector3d(radius * std::sin(phi), 1 / angle - radius * std::cos(phi) + 0.5, p[2]) + wave;
  }

  // m g - elastic forces; the clamps stay
  void right_hand_side() {
    const MultigridLevel& level = multigrid_.levels.front();
    const HexShape shape = make_box_shape(lattice().cell_size, poisson);
    const auto is_free = [&](int slot) { return level.matrix.diagonal[std::size_t(slot)] > 0; };
    for_each_point(lattice(), lattice().node_masks, [&](int slot, const Vector3i&) {
      const double w = double(level.matrix.diagonal[std::size_t(slot)]);
      if (is_free(slot)) set_node_value(slot, Vector3d(0, -9.81 * time_step * time_step * w, 0), b_);
    });
    for_each_point(lattice(), lattice().cell_masks, [&](int slot, const Vector3i&) {
      const std::array<int, 8> nodes = corner_slots(lattice(), slot);
      Matrix8x3d x;
      for (int n = 0; n < 8; ++n) x.row(n) = node_value(positions_, nodes[n]);
      const CorotatedHex hex = corotate(shape, RotationEstimate::centre, x);
      const Vector24d gradient = warped_gradient(shape.stiffness, double(stiffness_[std::size_t(slot)]), hex);
      for (int n = 0; n < 8; ++n)
        if (is_free(nodes[n]))
          set_node_value(nodes[n], Vector3d(node_value(b_, nodes[n]) - gradient.segment<3>(3 * n)), b_);
    });
  }

  Multigrid multigrid_;
  test::ConjugateGradientWorkspace workspace_;
  AlignedArray<float> stiffness_;
  AlignedArray<double> positions_, b_, x_;
};

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return double(usage.ru_maxrss) * 1024e-6;
}

BenchRows linear_step(const std::string& what, const Vector3i& size, double bend, bool hard, int calls, double ms_limit,
                      double mb_limit, const std::string& aim) {
  LinearStep step(size, bend, hard);
  test::ConjugateGradientReport report;
  const std::vector<double> ms = time_calls(calls, [&] { report = step.run(1e-6); });
  const double least = ms.front(), median = ms[ms.size() / 2];
  const std::string remark = fmt::format("least {:.4g}, {} its to {:.1e}; frames {:.1f}, set-up {:.1f}", least,
                                         report.iterations, report.residual, step.frames_ms, step.set_up_ms);
  BenchRows rows;
  if (ms_limit > 0) {
    rows.push_back(at_most(what + ": linearised step", median, ms_limit, "ms", remark));
    rows.back().target += " (aim " + aim + ")";
    rows.push_back(at_most(what + ": memory", step.megabytes(), mb_limit, "MB",
                           fmt::format("peak of the process {:.0f}", peak_megabytes())));
  } else {
    rows.push_back({what + ": linearised step", fmt::format("{:.4g} ms, {}", median, remark), "", true});
  }
  if (hard) rows.push_back(at_most(what + ": iterations", report.iterations, 40, "", "aim 15"));
  return rows;
}

BenchRows operator_speed(int n, double limit, const std::string& aim, int calls) {
  const BrickLattice bricks = make_brick_lattice(block_cells(Vector3i::Constant(n)), Vector3d::Constant(1.0 / n));
  const HexOperator op = make_hex_operator(bricks, make_box_shape(bricks.cell_size, poisson));
  HexMatrix<float> matrix = make_hex_matrix<float>(bricks);
  AlignedArray<float> x(bricks.num_slots() * vector_components), y(x.size());
  for_each_point(bricks, bricks.cell_masks, [&](int slot, const Vector3i&) {
    set_frame_at(slot, std::sqrt(young) * Matrix3d::Identity(), matrix.frames);
  });
  for_each_point(bricks, bricks.node_masks, [&](int slot, const Vector3i& node) {
    matrix.diagonal[std::size_t(slot)] = 1;
    set_node_value(slot, Vector3f(Vector3f::Constant(float(scatter(node)))), x);
  });
  const std::vector<double> ms = time_calls(calls, [&] { apply(op, matrix, x, y); });
  const double per_hex = 1e6 / double(bricks.num_cells);
  BenchRow row = at_most(fmt::format("operator, float, {} hexes", bricks.num_cells), ms[ms.size() / 2] * per_hex, limit,
                         "ns/hex", fmt::format("least {:.2f}", ms.front() * per_hex));
  row.target += " (aim " + aim + ")";
  return {row};
}

}  // namespace

std::vector<Benchmark> multigrid_benchmarks() {
  return {
      {"operator", false, false,
       [] {
         BenchRows rows = operator_speed(46, 4, "2.5", 200);
         for (const BenchRow& row : operator_speed(100, 10, "5", 30)) rows.push_back(row);
         return rows;
       }},
      {"multigrid", false, false,
       [] {
         BenchRows rows = linear_step("97 k hexes at rest", {46, 46, 46}, 0, false, 15, 60, 150, "20 ms, 60 MB");
         for (const BenchRow& row : linear_step("97 k hexes bent", {46, 46, 46}, 1.57, false, 9, 0, 0, ""))
           rows.push_back(row);
         for (const BenchRow& row : linear_step("97 k hexes bent, hard", {46, 46, 46}, 1.57, true, 5, 0, 0, ""))
           rows.push_back(row);
         return rows;
       }},
      {"million", false, false,
       [] { return linear_step("1 M hexes at rest", {100, 100, 100}, 0, false, 5, 1000, 1000, "400 ms, 400 MB"); }},
  };
}

}  // namespace umax
