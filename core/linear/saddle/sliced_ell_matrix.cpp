#include "core/linear/saddle/sliced_ell_matrix.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/parallel.h"
#include "core/linear/multigrid/chebyshev.h"

namespace umax {
namespace {

constexpr float entry_scale = 32767;  // of entries, which are -1 ... 1
constexpr Eigen::Index grain = 64;    // lines or slices per task
constexpr Eigen::Index terms_per_block = 4096;

// corners that a cell shares with each one near it: its own, the other's
using SharedCorners = std::array<std::vector<std::pair<int, int>>, num_near>;

const SharedCorners& shared_corners() {
  static const SharedCorners all = [] {
    SharedCorners shared;
    for (int d = 0; d < num_near; ++d)
      for (int n = 0; n < 8; ++n)
        for (int m = 0; m < 8; ++m)
          if (corner(n) == Vector3i(d / 9 - 1, d / 3 % 3 - 1, d % 3 - 1) + corner(m)) shared[d].emplace_back(n, m);
    return shared;
  }();
  return all;
}

// entry (t, u) of the scaled matrix, u in the hex in direction d
struct ScaledEntries {
  const SharedCorners& shared;
  const RankOneTerms& terms;
  const std::vector<RankOneTerms::Vector24f>& responses;
  const VectorXf& scale;

  float at(int t, int u, int d) const {
    float product = 0;
    for (const auto& [n, m] : shared[d])
      product += responses[t].segment<3>(3 * n).dot(terms.vectors[u].segment<3>(3 * m));
    return product * scale[t] * scale[u];
  }
};

using Place = TermLines::Place;

Place place_of(const Vector3i& cell) {
  return {cell[0], cell[1], cell[2] / brick_lanes};
}

Place beside(const Place& place, int dx, int dy, int dz) {
  return {place[0] + dx, place[1] + dy, place[2] + dz};
}

int line_at(const TermLines& lines, const Place& place) {
  const auto found = std::lower_bound(lines.places.begin(), lines.places.end(), place);
  return found != lines.places.end() && *found == place ? int(found - lines.places.begin()) : -1;
}

// calls visit(lane, hex, d, the hex near it in that direction) for all pairs whose first is in the line
template <class Visit>
void for_each_pair(const TermLines& lines, int line, const Visit& visit) {
  for (int d = 0; d < num_near; ++d) {
    const int other_line = lines.beside[line][d / 3];
    if (other_line < 0) continue;
    for (int lane = 0; lane < brick_lanes; ++lane) {
      const int hex = lines.hexes[line * brick_lanes + lane];
      if (hex < 0) continue;
      const int at = lane + d % 3 - 1;
      if (at < 0 && (other_line == 0 || !lines.continues(other_line - 1))) continue;
      if (at == brick_lanes && !lines.continues(other_line)) continue;
      const int other = lines.hexes[other_line * brick_lanes + at];  // lines that continue stand side by side
      if (other >= 0) visit(lane, hex, d, other);
    }
  }
}

// the entries of a line's slices: which there are, or their numbers
struct LineEntries {
  int layers = 0, most_layers = 1;
  std::vector<int> numbers;  // -1: none

