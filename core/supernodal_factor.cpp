#include "core/supernodal_factor.h"

#include <cholmod.h>

#include <Eigen/CholmodSupport>
#include <algorithm>
#include <new>

#include "core/parallel.h"
#include "core/serial_openmp.h"

namespace umax {
namespace {

constexpr std::size_t num_subtrees = 16;  // about: of equal work, as far as the tree has them

using Supernode = SupernodalFactor::Supernode;
using Block = Eigen::Map<const Eigen::MatrixXf>;

Block inverse_of(const SupernodalFactor& factor, const Supernode& node) {
  return {factor.values.data() + node.values, node.size, node.size};
}

Block below(const SupernodalFactor& factor, const Supernode& node) {
  return {factor.values.data() + node.values + std::size_t(node.size) * std::size_t(node.size), node.rows, node.size};
}

// CHOLMOD's factor and what belongs to it
struct DoubleFactor {
  cholmod_common common{};
  cholmod_factor* factor = nullptr;
  DoubleFactor() {
    cholmod_start(&common);
    common.print = 0;
    common.error_handler = nullptr;
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.quick_return_if_not_posdef = 1;
    common.nmethods = 1;
  }
  ~DoubleFactor() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  DoubleFactor(const DoubleFactor&) = delete;
  DoubleFactor& operator=(const DoubleFactor&) = delete;
};

void copy_supernodes(const cholmod_factor& from, SupernodalFactor& to) {
  const int *const super = static_cast<const int*>(from.super), *const pi = static_cast<const int*>(from.pi);
  const int *const px = static_cast<const int*>(from.px), *const rows = static_cast<const int*>(from.s);
  const double* const x = static_cast<const double*>(from.x);
  const int* const order = static_cast<const int*>(from.Perm);
  to.order.assign(order, order + from.n);
  std::size_t size = 0;
  for (int s = 0; s < int(from.nsuper); ++s) {
    Supernode node;
    node.first = super[s];
    node.size = super[s + 1] - super[s];
    node.rows = pi[s + 1] - pi[s] - node.size;
    node.rows_first = int(to.row_indices.size());
    node.values = size;
    to.row_indices.insert(to.row_indices.end(), rows + pi[s] + node.size, rows + pi[s + 1]);
    size += std::size_t(node.size) * std::size_t(node.size + node.rows);
    to.supernodes.push_back(node);
  }
  to.values.resize(size);
  parallel_blocks(Eigen::Index(to.supernodes.size()), 16, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index s = begin; s < end; ++s) {
      const Supernode& node = to.supernodes[s];
      const Eigen::Map<const MatrixXd> L(x + px[s], node.size + node.rows, node.size);
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
  const SerialOpenMp serial;
  DoubleFactor with;
  with.common.method[0].ordering = CHOLMOD_GIVEN;
  const auto view = lower.selfadjointView<Eigen::Lower>();
  cholmod_sparse matrix = Eigen::viewAsCholmod(view);
  with.factor = cholmod_analyze_p(&matrix, order.data(), nullptr, 0, &with.common);
  if (with.factor) cholmod_factorize(&matrix, with.factor, &with.common);
  if (with.common.status == CHOLMOD_OUT_OF_MEMORY || with.common.status == CHOLMOD_TOO_LARGE) throw std::bad_alloc();
  if (!with.factor || with.common.status != CHOLMOD_OK) return false;
  copy_supernodes(*with.factor, factor);
  find_subtrees(factor);
  return true;
}

VectorXd solve(const SupernodalFactor& factor, const VectorXd& b) {
  const auto count = Eigen::Index(factor.order.size());
  Eigen::VectorXf x(count);
  for (Eigen::Index i = 0; i < count; ++i) x[i] = float(b[factor.order[i]]);

  const auto subtrees = Eigen::Index(factor.subtrees.size());
  Eigen::MatrixXf to_top = Eigen::MatrixXf::Zero(factor.num_top, subtrees);
  parallel_blocks(subtrees, 1, [&](Eigen::Index begin, Eigen::Index end) {
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
  parallel_blocks(subtrees, 1, [&](Eigen::Index begin, Eigen::Index end) {
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
