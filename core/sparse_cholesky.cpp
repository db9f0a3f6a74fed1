#include "core/sparse_cholesky.h"

#include <cholmod.h>
#include <dlfcn.h>

#include <new>
#include <stdexcept>

namespace umax {
namespace {

// nested dissection pays from here on (THEORY 4); below, minimum degree analyses faster
constexpr int nested_dissection_unknowns = 20000;

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

}  // namespace

struct SparseCholesky::Data {
  cholmod_common common{};
  cholmod_factor* factor = nullptr;
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

bool SparseCholesky::factorize(const SystemMatrix& matrix) {
  cholmod_sparse view{};
  view.nrow = view.ncol = std::size_t(matrix.num_unknowns());
  view.nzmax = matrix.row_indices.size();
  view.p = const_cast<int*>(matrix.column_starts.data());
  view.i = const_cast<int*>(matrix.row_indices.data());
  view.x = const_cast<double*>(matrix.values.data());
  view.stype = -1;
  view.itype = CHOLMOD_INT;
  view.xtype = CHOLMOD_REAL;
  view.dtype = CHOLMOD_DOUBLE;
  view.sorted = view.packed = 1;

  const SerialOpenMp serial;
  cholmod_common& common = data_->common;
  if (!data_->factor) {
    common.nmethods = 1;
    common.method[0].ordering = matrix.num_unknowns() < nested_dissection_unknowns ? CHOLMOD_AMD : CHOLMOD_METIS;
    common.postorder = 1;
    data_->factor = cholmod_analyze(&view, &common);
    if (!data_->factor) throw std::bad_alloc();
  }
  cholmod_factorize(&view, data_->factor, &common);
  if (common.status == CHOLMOD_OUT_OF_MEMORY || common.status == CHOLMOD_TOO_LARGE) throw std::bad_alloc();
  return common.status == CHOLMOD_OK;
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
