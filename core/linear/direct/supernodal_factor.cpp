#include "core/linear/direct/supernodal_factor.h"

#include <algorithm>
#include <utility>

#include "core/base/parallel.h"
#include "core/linear/direct/sparse_cholesky.h"

namespace umax {
namespace {

constexpr std::size_t num_subtrees = 16;  // about: of equal work, as far as the tree has them
constexpr std::size_t small = 30000;      // numbers in a factor that is solved with sooner than threads are woken

using Supernode = SupernodalFactor::Supernode;
using Block = Eigen::Map<const Eigen::MatrixXf>;

Block inverse_of(const SupernodalFactor& factor, const Supernode& node) {
  return {factor.values.data() + node.values, node.size, node.size};
}

Block below(const SupernodalFactor& factor, const Supernode& node) {
  return {factor.values.data() + node.values + std::size_t(node.size) * std::size_t(node.size), node.rows, node.size};
}

void copy_supernodes(const SupernodalColumns& from, SupernodalFactor& to) {
  to.order = from.order;
  std::size_t size = 0;
  for (int s = 0; s + 1 < int(from.starts.size()); ++s) {
    Supernode node;
    node.first = from.starts[s];
    node.size = from.starts[s + 1] - node.first;
    node.rows = from.row_starts[s + 1] - from.row_starts[s] - node.size;
    node.rows_first = int(to.row_indices.size());
    node.values = size;
    to.row_indices.insert(to.row_indices.end(), from.rows.begin() + from.row_starts[s] + node.size,
                          from.rows.begin() + from.row_starts[s + 1]);
    size += std::size_t(node.size) * std::size_t(node.size + node.rows);
    to.supernodes.push_back(node);
  }
  to.values.resize(size);
  parallel_blocks(Eigen::Index(to.supernodes.size()), 16, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index s = begin; s < end; ++s) {
      const Supernode& node = to.supernodes[s];
      const Eigen::Map<const MatrixXd> L(from.values.data() + from.value_starts[s], node.size + node.rows, node.size);
      Eigen::Map<Eigen::MatrixXf> inverse(to.values.data() + node.values, node.size, node.size);
      Eigen::Map<Eigen::MatrixXf> rest(inverse.data() + inverse.size(), node.rows, node.size);
      inverse =
          MatrixXd(L.topRows(node.size).triangularView<Eigen::Lower>().solve(MatrixXd::Identity(node.size, node.size)))
              .cast<float>();
      rest = L.bottomRows(node.rows).cast<float>();
    }
  });
}

// Splits the tree at its heaviest nodes until about num_subtrees of equal work are left below them.
void find_subtrees(SupernodalFactor& factor) {
  const int count = int(factor.supernodes.size());
  std::vector<int> of_column(factor.order.size()), first(count);
  std::vector<std::vector<int>> children(count);
  std::vector<std::size_t> work(count, 0);
  for (int s = 0; s < count; ++s)
    for (int c = 0; c < factor.supernodes[s].size; ++c) of_column[factor.supernodes[s].first + c] = s;
  std::vector<int> heads;  // of subtrees
  for (int s = 0; s < count; ++s) {
    const Supernode& node = factor.supernodes[s];
    first[s] = children[s].empty() ? s : first[children[s].front()];
    work[s] += std::size_t(node.size) * std::size_t(node.size + node.rows);
    if (node.rows == 0) {
      heads.push_back(s);
      continue;
    }
    const int above = of_column[factor.row_indices[node.rows_first]];
    children[above].push_back(s);
    work[above] += work[s];
  }
  std::size_t all = 0;
  for (const int head : heads) all += work[head];
  const auto heaviest = [&] {
    return std::max_element(heads.begin(), heads.end(), [&](int a, int b) { return work[a] < work[b]; });
  };
  for (auto at = heaviest(); at != heads.end() && work[*at] * num_subtrees > all; at = heaviest()) {
    const int split = *at;
    heads.erase(at);
    factor.top.push_back(split);
    heads.insert(heads.end(), children[split].begin(), children[split].end());
  }
  std::sort(heads.begin(), heads.end());
  std::sort(factor.top.begin(), factor.top.end());
  for (const int head : heads) factor.subtrees.emplace_back(first[head], head + 1);
  factor.top_index.assign(factor.order.size(), -1);
  for (const int s : factor.top)
    for (int c = 0; c < factor.supernodes[s].size; ++c)
      factor.top_index[factor.supernodes[s].first + c] = factor.num_top++;
}