  int& at(int layer, int d, int other_layer) { return numbers[(layer * num_near + d) * most_layers + other_layer]; }
};

// numbered slice by slice from `first`; returns the first of each slice and the end
std::vector<int> number_entries(const RankOneTerms& terms, const TermLines& lines, int line, int first,
                                LineEntries& entries) {
  entries.layers = lines.layers(line);
  entries.most_layers = lines.most_layers;
  entries.numbers.assign(std::size_t(entries.layers * num_near * entries.most_layers), -1);
  for_each_pair(lines, line, [&](int, int hex, int d, int other) {
    const int count = terms.hexes[hex].end - terms.hexes[hex].first,
              others = terms.hexes[other].end - terms.hexes[other].first;
    for (int a = 0; a < count; ++a)
      for (int b = 0; b < others; ++b)
        if (d != own_place || a != b) entries.at(a, d, b) = 0;
  });
  std::vector<int> starts{first};
  for (int layer = 0; layer < entries.layers; ++layer) {
    for (int i = layer * num_near * entries.most_layers; i < (layer + 1) * num_near * entries.most_layers; ++i)
      if (entries.numbers[std::size_t(i)] == 0) entries.numbers[std::size_t(i)] = first++;
    starts.push_back(first);
  }
  return starts;
}

void number_slices(const RankOneTerms& terms, const TermLines& lines, SlicedEllMatrix& matrix) {
  const auto slices = std::size_t(lines.first_slices.back());
  matrix.below.assign(slices, -1);
  matrix.above.assign(slices, -1);
  matrix.starts.assign(slices + 1, 0);
  matrix.lanes.resize(terms.vectors.size());
  parallel_blocks(lines.count(), grain, [&](Eigen::Index begin, Eigen::Index end) {
    LineEntries entries;
    for (int line = int(begin); line < int(end); ++line) {
      const int first = lines.first_slices[line];
      const std::vector<int> starts = number_entries(terms, lines, line, 0, entries);
      for (int layer = 0; layer < lines.layers(line); ++layer) {
        matrix.starts[first + layer + 1] = starts[layer + 1] - starts[layer];
        if (line > 0 && lines.continues(line - 1) && layer < lines.layers(line - 1))
          matrix.below[first + layer] = lines.first_slices[line - 1] + layer;
        if (lines.continues(line) && layer < lines.layers(line + 1))
          matrix.above[first + layer] = lines.first_slices[line + 1] + layer;
      }
      for (int lane = 0; lane < brick_lanes; ++lane)
        if (const int h = lines.hexes[line * brick_lanes + lane]; h >= 0)
          for (int t = terms.hexes[h].first; t < terms.hexes[h].end; ++t)
            matrix.lanes[t] = (first + t - terms.hexes[h].first) * brick_lanes + lane;
    }
  });
  std::partial_sum(matrix.starts.begin(), matrix.starts.end(), matrix.starts.begin());
}

// Fills the numbered entries.
void set_entries(const TermLines& lines, const ScaledEntries& all, SlicedEllMatrix& matrix) {
  const RankOneTerms& terms = all.terms;
  matrix.places.assign(std::size_t(matrix.starts.back()), 0);
  matrix.entries.assign(std::size_t(matrix.starts.back()) * brick_lanes, 0);
  VectorXf row_sums = VectorXf::Ones(matrix.scale.size());
  parallel_blocks(lines.count(), grain, [&](Eigen::Index begin, Eigen::Index end) {
    LineEntries entries;
    for (int line = int(begin); line < int(end); ++line) {
      number_entries(terms, lines, line, matrix.starts[lines.first_slices[line]], entries);
      for_each_pair(lines, line, [&](int lane, int hex, int d, int other) {
        const RankOneTerms::Hex &own = terms.hexes[hex], &near = terms.hexes[other];
        const int slices = lines.first_slices[lines.beside[line][d / 3]];  // those that the entries multiply
        for (int t = own.first; t < own.end; ++t)
          for (int u = near.first; u < near.end; ++u) {
            if (t == u) continue;
            const int number = entries.at(t - own.first, d, u - near.first);
            const float entry = std::clamp(all.at(t, u, d), -1.f, 1.f);
            row_sums[t] += std::abs(entry);
            matrix.places[number] = (slices + u - near.first) * slice_stride + d % 3;
            matrix.entries[std::size_t(number) * brick_lanes + lane] = std::int16_t(std::lrint(entry_scale * entry));
          }
      });
    }
  });
  matrix.largest = row_sums.size() > 0 ? row_sums.maxCoeff() : 1;
  const auto slices = Eigen::Index(matrix.below.size());
  for (VectorXf* of_lanes : {&matrix.rest, &matrix.x}) of_lanes->setZero(slices * brick_lanes);
  for (VectorXf& moves : matrix.moves) moves.setZero(slices * slice_stride);
}

// a lane as the first step leaves it, which goes along b
void begin(SlicedEllMatrix& matrix, int lane, float b, float gain) {
  const int slice = lane / brick_lanes, at = lane % brick_lanes;
  VectorXf& moves = matrix.moves[0];
  const float move = gain * b;
  matrix.rest[lane] = b;
  matrix.x[lane] = moves[slice * slice_stride + 1 + at] = move;
  if (at == 0 && matrix.below[slice] >= 0) moves[matrix.below[slice] * slice_stride + brick_lanes + 1] = move;
  if (at == brick_lanes - 1 && matrix.above[slice] >= 0) moves[matrix.above[slice] * slice_stride] = move;
}

// a step that moves[from] begins; makes moves[1 - from]
void sweep(SlicedEllMatrix& matrix, int from, float momentum, float gain) {
  SliceSweep task;
  task.slices = slices_of(matrix);
  task.move = matrix.moves[from].data(), task.next = matrix.moves[1 - from].data();
  task.rest = matrix.rest.data(), task.x = matrix.x.data();
  task.momentum = momentum, task.gain = gain;
  const MultigridKernels& kernels = multigrid_kernels(matrix.instruction_set);
  parallel_blocks(Eigen::Index(matrix.below.size()), grain,
                  [&](Eigen::Index begin, Eigen::Index end) { kernels.sweep_slices(task, int(begin), int(end)); });
}

}  // namespace

TermLines lines_of(const RankOneTerms& terms) {
  std::vector<std::pair<Place, int>> wanted;  // places and layers
  int most_layers = 1;
  for (const RankOneTerms::Hex& hex : terms.hexes) {
    const Place place = place_of(hex.cell);
    const int lane = hex.cell[2] % brick_lanes, layers = hex.end - hex.first;
    most_layers = std::max(most_layers, layers);
    wanted.emplace_back(place, layers);
    if (lane == 0) wanted.emplace_back(beside(place, 0, 0, -1), layers);
    if (lane == brick_lanes - 1) wanted.emplace_back(beside(place, 0, 0, 1), layers);
  }
  std::sort(wanted.begin(), wanted.end());
  TermLines lines;
  lines.most_layers = most_layers;
  lines.first_slices.push_back(0);
  for (std::size_t i = 0; i < wanted.size(); ++i) {  // of the same place the last one has most layers
    if (i + 1 < wanted.size() && wanted[i + 1].first == wanted[i].first) continue;
    lines.places.push_back(wanted[i].first);
    lines.first_slices.push_back(lines.first_slices.back() + wanted[i].second);
  }
  lines.beside.resize(lines.places.size());
  parallel_blocks(lines.count(), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for (int line = int(begin); line < int(end); ++line)
      for (int d = 0; d < 9; ++d)
        lines.beside[line][d] = line_at(lines, beside(lines.places[line], d / 3 - 1, d % 3 - 1, 0));
  });
  lines.hexes.assign(lines.places.size() * brick_lanes, -1);
  for (std::size_t h = 0; h < terms.hexes.size(); ++h)
    lines.hexes[std::size_t(line_at(lines, place_of(terms.hexes[h].cell))) * brick_lanes +
                std::size_t(terms.hexes[h].cell[2] % brick_lanes)] = int(h);
  return lines;
}

