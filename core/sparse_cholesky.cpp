#include "core/sparse_cholesky.h"

#include <cholmod.h>
#include <dlfcn.h>

#include <algorithm>
#include <new>
#include <stdexcept>

#include "core/parallel.h"

namespace umax {
namespace {

// nested dissection pays from here on; below, minimum degree analyses faster
constexpr int nested_dissection_nodes = 2000;
constexpr Eigen::Index columns_per_block = 48;

// While one lives, CHOLMOD's OpenMP regions run on the calling thread: its fixed four threads spin against TBB's (2121
// unknowns on 2 cores: 10.0 ms of processor time a step with them, 5.9 ms without). The runtime is whichever the
// installed CHOLMOD has loaded.
class SerialOpenMp {
 public:
  SerialOpenMp() {
    if (get_levels && set_levels) levels_ = get_levels(), set_levels(0);
  }
  ~SerialOpenMp() {
    if (get_levels && set_levels) set_levels(levels_);
  }
  SerialOpenMp(const SerialOpenMp&) = delete;
  SerialOpenMp& operator=(const SerialOpenMp&) = delete;

 private:
  static inline const auto get_levels = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "omp_get_max_active_levels"));
  static inline const auto set_levels =
      reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"));
  int levels_ = 1;
};

// which nodes share an entry of the matrix: lower triangle, compressed columns
struct NodeGraph {
  std::vector<int> column_starts{0}, row_indices;
};

NodeGraph node_graph(const SystemMatrix& matrix) {
  NodeGraph graph;
  for (int column = 0; column < matrix.num_unknowns(); column += 3) {
    // rows: what is left of the node's own block, then three of each later neighbour
    for (int k = matrix.column_starts[column]; k < matrix.column_starts[column + 1]; k += 3)
      graph.row_indices.push_back(matrix.row_indices[k] / 3);
    graph.column_starts.push_back(int(graph.row_indices.size()));
  }
  return graph;
}

cholmod_sparse symmetric_view(const std::vector<int>& column_starts, const std::vector<int>& row_indices,
                              const double* values) {
  cholmod_sparse view{};
  view.nrow = view.ncol = column_starts.size() - 1;
  view.nzmax = row_indices.size();
  view.p = const_cast<int*>(column_starts.data());
  view.i = const_cast<int*>(row_indices.data());
  view.x = const_cast<double*>(values);
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.xtype = values ? CHOLMOD_REAL : CHOLMOD_PATTERN;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = view.packed = 1;
  return view;
}

// fill-reducing order of the nodes, those in `last` (ascending) after all others
std::vector<int> order_nodes(const SystemMatrix& matrix, const std::vector<int>& last, cholmod_common& common) {
  const NodeGraph graph = node_graph(matrix);
  cholmod_sparse view = symmetric_view(graph.column_starts, graph.row_indices, nullptr);
  std::vector<int> order(view.ncol);
  const bool done = int(view.ncol) < nested_dissection_nodes
                        ? cholmod_amd(&view, nullptr, 0, order.data(), &common)
                        : cholmod_metis(&view, nullptr, 0, true, order.data(), &common);
  if (!done) throw std::bad_alloc();
  std::stable_partition(order.begin(), order.end(),
                        [&](int node) { return !std::binary_search(last.begin(), last.end(), node); });
  return order;
}

}  // namespace

struct SparseCholesky::Data {
  cholmod_common common{};
  cholmod_factor* factor = nullptr;
  std::vector<int> last;       // nodes eliminated last, ascending
  std::vector<int> last_rows;  // #N, see last_row()
  MatrixXd last_factor;        // lower triangle: the factor's rows and columns of the unknowns eliminated last
  // buffers that cholmod_solve2 grows once and reuses
  cholmod_dense *solution = nullptr, *work_y = nullptr, *work_e = nullptr;