// y_1 into x, the update of the rows below into `update`
void eliminate(const SupernodalFactor& factor, const Supernode& node, Eigen::VectorXf& x, Eigen::VectorXf& update) {
  const Eigen::VectorXf y = inverse_of(factor, node).triangularView<Eigen::Lower>() * x.segment(node.first, node.size);
  x.segment(node.first, node.size) = y;
  update.noalias() = below(factor, node) * y;
}

void substitute(const SupernodalFactor& factor, const Supernode& node, Eigen::VectorXf& x, Eigen::VectorXf& known) {
  known.resize(node.rows);
  for (int i = 0; i < node.rows; ++i) known[i] = x[factor.row_indices[node.rows_first + i]];
  Eigen::VectorXf y = x.segment(node.first, node.size);
  y.noalias() -= below(factor, node).transpose() * known;
  x.segment(node.first, node.size) = inverse_of(factor, node).transpose().triangularView<Eigen::Upper>() * y;
}

}  // namespace

bool factorize(const Eigen::SparseMatrix<double>& lower, std::vector<int> order, SupernodalFactor& factor) {
  factor = {};
  SupernodalColumns columns;
  if (!factorize(lower, std::move(order), columns)) return false;
  copy_supernodes(columns, factor);
  find_subtrees(factor);
  return true;
}

VectorXd solve(const SupernodalFactor& factor, const VectorXd& b) {
  const auto count = Eigen::Index(factor.order.size());
  Eigen::VectorXf x(count);
  for (Eigen::Index i = 0; i < count; ++i) x[i] = float(b[factor.order[i]]);

  const auto subtrees = Eigen::Index(factor.subtrees.size());
  const Eigen::Index grain = factor.values.size() < small ? std::max<Eigen::Index>(1, subtrees) : 1;
  Eigen::MatrixXf to_top = Eigen::MatrixXf::Zero(factor.num_top, subtrees);
  parallel_blocks(subtrees, grain, [&](Eigen::Index begin, Eigen::Index end) {
    Eigen::VectorXf update;
    for (Eigen::Index t = begin; t < end; ++t)
      for (int s = factor.subtrees[t].first; s < factor.subtrees[t].second; ++s) {
        const Supernode& node = factor.supernodes[s];
        eliminate(factor, node, x, update);
        for (int i = 0; i < node.rows; ++i) {
          const int row = factor.row_indices[node.rows_first + i];
          (factor.top_index[row] < 0 ? x[row] : to_top(factor.top_index[row], t)) -= update[i];
        }
      }
  });
  Eigen::VectorXf update;
  for (Eigen::Index i = 0; i < count; ++i)
    if (const int top = factor.top_index[i]; top >= 0) x[i] += to_top.row(top).sum();
  for (const int s : factor.top) {
    const Supernode& node = factor.supernodes[s];
    eliminate(factor, node, x, update);
    for (int i = 0; i < node.rows; ++i) x[factor.row_indices[node.rows_first + i]] -= update[i];
  }
  for (auto s = factor.top.rbegin(); s != factor.top.rend(); ++s) substitute(factor, factor.supernodes[*s], x, update);
  parallel_blocks(subtrees, grain, [&](Eigen::Index begin, Eigen::Index end) {
    Eigen::VectorXf known;
    for (Eigen::Index t = begin; t < end; ++t)
      for (int s = factor.subtrees[t].second - 1; s >= factor.subtrees[t].first; --s)
        substitute(factor, factor.supernodes[s], x, known);
  });

  VectorXd solution(count);
  for (Eigen::Index i = 0; i < count; ++i) solution[factor.order[i]] = double(x[i]);
  return solution;
}

}  // namespace umax