SlicedEllMatrix make_sliced_ell_matrix(const RankOneTerms& terms, const TermLines& lines,
                                       const std::vector<RankOneTerms::Vector24f>& responses, const VectorXf& scale,
                                       InstructionSet instruction_set) {
  SlicedEllMatrix matrix;
  matrix.instruction_set = instruction_set;
  matrix.scale = scale;
  number_slices(terms, lines, matrix);
  set_entries(lines, {shared_corners(), terms, responses, scale}, matrix);
  return matrix;
}

EllSlices slices_of(const SlicedEllMatrix& matrix) {
  return {matrix.below.data(),  matrix.above.data(),   matrix.starts.data(),
          matrix.places.data(), matrix.entries.data(), 1 / entry_scale};
}

Eigen::SparseMatrix<double> lower_triangle(const RankOneTerms& terms, const TermLines& lines,
                                           const std::vector<RankOneTerms::Vector24f>& responses,
                                           const VectorXf& scale) {
  const ScaledEntries all{shared_corners(), terms, responses, scale};
  const auto count = Eigen::Index(scale.size());
  Eigen::SparseMatrix<double> lower(count, count);
  int* const starts = lower.outerIndexPtr();
  // calls visit(t, u, d) for all t of hexes in a block of lines and all u > t near them
  const auto for_each_below = [&](Eigen::Index begin, Eigen::Index end, const auto& visit) {
    for (int line = int(begin); line < int(end); ++line)
      for_each_pair(lines, line, [&](int, int hex, int d, int other) {
        const RankOneTerms::Hex &own = terms.hexes[hex], &near = terms.hexes[other];
        for (int t = own.first; t < own.end; ++t)
          for (int u = std::max(t + 1, near.first); u < near.end; ++u) visit(t, u, d);
      });
  };
  std::fill_n(starts, count + 1, 1);  // the diagonal
  starts[0] = 0;
  parallel_blocks(lines.count(), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for_each_below(begin, end, [&](int t, int, int) { ++starts[t + 1]; });
  });
  std::partial_sum(starts, starts + count + 1, starts);
  lower.resizeNonZeros(starts[count]);
  int* const rows = lower.innerIndexPtr();
  double* const values = lower.valuePtr();
  std::vector<int> next(starts, starts + count);
  for (int t = 0; t < int(count); ++t) rows[next[t]] = t, values[next[t]++] = 1;
  parallel_blocks(lines.count(), grain, [&](Eigen::Index begin, Eigen::Index end) {
    for_each_below(begin, end, [&](int t, int u, int d) {
      int at = next[t]++;
      for (; rows[at - 1] > u; --at) rows[at] = rows[at - 1], values[at] = values[at - 1];
      rows[at] = u, values[at] = double(all.at(t, u, d));
    });
  });
  return lower;
}

VectorXf solve(SlicedEllMatrix& matrix, const ChebyshevOptions& options, const VectorXf& b) {
  ChebyshevRecurrence<float> recurrence(matrix.largest, options.interval);
  const float first_gain = recurrence.first_gain();
  parallel_blocks(b.size(), terms_per_block, [&](Eigen::Index first, Eigen::Index end) {
    for (Eigen::Index t = first; t < end; ++t) begin(matrix, matrix.lanes[t], matrix.scale[t] * b[t], first_gain);
  });
  for (int step = 1; step < options.steps; ++step) {
    const auto [momentum, gain] = recurrence.next();
    sweep(matrix, (step - 1) % 2, momentum, gain);
  }
  VectorXf x(b.size());
  parallel_blocks(x.size(), terms_per_block, [&](Eigen::Index first, Eigen::Index end) {
    for (Eigen::Index t = first; t < end; ++t) x[t] = matrix.scale[t] * matrix.x[matrix.lanes[t]];
  });
  return x;
}

}  // namespace umax
