// Scene keys of [camera], [light.NAME] and [render].
#include <tuple>

#include "scenes/section_builder.h"

namespace umax {
namespace {

// A colour held in double precision.
struct LightColorKind {
  using Value = Vector3d;
  ColorKind kind{.bounded = false};
  Value read(const SceneValue& value) const { return kind.read(value).cast<double>(); }
  std::string write(const Value& color) const { return kind.write(color.cast<float>()); }
  std::string type() const { return kind.type(); }
};

struct DirectionKind {
  using Value = Vector3f;
  VectorKind kind{units::ratio, {.low = -1e6, .high = 1e6}};
  Value read(const SceneValue& value) const {
    const Vector3f direction = kind.read(value).cast<float>();
    if (!(direction.norm() > 0)) throw value_error(value, "has no direction", "give a vector that is not zero");
    return direction;
  }
  std::string write(const Value& direction) const { return ColorKind().write(direction); }
  std::string type() const { return kind.type(); }
};

// A word; true and false are what they were before there were words.
struct NoiseFilterKind {
  using Value = NoiseFilter;
  ChoiceKind<NoiseFilter> words{
      {{"temporal", NoiseFilter::temporal}, {"spatial", NoiseFilter::spatial}, {"none", NoiseFilter::none}}};
  Value read(const SceneValue& value) const {
    if (const bool* flag = value.as<bool>()) return *flag ? NoiseFilter::spatial : NoiseFilter::none;
    if (const auto* text = value.as<std::string>(); text && *text == "oidn")
      throw value_error(value, "is not in this version, which has filters of its own", "write \"temporal\"");
    return words.read(value);
  }
  std::string write(Value filter) const { return words.write(filter); }
  std::string type() const { return words.type(); }
};

// Part of the sky if it is of that kind, else null.
template <class Kind, class T>
auto sky_part(T Kind::* member) {
  return [member](auto& render) {
    auto* sky = std::get_if<Kind>(&render.sky);
    return sky ? &(sky->*member) : nullptr;
  };
}

void set_sky(const SceneValue& value, RenderDescription& render) {
  const std::string kind = WordKind{{"constant", "gradient", "daylight", "map"}}.read(value);
  if (kind == "constant") render.sky = ConstantSky();
  if (kind == "gradient") render.sky = GradientSky();
  if (kind == "daylight") render.sky = DaylightSky();
  if (kind == "map") render.sky = EnvironmentMap();
}

std::optional<std::string> get_sky(const RenderDescription& render) {
  return std::visit(
      [](const auto& sky) -> std::string {
        using Kind = std::decay_t<decltype(sky)>;
        if constexpr (std::is_same_v<Kind, ConstantSky>) return "\"constant\"";
        if constexpr (std::is_same_v<Kind, GradientSky>) return "\"gradient\"";
        if constexpr (std::is_same_v<Kind, DaylightSky>) return "\"daylight\"";
        return "\"map\"";
      },
      render.sky);
}

template <class Keys>
void add_sky_keys(Keys& keys) {
  const ColorKind light{.bounded = false};
  const auto color_text = [light](const Vector3f& color) { return light.write(color); };
  const std::string constant = "render.sky.kind = \"constant\"", gradient = "render.sky.kind = \"gradient\"";
  const std::string daylight = "render.sky.kind = \"daylight\"", map = "render.sky.kind = \"map\"";
  keys.add_custom("sky.kind", R"("constant", "gradient", "daylight", "map")", "what lights the scene from all around",
                  {.resets = {"sky.color", "sky.horizon", "sky.zenith", "sky.ground", "sky.sun_direction",
                              "sky.turbidity", "sky.sun_size", "sky.intensity", "sky.map", "sky.rotation"}},
                  set_sky, get_sky);
  keys.add("sky.color", light, sky_part(&ConstantSky::radiance), "radiance of a constant sky",
           {.unset = color_text(ConstantSky().radiance), .belongs_to = constant});
  keys.add("sky.horizon", light, sky_part(&GradientSky::horizon), "radiance at the horizon of a gradient",
           {.unset = color_text(GradientSky().horizon), .belongs_to = gradient});
  keys.add("sky.zenith", light, sky_part(&GradientSky::zenith), "radiance overhead",
           {.unset = color_text(GradientSky().zenith), .belongs_to = gradient});
  keys.add("sky.ground", light, sky_part(&GradientSky::ground), "radiance from below",
           {.unset = color_text(GradientSky().ground), .belongs_to = gradient});
  keys.add("sky.sun_direction", DirectionKind(), sky_part(&DaylightSky::sun_direction), "towards the sun",
           {.unset = DirectionKind().write(DaylightSky().sun_direction), .belongs_to = daylight});
  keys.add("sky.turbidity", NumberKind{units::ratio, {.low = 1, .high = 10}}, sky_part(&DaylightSky::turbidity),
           "haze of a daylight sky: 2 clear, 6 hazy",
           {.unset = number_text(DaylightSky().turbidity), .belongs_to = daylight});
  keys.add("sky.sun_size", NumberKind{units::angle, {.low = 0.01, .high = 90}},
           sky_part(&DaylightSky::sun_size_degrees), "diameter of the sun: larger softens shadows",
           {.unset = number_text(DaylightSky().sun_size_degrees), .belongs_to = daylight});
  const auto intensity = [](auto& render) {
    if (auto* sky = std::get_if<DaylightSky>(&render.sky)) return &sky->intensity;
    auto* environment = std::get_if<EnvironmentMap>(&render.sky);
    return environment ? &environment->intensity : nullptr;
  };
  keys.add("sky.intensity", NumberKind{units::ratio, {.low = 0, .high = 1e6}}, intensity,
           "factor on a daylight sky or map",
           {.unset = number_text(DaylightSky().intensity), .belongs_to = daylight + " or \"map\""});
  const auto map_path = [](auto& render) {
    return std::holds_alternative<EnvironmentMap>(render.sky) ? &render.sky_path : nullptr;
  };
  keys.add("sky.map", ExistingFileKind(), map_path, "latitude-longitude picture, HDR or EXR",
           {.unset = "none", .belongs_to = map});
  keys.add("sky.rotation", NumberKind{units::angle, {.low = -1e6, .high = 1e6}},
           sky_part(&EnvironmentMap::rotation_degrees), "of the map about Y",
           {.unset = number_text(EnvironmentMap().rotation_degrees), .belongs_to = map});
}

template <class Keys>
void add_layer_keys(Keys& keys) {
  keys.add("exr", FlagKind(), UMAX_FIELD(exr),
           "writes NNNN.exr beside NNNN.png: colour and what guides the noise filter");
  keys.add("layers",
           ChoiceListKind<PictureLayer>{{{"albedo", PictureLayer::albedo},
                                         {"normal", PictureLayer::normal},
                                         {"depth", PictureLayer::depth},
                                         {"position", PictureLayer::position},
                                         {"vector", PictureLayer::vector},
                                         {"object", PictureLayer::object},
                                         {"energy", PictureLayer::energy},
                                         {"cryptomatte", PictureLayer::cryptomatte},
                                         {"noise", PictureLayer::noise}}},
           UMAX_FIELD(layers), "writes NNNN.exr for compositing: colour with alpha, and these layers (embree)");
  keys.add("transparent", FlagKind(), UMAX_FIELD(transparent),
           "alpha where the sky would be seen, in PNG and EXR; the clip is over black (embree)");
}

}  // namespace

SceneSection camera_section() {
  SceneSection section{.name = "camera", .meaning = "who looks"};
  auto keys = plain_section(section, &Scene::camera);
  const std::vector<std::string> of_file{"file", "name", "start"}, of_scene{"position", "target", "vertical_fov"};
  keys.add_custom(
      "file", ExistingFileKind().type(), "glTF or USD text (.usda) whose camera it is, with its animation",
      {.unset = "none", .resets = of_scene},
      [](const SceneValue& value, CameraDescription& camera) { camera.file = ExistingFileKind().read(value); },
      [](const CameraDescription& camera) {
        return camera.file.empty() ? std::nullopt : std::optional(ExistingFileKind().write(camera.file));
      });
  keys.add("name", TextKind(), UMAX_FIELD(name), "of the camera in the file; empty: its only one");
  keys.add("start", NumberKind{units::time, {.low = -1e6, .high = 1e6}}, UMAX_FIELD(start),
           "time of the file's animation at which the clip begins", {.unset = "where the file's animation begins"});
  keys.add("position", TrackKind<VectorKind>{{units::length, any_length}}, UMAX_FIELD(position), "where it stands",
           {.unset = "frames the whole motion", .resets = of_file});
  keys.add("target", TrackKind<VectorKind>{{units::length, any_length}}, UMAX_FIELD(target), "what it looks at",
           {.unset = "frames the whole motion", .resets = of_file});
  keys.add("vertical_fov", TrackKind<NumberKind>{{units::angle, {.low = 0.1, .high = 170}}},
           UMAX_FIELD(vertical_fov_degrees), "angle of view, top to bottom");
  keys.add("aperture_radius", TrackKind<NumberKind>{{units::length, {.low = 0, .high = 1e3}}},
           UMAX_FIELD(aperture_radius), "of the lens; 0: everything is sharp");
  keys.add("focus_distance", TrackKind<NumberKind>{{units::length, {.low = 0, .high = 1e6}}},
           UMAX_FIELD(focus_distance), "where it is sharp; 0: at the target");
  return section;
}

SceneSection light_section() {
  SceneSection section{.name = "light", .meaning = "a square that shines on its target"};
  auto keys = named_section(section, &Scene::lights);
  keys.add("position", TrackKind<VectorKind>{{units::length, any_length}}, UMAX_FIELD(position), "its centre",
           {.defines = true});
  keys.add("target", TrackKind<VectorKind>{{units::length, any_length}}, UMAX_FIELD(target), "what it shines on");
  keys.add("size", TrackKind<NumberKind>{{units::length, {.low = 0, .high = 1e6, .low_open = true}}}, UMAX_FIELD(size),
           "edge of the square: larger softens shadows");
  keys.add("power", TrackKind<NumberKind>{{units::power, {.low = 0, .high = 1e12}}}, UMAX_FIELD(power),
           "radiance is power / (pi area)");
  keys.add("color", TrackKind<LightColorKind>{}, UMAX_FIELD(color), "multiplies the power");
  return section;
}

SceneSection render_section() {
  SceneSection section{.name = "render", .meaning = "how pictures are made"};
  auto keys = plain_section(section, &Scene::render);
  keys.add("engine", ChoiceKind<RenderEngine>{{{"embree", RenderEngine::embree}, {"osmesa", RenderEngine::osmesa}}},
           UMAX_FIELD(engine), "embree: path tracer; osmesa: rasteriser");
  const SizeKind size{.low = 16, .high = 16384};
  keys.add_custom(
      "size", size.type(), "width and height of a frame", {},
      [size](const SceneValue& value, RenderDescription& render) {
        std::tie(render.width, render.height) = size.read(value);
      },
      [size](const RenderDescription& render) { return std::optional(size.write({render.width, render.height})); });
  keys.add("samples", IntegerKind{.low = 1, .high = 1 << 20}, UMAX_FIELD(samples),
           "paths a pixel (embree): more is less noise; below 16, osmesa draws fewer shadow maps");
  keys.add(
      "noise", NumberKind{units::ratio, {.low = 0, .high = 1}}, UMAX_FIELD(noise),
      "standard error of a pixel's brightness, as shown, over its value, that is enough before denoising: samples are "
      "then the most; 0: all are taken (embree)");
  keys.add("bounces", IntegerKind{.low = 0, .high = 1000}, UMAX_FIELD(bounces),
           "reflections of a path, at most (embree)");
  keys.add("denoise", NoiseFilterKind(), UMAX_FIELD(denoise),
           "what takes out the noise: spatial, a filter guided by what is seen; temporal, the same after light was "
           "gathered from the two pictures before and the two after, where they show the same points under the same "
           "light; true is spatial, false none (embree)");
  keys.add("preview", FlagKind(), UMAX_FIELD(preview),
           "as fast as it goes, for a look at the motion: two paths a pixel and one bounce at most "
           "(embree)");
  keys.add("seed", IntegerKind{.low = 0}, UMAX_FIELD(seed), "of the noise (embree)");
  keys.add("surface",
           ChoiceKind<SurfaceKernel>{{{"trilinear", SurfaceKernel::trilinear}, {"smooth", SurfaceKernel::smooth}}},
           UMAX_FIELD(surface),
           "how bodies lie in their cages: trilinear, as contact feels them; smooth, without the creases of a coarse "
           "cage that is bent, in pictures alone");
  keys.add("shutter", NumberKind{units::ratio, {.low = 0, .high = 2}}, UMAX_FIELD(shutter),
           "frames that it stays open: what moves meanwhile is blurred, 0.5 as in film; heat maps never are (embree)");
  keys.add("shutter_position", NumberKind{units::ratio, {.low = 0, .high = 1}}, UMAX_FIELD(shutter_position),
           "where the frame's own time lies while it is open: 0 at the start, 1 at the end");
  keys.add("heatmap",
           ChoiceKind<Heatmap>{{{"none", Heatmap::none},
                                {"energy", Heatmap::energy},
                                {"multiplier", Heatmap::multiplier},
                                {"stretch", Heatmap::stretch}}},
           UMAX_FIELD(heatmap),
           "energy: colours show U/U_max; multiplier: lambda/U_max, the times a limit stiffens a hex; stretch: by "
           "energy, in %");
  keys.add("heatmap_top", NumberKind{units::ratio, positive}, UMAX_FIELD(heatmap_top),
           "where the bar of multiplier and stretch (in %) ends; what is beyond has the end's colour",
           {.unset = "the limit that all share, or the largest of the clip"});
  keys.add("wireframe", FlagKind(), UMAX_FIELD(wireframe), "draws the cage over the picture (osmesa)");
  add_layer_keys(keys);
  keys.add("backdrop", ColorKind{.bounded = false}, UMAX_FIELD(backdrop),
           "colour that the camera sees instead of the sky", {.unset = "the sky"});
  keys.add("exposure", NumberKind{units::ratio, {.low = -50, .high = 50}}, UMAX_FIELD(exposure_stops),
           "in stops: 1 is twice as bright");
  add_sky_keys(keys);
  return section;
}

}  // namespace umax
