#include "embedding/cage/cell_table.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace umax {

std::pair<int, int> cells_at(double s) {
  constexpr double far = 1e9;  // beyond any cell: keeps the conversion to int defined
  s = std::clamp(s, -far, far);
  return {int(std::floor(s - face_tolerance)), int(std::floor(s + face_tolerance))};
}

CellTable::CellTable(const Cells& cells) {
  if (cells.rows() == 0) return;
  low_ = cells.colwise().minCoeff();
  size_ = Vector3i(cells.colwise().maxCoeff()) - low_ + Vector3i::Ones();
  const std::int64_t volume = std::int64_t(size_[0]) * size_[1] * size_[2];
  const auto key = [&](Eigen::Index e) {
    return (std::int64_t(cells(e, 0) - low_[0]) * size_[1] + (cells(e, 1) - low_[1])) * size_[2] +
           (cells(e, 2) - low_[2]);
  };
  constexpr std::int64_t max_dense = std::int64_t(1) << 27;
  if (volume <= max_dense) {
    dense_.assign(std::size_t(volume), -1);
    for (Eigen::Index e = 0; e < cells.rows(); ++e) dense_[std::size_t(key(e))] = int(e);
  } else {
    keys_.reserve(std::size_t(cells.rows()));
    for (Eigen::Index e = 0; e < cells.rows(); ++e) keys_.push_back(key(e));
  }
}

bool CellTable::inside_box(int i, int j, int k) const {
  return i >= low_[0] && j >= low_[1] && k >= low_[2] && i - low_[0] < size_[0] && j - low_[1] < size_[1] &&
         k - low_[2] < size_[2];
}

int CellTable::find(int i, int j, int k) const {
  if (!inside_box(i, j, k)) return -1;
  const std::int64_t key = (std::int64_t(i - low_[0]) * size_[1] + (j - low_[1])) * size_[2] + (k - low_[2]);
  if (!dense_.empty()) return dense_[std::size_t(key)];
  const auto found = std::lower_bound(keys_.begin(), keys_.end(), key);
  return found != keys_.end() && *found == key ? int(found - keys_.begin()) : -1;
}

int CellTable::find(const Vector3d& s) const {
  if (!s.allFinite()) return -1;
  const auto [i0, i1] = cells_at(s[0]);
  const auto [j0, j1] = cells_at(s[1]);
  const auto [k0, k1] = cells_at(s[2]);
  for (int i = i0; i <= i1; ++i)
    for (int j = j0; j <= j1; ++j)
      for (int k = k0; k <= k1; ++k)
        if (const int hex = find(i, j, k); hex >= 0) return hex;
  return -1;
}

}  // namespace umax
