// Compiled for the one instruction set that rays are traced with, whatever the program is compiled for: nothing that
// other files share may be included.
#include "render/trace/cluster_hit.h"

#include "core/base/simd.h"

namespace umax {
namespace UMAX_SIMD {
namespace {

using Floats = Vec<float>;
using Places = VectorOf<float>::Indices;
constexpr int num_vectors = cluster_size / width<float>;

UMAX_INLINE Places load_places(const unsigned char* from) {
#if defined(__AVX512F__)
  return reinterpret_cast<Places>(_mm512_cvtepu8_epi32(_mm_loadu_si128(reinterpret_cast<const __m128i*>(from))));
#elif defined(__AVX2__)
  return reinterpret_cast<Places>(_mm256_cvtepu8_epi32(_mm_loadl_epi64(reinterpret_cast<const __m128i*>(from))));
#else
  Places places;
  for (int i = 0; i < width<float>; ++i) places[i] = from[i];
  return places;
#endif
}

// bit i: of lane i
UMAX_INLINE unsigned bits_of(Places mask) {
#if defined(__AVX512F__)
  return _mm512_movepi32_mask(reinterpret_cast<__m512i>(mask));
#elif defined(__AVX2__)
  return unsigned(_mm256_movemask_ps(reinterpret_cast<__m256>(mask)));
#else
  unsigned bits = 0;
  for (int i = 0; i < width<float>; ++i) bits |= mask[i] ? 1u << i : 0u;
  return bits;
#endif
}

// one coordinate of all vertices
struct Coordinate {
  Floats of[num_vectors];

  UMAX_INLINE Floats at(Places places) const {
#if defined(__AVX512F__)
    return _mm512_permutexvar_ps(reinterpret_cast<__m512i>(places), of[0]);
#elif defined(__AVX2__)
    const __m256i index = reinterpret_cast<__m256i>(places);
    const __m256 low = _mm256_permutevar8x32_ps(of[0], index), high = _mm256_permutevar8x32_ps(of[1], index);
    return _mm256_blendv_ps(low, high, reinterpret_cast<__m256>(_mm256_slli_epi32(index, 28)));
#else
    Floats v;
    for (int i = 0; i < width<float>; ++i) v[i] = of[places[i] / width<float>][places[i] % width<float>];
    return v;
#endif
  }
  // is zero neither below nor above all of them?
  UMAX_INLINE bool spans_zero() const {
    Places below = of[0] <= 0, above = of[0] >= 0;
    for (int k = 1; k < num_vectors; ++k) below |= of[k] <= 0, above |= of[k] >= 0;
    return bits_of(below) != 0 && bits_of(above) != 0;
  }
};

UMAX_INLINE Coordinate seen_from(float origin, const float* before, const float* after, float share) {
  const Floats s = broadcast(share), r = broadcast(1 - share), o = broadcast(origin);
  Coordinate c;
  for (int k = 0; k < num_vectors; ++k)
    c.of[k] = multiply_add(s, load<float>(after + k * width<float>), r * load<float>(before + k * width<float>)) - o;
  return c;
}

UMAX_INLINE void shear_by(float shear, const Coordinate& z, Coordinate& c) {
  const Floats s = broadcast(-shear);
  for (int k = 0; k < num_vectors; ++k) c.of[k] = multiply_add(s, z.of[k], c.of[k]);
}

UMAX_INLINE ClusterHit hit(const ShearedRay& ray, float most, const ClusterPositions& before,
                           const ClusterPositions& after, float share, const ClusterCorners& corners) {
  const auto coordinate = [&](int axis, float origin) {
    return seen_from(origin, before.of_axis[axis], after.of_axis[axis], share);
  };
  const Coordinate z = coordinate(ray.z, ray.origin[2]);
  Coordinate x = coordinate(ray.x, ray.origin[0]), y = coordinate(ray.y, ray.origin[1]);
  shear_by(ray.shear[0], z, x);
  shear_by(ray.shear[1], z, y);
  ClusterHit nearest;
  if (!x.spans_zero() || !y.spans_zero()) return nearest;
  for (int first = 0; first < cluster_size; first += width<float>) {
    const Places a = load_places(corners.places[0] + first), b = load_places(corners.places[1] + first),
                 c = load_places(corners.places[2] + first);
    const Floats ax = x.at(a), ay = y.at(a), bx = x.at(b), by = y.at(b), cx = x.at(c), cy = y.at(c);
    // twice the areas that the ray's point spans with the edges: products are rounded before they are subtracted, or an
    // edge would not say the opposite to its other triangle
    const Floats of_a = cx * by - cy * bx, of_b = ax * cy - ay * cx, of_c = bx * ay - by * ax;
    const Floats all = of_a + of_b + of_c;
    const Places left = (of_a >= 0) & (of_b >= 0) & (of_c >= 0), right = (of_a <= 0) & (of_b <= 0) & (of_c <= 0);
    const Places inside = (left | right) & (all != 0);
    if (bits_of(inside) == 0) continue;
    const Floats depth = of_a * z.at(a) + of_b * z.at(b) + of_c * z.at(c);
    const Floats distance = depth * broadcast(ray.shear[2]) / all;
    for (unsigned met = bits_of(inside & (distance > 0) & (distance <= broadcast(most))); met != 0; met &= met - 1) {
      const int i = __builtin_ctz(met);
      if (nearest.triangle >= 0 && !(distance[i] < nearest.distance)) continue;
      nearest = {.triangle = first + i, .distance = distance[i], .u = of_b[i] / all[i], .v = of_c[i] / all[i]};
    }
  }
  return nearest;
}

UMAX_INLINE float magnitude(float x) {
  return x < 0 ? -x : x;
}

}  // namespace
}  // namespace UMAX_SIMD

ShearedRay shear(const float origin[3], const float direction[3]) {
  using UMAX_SIMD::magnitude;
  const float x = magnitude(direction[0]), y = magnitude(direction[1]), z = magnitude(direction[2]);
  const int along = x > y ? (x > z ? 0 : 2) : (y > z ? 1 : 2);
  constexpr int next[] = {1, 2, 0};
  ShearedRay ray{.x = next[along], .y = next[next[along]], .z = along, .origin = {}, .shear = {}};
  const float scale = 1 / direction[ray.z];
  ray.shear[0] = direction[ray.x] * scale;
  ray.shear[1] = direction[ray.y] * scale;
  ray.shear[2] = scale;
  ray.origin[0] = origin[ray.x];
  ray.origin[1] = origin[ray.y];
  ray.origin[2] = origin[ray.z];
  return ray;
}

ClusterHit hit_cluster(const ShearedRay& ray, float most, const ClusterPositions& before, const ClusterPositions& after,
                       float share, const ClusterCorners& corners) {
  return UMAX_SIMD::hit(ray, most, before, after, share, corners);
}

}  // namespace umax
