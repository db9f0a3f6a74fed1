// Vectors of numbers as wide as the instruction set that the including file is compiled for, and their operations; only
// the kernels include this. Everything stands in namespace umax::UMAX_SIMD, so that no function of one instruction set
// is linked for another.
#pragma once

#include <cstddef>

#if defined(__AVX512F__) || defined(__AVX2__)
#include <immintrin.h>
#endif

#if defined(__AVX512F__)
#define UMAX_SIMD avx512
#define UMAX_SIMD_BYTES 64
#elif defined(__AVX2__) && defined(__FMA__)
#define UMAX_SIMD avx2
#define UMAX_SIMD_BYTES 32
#else
#define UMAX_SIMD portable
#define UMAX_SIMD_BYTES 16
#endif
#define UMAX_INLINE inline __attribute__((always_inline))

namespace umax::UMAX_SIMD {

template <class T>
struct VectorOf;
template <>
struct VectorOf<float> {
  using Type __attribute__((vector_size(UMAX_SIMD_BYTES))) = float;
  using Indices __attribute__((vector_size(UMAX_SIMD_BYTES))) = int;
};
template <>
struct VectorOf<double> {
  using Type __attribute__((vector_size(UMAX_SIMD_BYTES))) = double;
  using Indices __attribute__((vector_size(UMAX_SIMD_BYTES))) = long long;
};
template <class T>
using Vec = typename VectorOf<T>::Type;

template <class T>
inline constexpr int width = UMAX_SIMD_BYTES / int(sizeof(T));

/// Any alignment that the element type has.
template <class T, class S>
UMAX_INLINE Vec<T> load(const S* from) {
  if constexpr (sizeof(T) == sizeof(S)) {
    Vec<T> v;
    __builtin_memcpy(&v, from, sizeof(v));
    return v;
  } else {
    using Narrow __attribute__((vector_size(UMAX_SIMD_BYTES / 2))) = float;
    Narrow v;
    __builtin_memcpy(&v, from, sizeof(v));
    return __builtin_convertvector(v, Vec<T>);
  }
}

/// As numbers in single precision.
UMAX_INLINE Vec<float> load_short(const short* from) {
  using Short __attribute__((vector_size(UMAX_SIMD_BYTES / 2))) = short;
  Short v;
  __builtin_memcpy(&v, from, sizeof(v));
  return __builtin_convertvector(__builtin_convertvector(v, VectorOf<float>::Indices), Vec<float>);
}

template <class T, class S>
UMAX_INLINE void store(S* to, Vec<T> v) {
  if constexpr (sizeof(T) == sizeof(S)) {
    __builtin_memcpy(to, &v, sizeof(v));
  } else {
    using Narrow __attribute__((vector_size(UMAX_SIMD_BYTES / 2))) = float;
    const Narrow narrow = __builtin_convertvector(v, Narrow);
    __builtin_memcpy(to, &narrow, sizeof(narrow));
  }
}

template <class T>
UMAX_INLINE Vec<T> broadcast(T value) {
  return value - Vec<T>{};  // lane by lane, compilers mask and blend
}

/// a b + c, rounded once where the instruction set can.
UMAX_INLINE Vec<float> multiply_add(Vec<float> a, Vec<float> b, Vec<float> c) {
#if defined(__AVX512F__)
  return _mm512_fmadd_ps(a, b, c);
#elif defined(__AVX2__) && defined(__FMA__)
  return _mm256_fmadd_ps(a, b, c);
#else
  return a * b + c;
#endif
}
UMAX_INLINE Vec<double> multiply_add(Vec<double> a, Vec<double> b, Vec<double> c) {
#if defined(__AVX512F__)
  return _mm512_fmadd_pd(a, b, c);
#elif defined(__AVX2__) && defined(__FMA__)
  return _mm256_fmadd_pd(a, b, c);
#else
  return a * b + c;
#endif
}

/// c - a b, rounded once where the instruction set can.
UMAX_INLINE Vec<double> multiply_subtract(Vec<double> a, Vec<double> b, Vec<double> c) {
#if defined(__AVX512F__)
  return _mm512_fnmadd_pd(a, b, c);
#elif defined(__AVX2__) && defined(__FMA__)
  return _mm256_fnmadd_pd(a, b, c);
#else
  return c - a * b;
#endif
}

/// Lanes 1, 2, ... of a, then lane 0 of b.
UMAX_INLINE Vec<float> shift_down(Vec<float> a, Vec<float> b) {
#if UMAX_SIMD_BYTES == 64
  return __builtin_shufflevector(a, b, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16);
#elif UMAX_SIMD_BYTES == 32
  return __builtin_shufflevector(a, b, 1, 2, 3, 4, 5, 6, 7, 8);
#else
  return __builtin_shufflevector(a, b, 1, 2, 3, 4);
#endif
}
UMAX_INLINE Vec<double> shift_down(Vec<double> a, Vec<double> b) {
#if UMAX_SIMD_BYTES == 64
  return __builtin_shufflevector(a, b, 1, 2, 3, 4, 5, 6, 7, 8);
#elif UMAX_SIMD_BYTES == 32
  return __builtin_shufflevector(a, b, 1, 2, 3, 4);
#else
  return __builtin_shufflevector(a, b, 1, 2);
#endif
}

/// The last lane of a, then lanes 0, 1, ... of b.
UMAX_INLINE Vec<float> shift_up(Vec<float> a, Vec<float> b) {
#if UMAX_SIMD_BYTES == 64
  return __builtin_shufflevector(a, b, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27, 28, 29, 30);
#elif UMAX_SIMD_BYTES == 32
  return __builtin_shufflevector(a, b, 7, 8, 9, 10, 11, 12, 13, 14);
#else
  return __builtin_shufflevector(a, b, 3, 4, 5, 6);
#endif
}
UMAX_INLINE Vec<double> shift_up(Vec<double> a, Vec<double> b) {
#if UMAX_SIMD_BYTES == 64
  return __builtin_shufflevector(a, b, 7, 8, 9, 10, 11, 12, 13, 14);
#elif UMAX_SIMD_BYTES == 32
  return __builtin_shufflevector(a, b, 3, 4, 5, 6);
#else
  return __builtin_shufflevector(a, b, 1, 2);
#endif
}

/// v where test > 0, else 0.
template <class T>
UMAX_INLINE Vec<T> where_positive(Vec<T> test, Vec<T> v) {
  return test > Vec<T>{} ? v : Vec<T>{};
}

template <class T>
UMAX_INLINE Vec<T> square_root(Vec<T> v) {
  for (int lane = 0; lane < width<T>; ++lane) v[lane] = T(__builtin_sqrt(double(v[lane])));
  return v;
}

/// Sum of the lanes, first to last.
template <class T>
UMAX_INLINE double sum_of_lanes(Vec<T> v) {
  double sum = 0;
  for (int lane = 0; lane < width<T>; ++lane) sum += double(v[lane]);
  return sum;
}

}  // namespace umax::UMAX_SIMD
