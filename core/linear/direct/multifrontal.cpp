#include "core/linear/direct/multifrontal.h"

#include <algorithm>
#include <atomic>
#include <memory>

#include "core/base/parallel.h"
#include "core/linear/direct/front_kernel.h"

namespace umax {
namespace {

constexpr double least_shared_work = 3e5;  // [operations] of a subtree whose children go to several threads
constexpr double least_shared_update = 5e5;
constexpr int columns_at_once = 48;  // of an update that is shared

struct Factorisation {
  const FrontTree& tree;
  const SupernodalView& pattern;
  const SystemMatrix& matrix;
  const FrontKernels& kernels;
  double* values;
  std::vector<std::unique_ptr<double[]>> fronts;  // of groups whose front above has not taken them yet
  std::atomic<bool> is_definite = true;

  int num_columns(int group) const { return pattern.starts[group + 1] - pattern.starts[group]; }
  int num_rows(int group) const { return pattern.row_starts[group + 1] - pattern.row_starts[group]; }
};

Front make_front(Factorisation& work, int group) {
  Front front{.values = nullptr, .stride = front_stride(work.num_rows(group)), .size = work.num_rows(group)};
  work.fronts[group] = std::make_unique_for_overwrite<double[]>(front.stride * std::size_t(front.size));
  front.values = work.fronts[group].get();
  for (int j = 0; j < front.size; ++j) {
    double* const column = front.values + std::size_t(j) * front.stride;
    std::fill(column + std::max(0, j - 8), column + front.stride, 0.0);  // kernels read a little above the diagonal
  }
  return front;
}

void add_matrix(const Factorisation& work, int group, const Front& front) {
  const int* row = work.tree.matrix_rows[group].data();
  const int first = work.pattern.starts[group];
  for (int j = 0; j < work.num_columns(group); ++j) {
    double* const column = front.values + std::size_t(j) * front.stride;
    for (int i = work.matrix.column_starts[first + j]; i < work.matrix.column_starts[first + j + 1]; ++i)
      column[*row++] = work.matrix.values[i];
  }
}

/// What is left of a front below.
void add_child(const Factorisation& work, int child, const Front& front) {
  const std::vector<RowRun>& runs = work.tree.runs[child];
  const auto stride = front_stride(work.num_rows(child));
  const double* const values = work.fronts[child].get();
  const auto add = [](const double* from, double* to, int count) {
    for (int i = 0; i < count; ++i) to[i] += from[i];
  };
  for (std::size_t r = 0; r < runs.size(); ++r)
    for (int j = 0; j < runs[r].count; ++j) {
      const double* const from = values + std::size_t(runs[r].from + j) * stride;
      double* const to = front.values + std::size_t(runs[r].to + j) * front.stride;
      add(from + runs[r].from + j, to + runs[r].to + j, runs[r].count - j);
      for (std::size_t below = r + 1; below < runs.size(); ++below)
        add(from + runs[below].from, to + runs[below].to, runs[below].count);
    }
}

void update(const Factorisation& work, const Front& front, int first, int count, int begin) {
  const int left = front.size - begin;
  if (double(count) * left * left < least_shared_update) {
    work.kernels.update(front, first, count, begin, front.size);
    return;
  }
  parallel_blocks(left, columns_at_once, [&](Eigen::Index from, Eigen::Index to) {
    work.kernels.update(front, first, count, begin + int(from), begin + int(to));
  });
}

bool eliminate(const Factorisation& work, const Front& front, int columns) {
  for (int first = 0; first < columns; first += front_panel) {
    const int count = std::min(front_panel, columns - first);
    if (!work.kernels.eliminate(front, first, count)) return false;
    update(work, front, first, count, first + count);
  }
  return true;
}

void factorize_group(Factorisation& work, int group) {
  const Front front = make_front(work, group);
  add_matrix(work, group, front);
  for (const int child : work.tree.children[group]) {
    add_child(work, child, front);
    work.fronts[child].reset();
  }
  const int columns = work.num_columns(group);
  if (!eliminate(work, front, columns)) {
    work.is_definite = false;
    return;
  }
  double* const to = work.values + work.pattern.value_starts[group];
  for (int j = 0; j < columns; ++j) {
    const double* const column = front.values + std::size_t(j) * front.stride;
    std::copy(column + j, column + front.size, to + std::size_t(j) * std::size_t(front.size) + j);
  }
  if (work.tree.parents[group] < 0) work.fronts[group].reset();
}

void factorize_subtree(Factorisation& work, int group) {
  const std::vector<int>& children = work.tree.children[group];
  const auto below = [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) factorize_subtree(work, children[std::size_t(i)]);
  };
  const auto count = Eigen::Index(children.size());
  if (work.tree.work[std::size_t(group)] < least_shared_work)
    below(0, count);
  else
    parallel_blocks(count, 1, below);
  if (work.is_definite) factorize_group(work, group);
}

std::vector<RowRun> runs_of(const std::vector<int>& above, int first) {
  std::vector<RowRun> runs;
  for (std::size_t i = 0; i < above.size(); ++i)
    if (i > 0 && above[i] == above[i - 1] + 1)
      ++runs.back().count;
    else
      runs.push_back({.from = first + int(i), .to = above[i], .count = 1});
  return runs;
}

// where each of `rows` (ascending) stands among `all` (ascending)
std::vector<int> places(const int* rows, const int* rows_end, const int* all) {
  std::vector<int> found;
  const int* at = all;
  for (; rows != rows_end; ++rows) {
    while (*at != *rows) ++at;
    found.push_back(int(at - all));
  }
  return found;
}

}  // namespace

