// What a wave of paths keeps of surfaces, one row of numbers for each quantity.
#pragma once

#include "render/scene/rows.h"
#include "render/trace/bsdf_core.h"

namespace umax::rows {

using bsdf_core::Surface;

struct ColorRows {
  Row r, g, b;
  bsdf_core::Color at(int i) const { return {r[i], g[i], b[i]}; }
  Vector3f vector(int i) const { return {r[i], g[i], b[i]}; }
  void set(int i, const bsdf_core::Color& c) { r[i] = c.r, g[i] = c.g, b[i] = c.b; }
};
struct LobeRows {
  Row alpha, root_viewer, density_scale;
  bsdf_core::Lobe at(int i) const { return {alpha[i], root_viewer[i], density_scale[i]}; }
  void set(int i, const bsdf_core::Lobe& l) {
    alpha[i] = l.alpha, root_viewer[i] = l.root_viewer, density_scale[i] = l.density_scale;
  }
};
struct SurfaceRows {
  DirectionRows viewer;
  ColorRows diffuse, glossy_a, glossy_b, albedo;
  Row coat, choose_diffuse, choose_glossy;
  LobeRows glossy_lobe, coat_lobe;
  Surface at(int i) const {
    return {.viewer = viewer.at(i),
            .diffuse = diffuse.at(i),
            .glossy_a = glossy_a.at(i),
            .glossy_b = glossy_b.at(i),
            .coat = coat[i],
            .glossy_lobe = glossy_lobe.at(i),
            .coat_lobe = coat_lobe.at(i),
            .choose_diffuse = choose_diffuse[i],
            .choose_glossy = choose_glossy[i],
            .albedo = albedo.at(i)};
  }
  void set(int i, const Surface& s) {
    viewer.set(i, s.viewer), diffuse.set(i, s.diffuse), glossy_a.set(i, s.glossy_a), glossy_b.set(i, s.glossy_b);
    coat[i] = s.coat, glossy_lobe.set(i, s.glossy_lobe), coat_lobe.set(i, s.coat_lobe);
    choose_diffuse[i] = s.choose_diffuse, choose_glossy[i] = s.choose_glossy, albedo.set(i, s.albedo);
  }
};
struct LookRows {
  Row alpha, f0, f90, metallic, coat, coat_alpha, a, b, coat_a, coat_b;
};
// axes of the local frames [Duff et al. 2017]
struct FrameRows {
  DirectionRows x, y, z;
  Direction to_local(int i, const Direction& d) const {
    return {d.x * x.x[i] + d.y * x.y[i] + d.z * x.z[i], d.x * y.x[i] + d.y * y.y[i] + d.z * y.z[i],
            d.x * z.x[i] + d.y * z.y[i] + d.z * z.z[i]};
  }
  Direction to_world(int i, const Direction& d) const {
    return {d.x * x.x[i] + d.y * y.x[i] + d.z * z.x[i], d.x * x.y[i] + d.y * y.y[i] + d.z * z.y[i],
            d.x * x.z[i] + d.y * y.z[i] + d.z * z.z[i]};
  }
};

}  // namespace umax::rows
