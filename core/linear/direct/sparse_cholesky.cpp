#include "core/linear/direct/sparse_cholesky.h"

#include <cholmod.h>
#include <dlfcn.h>

#include <algorithm>
#include <mutex>
#include <new>
#include <stdexcept>

#include "core/base/parallel.h"
#include "core/linear/direct/multifrontal.h"

namespace umax {
namespace {

// nested dissection pays from here on; below, minimum degree does as well and is found faster
constexpr int nested_dissection_nodes = 2000;

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

// While one lives, calls of OpenBLAS use one thread each: how it shares out a product among several changes the last bits.
// Afterwards it uses as many as it did, for whoever else there is in the process.
class OneBlasThread {
 public:
  OneBlasThread() {
    const std::lock_guard lock(mutex);
    if (users++ == 0 && get_threads && set_threads) before = get_threads(), set_threads(1);
  }
  ~OneBlasThread() {
    const std::lock_guard lock(mutex);
    if (--users == 0 && get_threads && set_threads) set_threads(before);
  }
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;

 private:
  static inline const auto get_threads = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  static inline const auto set_threads =
      reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  static inline std::mutex mutex;
  static inline int users = 0, before = 1;
};

// May several threads call the BLAS at once? Not unless it says so.
bool blas_is_reentrant() {
  static const auto get_parallel = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_parallel"));
  return get_parallel && get_parallel() != 0;
}

// the lower triangle in compressed columns, as a view
cholmod_sparse lower_triangle(std::size_t size, std::size_t entries, const int* column_starts, const int* rows,
                              const double* values) {
  cholmod_sparse view{};
  view.nrow = view.ncol = size;
  view.nzmax = entries;
  view.p = const_cast<int*>(column_starts);
  view.i = const_cast<int*>(rows);
  view.x = const_cast<double*>(values);
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = view.packed = 1;
  return view;
}

// METIS draws from the process's only sequence of random numbers, which it begins anew, and has SIGTERM and SIGABRT for
// itself until it ends: of two calls at once each would find another order, and what was there before would not come back.
bool order_by_nested_dissection(cholmod_sparse& graph, std::vector<int>& order, cholmod_common& common) {
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  return cholmod_metis(&graph, nullptr, 0, true, order.data(), &common);
}

cholmod_sparse lower_triangle(const SystemMatrix& matrix) {
  return lower_triangle(std::size_t(matrix.num_unknowns()), matrix.row_indices.size(), matrix.column_starts.data(),
                        matrix.row_indices.data(), matrix.values.data());
}

// node by node from their own order into that of elimination, and back
MatrixXd in_elimination_order(const std::vector<int>& order, const Eigen::Ref<const MatrixXd>& columns) {
  MatrixXd ordered(columns.rows(), columns.cols());
  for (Eigen::Index c = 0; c < columns.cols(); ++c)
    for (std::size_t rank = 0; rank < order.size(); ++rank)
      ordered.col(c).segment<3>(3 * Eigen::Index(rank)) = columns.col(c).segment<3>(3 * order[rank]);
  return ordered;
}
void into_own_order(const std::vector<int>& order, const Eigen::Ref<const MatrixXd>& ordered,
                    Eigen::Ref<MatrixXd, 0, Eigen::OuterStride<>> columns) {
  for (Eigen::Index c = 0; c < columns.cols(); ++c)
    for (std::size_t rank = 0; rank < order.size(); ++rank)
      columns.col(c).segment<3>(3 * order[rank]) = ordered.col(c).segment<3>(3 * Eigen::Index(rank));
}

}  // namespace

std::vector<int> elimination_order(const Hexes& hexes, Eigen::Index num_nodes, const std::vector<int>& last) {
  std::vector<int> column_starts{0}, row_indices;
  for (const std::vector<int>& list : later_neighbours(hexes, num_nodes)) {
    row_indices.insert(row_indices.end(), list.begin(), list.end());
    column_starts.push_back(int(row_indices.size()));
  }
  cholmod_sparse graph{};  // of the nodes, lower triangle
  graph.nrow = graph.ncol = std::size_t(num_nodes);
  graph.nzmax = row_indices.size();
  graph.p = column_starts.data();
  graph.i = row_indices.data();
  graph.stype = -1;
  graph.itype = CHOLMOD_INT;
  graph.xtype = CHOLMOD_PATTERN;
  graph.sorted = graph.packed = 1;

  cholmod_common common{};
  cholmod_start(&common);
  common.print = 0;
  common.error_handler = nullptr;
  std::vector<int> order(graph.ncol);
  const bool ordered = num_nodes < nested_dissection_nodes ? cholmod_amd(&graph, nullptr, 0, order.data(), &common)
                                                           : order_by_nested_dissection(graph, order, common);
  std::stable_partition(order.begin(), order.end(),
                        [&](int node) { return !std::binary_search(last.begin(), last.end(), node); });
  // the symbolic factor's own order is the postordered one
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_GIVEN;
  common.postorder = 1;
  common.supernodal = CHOLMOD_SIMPLICIAL;
  cholmod_factor* factor = ordered ? cholmod_analyze_p(&graph, order.data(), nullptr, 0, &common) : nullptr;
  if (factor) std::copy_n(static_cast<const int*>(factor->Perm), order.size(), order.begin());
  const bool done = factor != nullptr;
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
  if (!done) throw std::bad_alloc();
  return order;
}

bool factorize(const Eigen::SparseMatrix<double>& lower, std::vector<int> order, SupernodalColumns& columns) {
  cholmod_sparse matrix = lower_triangle(std::size_t(lower.rows()), std::size_t(lower.nonZeros()),
                                         lower.outerIndexPtr(), lower.innerIndexPtr(), lower.valuePtr());
  const SerialOpenMp serial;
  const OneBlasThread one_thread;
  cholmod_common common{};
  cholmod_start(&common);
  common.print = 0;
  common.error_handler = nullptr;
  common.supernodal = CHOLMOD_SUPERNODAL;
  common.quick_return_if_not_posdef = 1;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_GIVEN;
  cholmod_factor* factor = cholmod_analyze_p(&matrix, order.data(), nullptr, 0, &common);
  if (factor) cholmod_factorize(&matrix, factor, &common);
  const bool no_memory = common.status == CHOLMOD_OUT_OF_MEMORY || common.status == CHOLMOD_TOO_LARGE;
  const bool done = factor && common.status == CHOLMOD_OK;
  if (done) {
    const auto copy = [](const void* from, std::size_t count, auto& to) {
      const auto* const first = static_cast<const typename std::decay_t<decltype(to)>::value_type*>(from);
      to.assign(first, first + count);
    };
    copy(factor->Perm, factor->n, columns.order);
    copy(factor->super, factor->nsuper + 1, columns.starts);
    copy(factor->pi, factor->nsuper + 1, columns.row_starts);
    copy(factor->px, factor->nsuper + 1, columns.value_starts);
    copy(factor->s, factor->ssize, columns.rows);
    copy(factor->x, factor->xsize, columns.values);
  }
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
  if (no_memory) throw std::bad_alloc();
  return done;
}

void for_each_solve(Eigen::Index count, const std::function<void(Eigen::Index)>& visit) {
  if (blas_is_reentrant()) return parallel_in_order(count, visit);
  for (Eigen::Index i = 0; i < count; ++i) visit(i);
}

struct SparseCholesky::Data {
  cholmod_common common{};
  cholmod_factor* factor = nullptr;
  FrontTree fronts;
  std::vector<int> order;  // node at each rank
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
  // of columns in elimination order: by L L^T, L or L^T (CHOLMOD_A, _L, _Lt); valid until the next one
  Eigen::Map<const MatrixXd> solve(int system, MatrixXd& ordered);
  Data(const Data&) = delete;
  Data& operator=(const Data&) = delete;
};

SparseCholesky::SparseCholesky() : data_(std::make_unique<Data>()) {}
SparseCholesky::~SparseCholesky() = default;
SparseCholesky::SparseCholesky(SparseCholesky&&) noexcept = default;
SparseCholesky& SparseCholesky::operator=(SparseCholesky&&) noexcept = default;

void SparseCholesky::analyse(const SystemMatrix& matrix) {
  data_->order = matrix.order;
  // the matrix stands in elimination order already: no permutation, no transposed copy at every factorisation
  cholmod_common& common = data_->common;
  common.nmethods = 1;
  common.method[0].ordering = CHOLMOD_NATURAL;
  common.postorder = 0;
  cholmod_sparse view = lower_triangle(matrix);
  data_->factor = cholmod_analyze(&view, &common);
  // room for its numbers
  if (!data_->factor || !cholmod_change_factor(CHOLMOD_REAL, true, true, true, true, data_->factor, &common))
    throw std::bad_alloc();
  data_->fronts = make_front_tree(columns(), matrix);
}

bool SparseCholesky::factorize(const SystemMatrix& matrix) {
  if (!data_->factor) analyse(matrix);
  return umax::factorize(data_->fronts, columns(), matrix, static_cast<double*>(data_->factor->x));
}

SupernodalView SparseCholesky::columns() const {
  const cholmod_factor& factor = *data_->factor;
  return {int(factor.nsuper),
          static_cast<const int*>(factor.super),
          static_cast<const int*>(factor.pi),
          static_cast<const int*>(factor.px),
          static_cast<const int*>(factor.s),
          static_cast<const double*>(factor.x)};
}

Eigen::Map<const MatrixXd> SparseCholesky::Data::solve(int system, MatrixXd& ordered) {
  cholmod_dense view{};
  view.nrow = std::size_t(ordered.rows());
  view.ncol = std::size_t(ordered.cols());
  view.d = view.nrow;
  view.nzmax = view.d * view.ncol;
  view.x = ordered.data();
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  const SerialOpenMp serial;
  const OneBlasThread one_thread;
  if (!cholmod_solve2(system, factor, &view, nullptr, &solution, nullptr, &work_y, &work_e, &common))
    throw std::runtime_error("the sparse solver failed to solve with its factor");
  return {static_cast<const double*>(solution->x), ordered.rows(), ordered.cols()};
}

void SparseCholesky::solve(Eigen::Ref<MatrixXd, 0, Eigen::OuterStride<>> columns) const {
  if (columns.cols() == 0) return;
  MatrixXd ordered = in_elimination_order(data_->order, columns);
  into_own_order(data_->order, data_->solve(CHOLMOD_A, ordered), columns);
}

VectorXd SparseCholesky::solve_forward(const VectorXd& b) const {
  MatrixXd ordered = in_elimination_order(data_->order, b);
  return data_->solve(CHOLMOD_L, ordered);
}

VectorXd SparseCholesky::solve_backward(const VectorXd& y) const {
  MatrixXd ordered = y;
  VectorXd x(y.size());
  into_own_order(data_->order, data_->solve(CHOLMOD_Lt, ordered), x);
  return x;
}

}  // namespace umax
