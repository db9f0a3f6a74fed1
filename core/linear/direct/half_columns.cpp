#include "core/linear/direct/half_columns.h"

#include <algorithm>

namespace umax {
namespace {

// the group that holds each column of the factor, from the first group that is asked for
std::vector<int> group_of_rows(const SupernodalView& factor) {
  std::vector<int> group(std::size_t(factor.starts[factor.num_groups]));
  for (int s = 0; s < factor.num_groups; ++s)
    std::fill(group.begin() + factor.starts[s], group.begin() + factor.starts[s + 1], s);
  return group;
}

void sort_once(std::vector<int>& columns) {
  std::sort(columns.begin(), columns.end());
  columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
}

// solves for the group's rows and takes what they do to the rows below out of the rest; rest: rows from `first_row` on
void eliminate(const SupernodalView& factor, int s, Eigen::Index first_row, MatrixXd& rest, HalfColumns::Group& group) {
  const int size = factor.starts[s + 1] - factor.starts[s], num_rows = factor.row_starts[s + 1] - factor.row_starts[s];
  const Eigen::Map<const MatrixXd> L(factor.values + factor.value_starts[s], num_rows, size);
  const auto count = Eigen::Index(group.columns.size());
  group.values.resize(size, count);
  for (Eigen::Index j = 0; j < count; ++j)
    group.values.col(j) = rest.col(group.columns[j]).segment(factor.starts[s] - first_row, size);
  L.topRows(size).triangularView<Eigen::Lower>().solveInPlace(group.values);
  if (num_rows == size) return;
  const MatrixXd below = L.bottomRows(num_rows - size) * group.values;
  const int* const rows = factor.rows + factor.row_starts[s] + size;
  for (Eigen::Index j = 0; j < count; ++j) {
    double* const column = rest.col(group.columns[j]).data() - first_row;
    for (Eigen::Index i = 0; i < below.rows(); ++i) column[rows[i]] -= below(i, j);
  }
}

}  // namespace

HalfColumns half_solve(const SupernodalView& factor, const std::vector<SparseEntry>& entries, Eigen::Index count) {
  HalfColumns half{std::vector<HalfColumns::Group>(std::size_t(factor.num_groups)), count};
  if (entries.empty()) return half;
  const std::vector<int> group_of = group_of_rows(factor);
  int first = factor.num_groups;
  for (const SparseEntry& entry : entries) first = std::min(first, group_of[entry.row]);
  const Eigen::Index first_row = factor.starts[first], size = factor.starts[factor.num_groups];
  MatrixXd rest = MatrixXd::Zero(size - first_row, count);
  for (const SparseEntry& entry : entries) {
    rest(entry.row - first_row, entry.column) += entry.value;
    half.groups[group_of[entry.row]].columns.push_back(entry.column);
  }
  for (int s = first; s < factor.num_groups; ++s) {
    HalfColumns::Group& group = half.groups[s];
    if (group.columns.empty()) continue;
    sort_once(group.columns);
    eliminate(factor, s, first_row, rest, group);
    const int below = factor.row_starts[s] + factor.starts[s + 1] - factor.starts[s];
    if (below == factor.row_starts[s + 1]) continue;
    std::vector<int>& parents =
        half.groups[group_of[factor.rows[below]]].columns;  // all rows below are above it in the tree
    parents.insert(parents.end(), group.columns.begin(), group.columns.end());
  }
  return half;
}

MatrixXd products(const HalfColumns& a, const HalfColumns& b) {
  MatrixXd sum = MatrixXd::Zero(a.count, b.count);
  for (std::size_t s = 0; s < a.groups.size(); ++s) {
    const HalfColumns::Group &of_a = a.groups[s], &of_b = b.groups[s];
    if (of_a.columns.empty() || of_b.columns.empty()) continue;
    const MatrixXd block = of_a.values.transpose() * of_b.values;
    for (Eigen::Index j = 0; j < block.cols(); ++j)
      for (Eigen::Index i = 0; i < block.rows(); ++i) sum(of_a.columns[i], of_b.columns[j]) += block(i, j);
  }
  return sum;
}

MatrixXd products(const HalfColumns& a) {
  MatrixXd sum = MatrixXd::Zero(a.count, a.count);
  MatrixXd block;
  for (const HalfColumns::Group& group : a.groups) {
    if (group.columns.empty()) continue;
    const Eigen::Index size = group.values.cols();
    block.setZero(size, size);
    block.selfadjointView<Eigen::Lower>().rankUpdate(group.values.transpose());
    for (Eigen::Index j = 0; j < size; ++j)
      for (Eigen::Index i = j; i < size; ++i) sum(group.columns[i], group.columns[j]) += block(i, j);
  }
  sum.triangularView<Eigen::StrictlyUpper>() = sum.transpose();
  return sum;
}

VectorXd products(const SupernodalView& factor, const HalfColumns& half, const Eigen::Ref<const VectorXd>& y) {
  VectorXd sum = VectorXd::Zero(half.count);
  for (std::size_t s = 0; s < half.groups.size(); ++s) {
    const HalfColumns::Group& group = half.groups[s];
    if (group.columns.empty()) continue;
    const VectorXd part = group.values.transpose() * y.segment(factor.starts[s], group.values.rows());
    for (Eigen::Index j = 0; j < part.size(); ++j) sum[group.columns[j]] += part[j];
  }
  return sum;
}

void add_columns(const SupernodalView& factor, const HalfColumns& half, const Eigen::Ref<const VectorXd>& f,
                 Eigen::Ref<VectorXd> y) {
  VectorXd part;
  for (std::size_t s = 0; s < half.groups.size(); ++s) {
    const HalfColumns::Group& group = half.groups[s];
    if (group.columns.empty()) continue;
    part.resize(Eigen::Index(group.columns.size()));
    for (Eigen::Index j = 0; j < part.size(); ++j) part[j] = f[group.columns[j]];
    y.segment(factor.starts[s], group.values.rows()).noalias() += group.values * part;
  }
}

}  // namespace umax
