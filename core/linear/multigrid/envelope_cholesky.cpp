#include "core/linear/multigrid/envelope_cholesky.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

namespace umax {
namespace {

constexpr Eigen::Index block_columns = 24;  // of 8 nodes: fewer make small products, more reach far below

struct Block {
  Eigen::Index first, size, below;  // columns; rows below them that are not zero
};

Block block_at(const EnvelopeCholesky& factor, Eigen::Index b) {
  const Eigen::Index first = b * block_columns, size = std::min(block_columns, factor.L.cols() - first);
  return {first, size, factor.ends[std::size_t(b)] - first - size};
}

}  // namespace

EnvelopeCholesky make_envelope_cholesky(MatrixXd A) {
  EnvelopeCholesky factor;
  factor.L = std::move(A);
  MatrixXd& L = factor.L;
  Eigen::Index end = 0;
  for (Eigen::Index first = 0; first < L.cols(); first += block_columns) {
    const Eigen::Index next = std::min(first + block_columns, L.cols());
    end = std::max(end, next);
    for (Eigen::Index column = first; column < next; ++column)
      for (Eigen::Index row = L.rows(); row > end; --row)
        if (L(row - 1, column) != 0) end = row;
    factor.ends.push_back(end);
  }
  for (Eigen::Index b = 0; b < Eigen::Index(factor.ends.size()) && factor.is_definite; ++b) {
    const auto [first, size, below] = block_at(factor, b);
    auto square = L.block(first, first, size, size), panel = L.block(first + size, first, below, size);
    const Eigen::LLT<Eigen::Ref<MatrixXd>> own(square);
    factor.is_definite = own.info() == Eigen::Success;
    square.triangularView<Eigen::Lower>().transpose().solveInPlace<Eigen::OnTheRight>(panel);
    L.block(first + size, first + size, below, below).selfadjointView<Eigen::Lower>().rankUpdate(panel, -1);
  }
  return factor;
}

void solve_lower(const EnvelopeCholesky& factor, Eigen::Ref<MatrixXd> x, Eigen::Index first_row) {
  for (Eigen::Index b = first_row / block_columns; b < Eigen::Index(factor.ends.size()); ++b) {
    const auto [first, size, below] = block_at(factor, b);
    auto own = x.middleRows(first, size);
    factor.L.block(first, first, size, size).triangularView<Eigen::Lower>().solveInPlace(own);
    x.middleRows(first + size, below).noalias() -= factor.L.block(first + size, first, below, size) * own;
  }
}

void solve_upper(const EnvelopeCholesky& factor, Eigen::Ref<MatrixXd> x) {
  for (Eigen::Index b = Eigen::Index(factor.ends.size()) - 1; b >= 0; --b) {
    const auto [first, size, below] = block_at(factor, b);
    auto own = x.middleRows(first, size);
    own.noalias() -= factor.L.block(first + size, first, below, size).transpose() * x.middleRows(first + size, below);
    factor.L.block(first, first, size, size).triangularView<Eigen::Lower>().transpose().solveInPlace(own);
  }
}

}  // namespace umax