FrontTree make_front_tree(const SupernodalView& pattern, const SystemMatrix& matrix) {
  const auto count = std::size_t(pattern.num_groups);
  FrontTree tree{.parents = std::vector<int>(count, -1),
                 .children = std::vector<std::vector<int>>(count),
                 .runs = std::vector<std::vector<RowRun>>(count),
                 .matrix_rows = std::vector<std::vector<int>>(count),
                 .work = std::vector<double>(count, 0)};
  std::vector<int> group_of(std::size_t(matrix.num_unknowns()));
  for (int g = 0; g < pattern.num_groups; ++g)
    for (int c = pattern.starts[g]; c < pattern.starts[g + 1]; ++c) group_of[std::size_t(c)] = g;
  for (int g = 0; g < pattern.num_groups; ++g) {
    const int* const rows = pattern.rows + pattern.row_starts[g];
    const int* const rows_end = pattern.rows + pattern.row_starts[g + 1];
    const int columns = pattern.starts[g + 1] - pattern.starts[g];
    for (int c = pattern.starts[g]; c < pattern.starts[g + 1]; ++c) {
      const std::vector<int> in_column = places(matrix.row_indices.data() + matrix.column_starts[c],
                                                matrix.row_indices.data() + matrix.column_starts[c + 1], rows);
      tree.matrix_rows[g].insert(tree.matrix_rows[g].end(), in_column.begin(), in_column.end());
    }
    for (double left = double(rows_end - rows); left > double(rows_end - rows - columns); --left)
      tree.work[g] += left * left;
    if (rows + columns == rows_end) continue;
    const int above = group_of[std::size_t(rows[columns])];
    tree.parents[g] = above;
    tree.children[above].push_back(g);
    tree.runs[g] = runs_of(places(rows + columns, rows_end, pattern.rows + pattern.row_starts[above]), columns);
    tree.work[above] += tree.work[g];
  }
  return tree;
}

bool factorize(const FrontTree& tree, const SupernodalView& pattern, const SystemMatrix& matrix, double* values) {
  Factorisation work{.tree = tree,
                     .pattern = pattern,
                     .matrix = matrix,
                     .kernels = front_kernels(best_instruction_set()),
                     .values = values,
                     .fronts = std::vector<std::unique_ptr<double[]>>(std::size_t(pattern.num_groups))};
  for (int group = 0; group < pattern.num_groups; ++group)
    if (tree.parents[std::size_t(group)] < 0) factorize_subtree(work, group);
  // which groups came to their turn depends on the threads
  if (!work.is_definite) std::fill(values, values + pattern.value_starts[pattern.num_groups], 0.0);
  return work.is_definite;
}

}  // namespace umax
