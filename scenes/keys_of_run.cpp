// Scene keys of what runs: the clip, the solver, and the scene's own name.
#include "core/files/sha256.h"
#include "scenes/mesh_keys.h"
#include "scenes/section_builder.h"

namespace umax {

SceneSection top_section() {
  SceneSection section{.name = "", .meaning = "above the first table"};
  const auto at = [](auto& scene, std::size_t) -> auto& { return scene; };
  SectionBuilder<Scene, decltype(at)> keys(section, at);
  keys.add("name", TextKind(), UMAX_FIELD(name), "what the scene is called", {.unset = "the file's stem"});
  keys.add("description", TextKind(), UMAX_FIELD(description), "one line about it");
  // presets are expanded before keys are read, and a resolved scene has their values
  keys.add_custom(
      "presets", ExistingFileKind().type(), "file of materials of your own for material.preset", {.unset = "none"},
      [](const SceneValue&, Scene&) {}, [](const Scene&) { return std::optional<std::string>(); });
  return section;
}

template <class Keys>
void add_pull_keys(Keys& keys) {
  using Text = std::optional<std::string>;
  keys.add_custom(
      "pulls", "path", "file of what a live session pulled bodies by (umax live)",
      {.unset = "none", .resets = {"pulls_sha256"}},
      [](const SceneValue& value, ClipDescription& clip) {
        clip.pulls = ExistingFileKind().read(value);
        clip.pulls_sha256 = sha256_of_file(clip.pulls);
      },
      [](const ClipDescription& clip) -> Text {
        return clip.pulls.empty() ? std::nullopt : Text(PathKind().write(clip.pulls));
      });
  keys.add_custom(
      "pulls_sha256", "text", "SHA-256 of that file; another one is refused", {.unset = "not checked"},
      [](const SceneValue& value, ClipDescription& clip) {
        if (clip.pulls.empty()) throw value_error(value, "does not fit here", "it belongs to pulls = \"PATH\"");
        check_sha256(value, "pulls", clip.pulls, clip.pulls_sha256);
      },
      [](const ClipDescription& clip) -> Text {
        return clip.pulls.empty() ? std::nullopt : Text(toml_string(clip.pulls_sha256));
      });
}

SceneSection clip_section() {
  SceneSection section{.name = "clip", .meaning = "length and pace of the clip"};
  auto keys = plain_section(section, &Scene::clip);
  keys.add("frames", IntegerKind{.low = 1, .high = 1000000}, UMAX_FIELD(frames),
           "number of frames; the first is the initial state");
  keys.add("fps", NumberKind{units::rate, {.low = 0, .high = 100000, .low_open = true}}, UMAX_FIELD(fps),
           "frames a second");
  keys.add("substeps", IntegerKind{.low = 1, .high = 100000}, UMAX_FIELD(substeps), "time steps a frame");
  keys.add("gravity", TrackKind<VectorKind>{{units::acceleration, {.low = -1e6, .high = 1e6}}}, UMAX_FIELD(gravity),
           "acceleration of gravity");
  keys.add("allow_overlap", FlagKind(), UMAX_FIELD(allow_overlap),
           "starts although bodies are deep inside each other; they are pushed apart slowly");
  const NumberKind duration{units::time, not_negative};
  keys.add_custom(
      "preroll", duration.type(),
      "time before the first frame, not shown, in which bodies get from rest to where their pins are then",
      {.unset = "0"},
      [duration](const SceneValue& value, ClipDescription& clip) { clip.preroll = duration.read(value); },
      [](const ClipDescription& clip) {
        return clip.preroll > 0 ? std::optional(number_text(clip.preroll)) : std::nullopt;
      });
  add_pull_keys(keys);
  return section;
}

SceneSection solver_section() {
  SceneSection section{.name = "solver", .meaning = "how a time step is solved"};
  auto keys = plain_section(section, &Scene::solver);
  keys.add("method", ChoiceKind<SolverMethod>{{{"exact", SolverMethod::exact}, {"paper", SolverMethod::paper}}},
           UMAX_FIELD(method), "exact: sequential quadratic programming; paper: projected Gauss-Seidel as published");
  keys.add("linear",
           ChoiceKind<LinearSolver>{{{"auto", LinearSolver::automatic},
                                     {"direct", LinearSolver::direct},
                                     {"multigrid", LinearSolver::multigrid}}},
           UMAX_FIELD(linear), "exact: what its linear systems are solved with; auto: the faster one");
  keys.add("tolerance", NumberKind{units::ratio, {.low = 1e-12, .high = 1}}, UMAX_FIELD(tolerance),
           "bound on U/U_max - 1 at the end of a step");
  keys.add("energy", ChoiceKind<EnergyMeasure>{{{"true", EnergyMeasure::true_energy}, {"paper", EnergyMeasure::paper}}},
           UMAX_FIELD(energy), "the energy that a limit measures");
  keys.add("rotation",
           ChoiceKind<RotationEstimate>{{{"centre", RotationEstimate::centre},
                                         {"tetrahedron", RotationEstimate::tetrahedron},
                                         {"kuhn", RotationEstimate::kuhn}}},
           UMAX_FIELD(rotation), "where a hex takes its rotation from");
  keys.add("jacobian",
           ChoiceKind<LimitJacobian>{{{"exact", LimitJacobian::exact},
                                      {"fixed_rotation", LimitJacobian::fixed_rotation},
                                      {"warped", LimitJacobian::warped}}},
           UMAX_FIELD(jacobian), "derivative of the limits");
  keys.add("max_iterations", IntegerKind{.low = 1, .high = 1000000}, UMAX_FIELD(max_iterations),
           "paper: re-linearisations a step, at most");
  keys.add("max_newton_iterations", IntegerKind{.low = 1, .high = 1000000}, UMAX_FIELD(max_newton_iterations),
           "exact: iterations after which a line search takes over; on multigrids two to three times as many");
  keys.add("max_augmented_iterations", IntegerKind{.low = 0, .high = 1000000}, UMAX_FIELD(max_augmented_iterations),
           "exact: factorisations of the line search after which the step is halved");
  keys.add("max_halvings", IntegerKind{.low = 0, .high = 30}, UMAX_FIELD(max_halvings),
           "exact: halvings of a step that does not converge, at most");
  keys.add("max_sweeps", IntegerKind{.low = 1, .high = 100000000}, UMAX_FIELD(max_sweeps),
           "Gauss-Seidel sweeps a re-linearisation, at most");
  keys.add("sweep_tolerance", NumberKind{units::ratio, {.low = 1e-15, .high = 1}}, UMAX_FIELD(sweep_tolerance),
           "relative change at which the sweeps stop");
  return section;
}

}  // namespace umax
