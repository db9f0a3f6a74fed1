// Values as the bytes that they have in memory: what states and digests are made of.
#pragma once

#include <cstdint>
#include <string>

#include "core/files/sha256.h"

namespace umax {

/// Values one after another, as the bytes that they have in memory: to be kept, or for their digest alone.
class ByteWriter {
 public:
  explicit ByteWriter(Sha256* digest = nullptr) : digest_(digest) {}

  template <class T>
  void put(T value) {
    put_bytes(&value, sizeof value);
  }
  template <class... T>
  void put_all(T... values) {
    (put(values), ...);
  }
  void put_bytes(const void* values, std::size_t count) {
    const auto* start = static_cast<const char*>(values);
    if (digest_)
      digest_->add({start, count});
    else
      bytes.append(start, count);
  }
  /// Number of rows, then the values.
  template <class Matrix>
  void put_matrix(const Matrix& matrix) {
    put(std::uint64_t(matrix.rows()));
    put_bytes(matrix.data(), std::size_t(matrix.size()) * sizeof(typename Matrix::Scalar));
  }
  std::string bytes;

 private:
  Sha256* digest_ = nullptr;
};

}  // namespace umax