  Data() {
    cholmod_start(&common);
    common.supernodal = CHOLMOD_SUPERNODAL;
    common.print = 0;
    common.quick_return_if_not_posdef = 1;
    common.error_handler = nullptr;
  }
  ~Data() {
    cholmod_free_dense(&solution, &common);
    cholmod_free_dense(&work_y, &common);
    cholmod_free_dense(&work_e, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;
};

SparseCholesky::SparseCholesky() : data_(std::make_unique<Data>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;

void SparseCholesky::eliminate_last(std::vector<int> nodes) {
  if (nodes == data_->last) return;
  data_->last = std::move(nodes);
  cholmod_free_factor(&data_->factor, &data_->common);
}

void SparseCholesky::analyse(const SystemMatrix& matrix) {
  cholmod_common& common = data_->common;
  const std::vector<int> nodes = order_nodes(matrix, data_->last, common);
  std::vector<int> unknowns;
  for (const int node : nodes)
    for (int axis = 0; axis < 3; ++axis) unknowns.push_back(3 * node + axis);
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_GIVEN;
  common.postorder = 1;
  cholmod_sparse view = symmetric_view(matrix.column_starts, matrix.row_indices, matrix.values.data());
  data_->factor = cholmod_analyze_p(&view, unknowns.data(), nullptr, 0, &common);
  if (!data_->factor) throw std::bad_alloc();
}

bool SparseCholesky::factorize(const SystemMatrix& matrix) {
  const SerialOpenMp serial;
  cholmod_common& common = data_->common;
  if (!data_->factor) analyse(matrix);
  cholmod_sparse view = symmetric_view(matrix.column_starts, matrix.row_indices, matrix.values.data());
  cholmod_factorize(&view, data_->factor, &common);
  if (common.status == CHOLMOD_OUT_OF_MEMORY || common.status == CHOLMOD_TOO_LARGE) throw std::bad_alloc();
  if (common.status != CHOLMOD_OK) return false;
  extract_last();
  return true;
}

// All ancestors of an unknown eliminated last are such unknowns, so their rows and columns of L are a factor by
// themselves: of the Schur complement.
void SparseCholesky::extract_last() {
  if (data_->last.empty()) return;
  const cholmod_factor& factor = *data_->factor;
  const int* const order = static_cast<const int*>(factor.Perm);
  std::vector<int> position(factor.n), slot(factor.n, -1);
  for (std::size_t i = 0; i < factor.n; ++i) position[order[i]] = int(i);
  std::vector<int> positions;
  for (const int node : data_->last)
    for (int axis = 0; axis < 3; ++axis) positions.push_back(position[3 * node + axis]);
  std::vector<int> sorted = positions;
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < sorted.size(); ++i) slot[sorted[i]] = int(i);
  data_->last_rows.assign(factor.n, -1);
  for (std::size_t k = 0; k < positions.size(); ++k)
    data_->last_rows[3 * data_->last[k / 3] + k % 3] = slot[positions[k]];

  const int *const super = static_cast<const int*>(factor.super), *const pi = static_cast<const int*>(factor.pi);
  const int *const px = static_cast<const int*>(factor.px), *const rows = static_cast<const int*>(factor.s);
  const double* const values = static_cast<const double*>(factor.x);
  data_->last_factor.setZero(Eigen::Index(sorted.size()), Eigen::Index(sorted.size()));
  for (std::size_t s = 0; s < factor.nsuper; ++s) {
    const int num_rows = pi[s + 1] - pi[s];
    for (int column = super[s]; column < super[s + 1]; ++column) {
      if (slot[column] < 0) continue;
      const int first = column - super[s];
      const double* const entries = values + px[s] + std::ptrdiff_t(first) * num_rows;
      for (int i = first; i < num_rows; ++i) data_->last_factor(slot[rows[pi[s] + i]], slot[column]) = entries[i];
    }
  }
}

int SparseCholesky::num_last() const {
  return 3 * int(data_->last.size());
}

int SparseCholesky::last_row(int node, int axis) const {
  return data_->last.empty() ? -1 : data_->last_rows[3 * node + axis];
}

void SparseCholesky::half_solve_last(Eigen::Ref<MatrixXd, 0, Eigen::OuterStride<>> columns) const {
  parallel_blocks(columns.cols(), columns_per_block, [&](Eigen::Index begin, Eigen::Index end) {
    auto block = columns.middleCols(begin, end - begin);
    data_->last_factor.triangularView<Eigen::Lower>().solveInPlace(block);
  });
}

void SparseCholesky::solve(Eigen::Ref<MatrixXd, 0, Eigen::OuterStride<>> columns) const {
  solve_in_place(CHOLMOD_A, columns);
}

void SparseCholesky::half_solve(Eigen::Ref<MatrixXd, 0, Eigen::OuterStride<>> columns) const {
  solve_in_place(CHOLMOD_P, columns);
  solve_in_place(CHOLMOD_L, columns);
}

void SparseCholesky::solve_in_place(int system, Eigen::Ref<MatrixXd, 0, Eigen::OuterStride<>> columns) const {
  if (columns.cols() == 0) return;
  cholmod_dense view{};
  view.nrow = std::size_t(columns.rows());
  view.ncol = std::size_t(columns.cols());
  view.d = std::size_t(columns.outerStride());
  view.nzmax = view.d * view.ncol;
  view.x = columns.data();
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  const SerialOpenMp serial;
  if (!cholmod_solve2(system, data_->factor, &view, nullptr, &data_->solution, nullptr, &data_->work_y, &data_->work_e,
                      &data_->common))
    throw std::runtime_error("the sparse solver failed to solve with its factor");
  const Eigen::Map<const MatrixXd, 0, Eigen::OuterStride<>> solution(
      static_cast<const double*>(data_->solution->x), columns.rows(), columns.cols(),
      Eigen::OuterStride<>(Eigen::Index(data_->solution->d)));
  columns = solution;
}

}  // namespace umax
