// Many rays side by side, one row of numbers for each quantity: loops over rows become vector code.
#pragma once

#include <array>

#include "render/scene/ray.h"

namespace umax {

/// A direction or place as plain numbers, for arithmetic without branches.
struct Direction {
  float x = 0, y = 0, z = 1;
};
inline Direction operator+(const Direction& a, const Direction& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline Direction operator-(const Direction& a, const Direction& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline Direction operator-(const Direction& a) {
  return {-a.x, -a.y, -a.z};
}
inline Direction operator*(float s, const Direction& a) {
  return {s * a.x, s * a.y, s * a.z};
}
inline Direction operator/(const Direction& a, float s) {
  return {a.x / s, a.y / s, a.z / s};
}
// summed in the order of Eigen's dot(), so that both give the same bits
inline float dot(const Direction& a, const Direction& b) {
  return a.x * b.x + (a.y * b.y + a.z * b.z);
}
inline Direction direction_of(const Vector3f& v) {
  return {v.x(), v.y(), v.z()};
}

namespace rows {

constexpr int capacity = 128;

// one number per ray
template <class T>
struct alignas(64) RowOf {
  std::array<T, capacity> values;
  T& operator[](int i) { return values[i]; }
  const T& operator[](int i) const { return values[i]; }
  T* data() { return values.data(); }
  const T* data() const { return values.data(); }
};
using Row = RowOf<float>;

struct DirectionRows {
  Row x, y, z;
  Direction at(int i) const { return {x[i], y[i], z[i]}; }
  Vector3f vector(int i) const { return {x[i], y[i], z[i]}; }
  void set(int i, const Direction& d) { x[i] = d.x, y[i] = d.y, z[i] = d.z; }
  void set(int i, const Vector3f& d) { x[i] = d.x(), y[i] = d.y(), z[i] = d.z(); }
};

struct RayRows {
  DirectionRows origin, direction;
  Row max_distance, time;
  Ray at(int i) const { return {origin.vector(i), direction.vector(i), max_distance[i], time[i]}; }
  void set(int i, const Ray& ray) {
    origin.set(i, ray.origin), direction.set(i, ray.direction);
    max_distance[i] = ray.max_distance, time[i] = ray.time;
  }
  void copy(int to, int from, const RayRows& rays) {
    origin.set(to, rays.origin.at(from)), direction.set(to, rays.direction.at(from));
    max_distance[to] = rays.max_distance[from], time[to] = rays.time[from];
  }
};

struct HitRows {
  RowOf<unsigned> object, triangle;
  Row distance, u, v;
  bool found(int i) const { return object[i] != Hit::nothing; }
  Hit at(int i) const { return {object[i], triangle[i], distance[i], u[i], v[i]}; }
  void set(int i, const Hit& hit) {
    object[i] = hit.object, triangle[i] = hit.triangle, distance[i] = hit.distance, u[i] = hit.u, v[i] = hit.v;
  }
  void copy(int to, int from) { set(to, at(from)); }
};

}  // namespace rows
}  // namespace umax
