"""What the user sets: of each object, of the scene, and where the program is."""
import bpy
from bpy.props import (BoolProperty, CollectionProperty, EnumProperty, FloatProperty, FloatVectorProperty, IntProperty,
                       PointerProperty, StringProperty)

ROLES = (
    ("NONE", "Nothing", "Has no part in the simulation"),
    ("BODY", "Soft body", "Falls, deforms and stops deforming at its limit"),
    ("COLLIDER", "Collider", "Bodies touch it; it moves as it is animated, with its modifiers and rigs"),
)
LIMITS = (
    ("none", "None", "Linear elastic: stretches as far as forces pull"),
    ("hard", "Hard", "No part of the body ever stretches beyond the limit"),
    ("soft", "Soft", "Stiffens before the limit, which is not passed either"),
)
TOUCHES = (
    ("all", "Everything", "Colliders, other bodies, and itself"),
    ("others", "All but itself", "Colliders and other bodies"),
    ("obstacles", "Colliders", "Colliders alone"),
    ("none", "Nothing", "Falls through everything"),
)
COLLIDER_SHAPES = (
    ("AUTO", "Automatic", "A flat mesh is a floor, any other one its surface"),
    ("MESH", "Mesh", "Its surface, with its modifiers, in every frame"),
    ("PLANE", "Floor", "All that is below the object's own XY plane, without an end"),
)


class UmaxPin(bpy.types.PropertyGroup):
    """Points of a body that follow an animation"""
    group: StringProperty(name="Vertex group", description="Weight 1 follows exactly, 0 is free, between a spring pulls; none: "
                                                            "what is inside of the object that is followed")
    target: PointerProperty(name="Follows", type=bpy.types.Object,
                            description="Animated object; none: the body's own animation, by its shape keys, armature, parent")
    is_timed: BoolProperty(name="Between frames", description="It holds for some frames only, and lets go of the body then")
    first_frame: IntProperty(name="From frame", default=1, description="The first frame in which it holds")
    last_frame: IntProperty(name="Until frame", default=24, description="The last frame in which it holds")
    is_spring: BoolProperty(name="Springs", description="It pulls its points, in place of holding them exactly")
    spring: FloatProperty(name="Spring (N/m)", default=1000, min=1e-6, max=1e12, soft_min=1, soft_max=1e6, precision=1,
                          description="What pulls each point: newtons a metre away from where it should be")


class UmaxObject(bpy.types.PropertyGroup):
    role: EnumProperty(name="Takes part as", items=ROLES, default="NONE")
    friction: FloatProperty(name="Friction", default=0.5, min=0, max=1000, soft_max=2,
                            description="Coulomb coefficient; of two that touch the larger one counts")
    # body
    cells: IntProperty(name="Cells", default=365, min=1, max=5000000, soft_max=20000,
                       description="Number of hexahedra that the body is made of, about: more bend finer and take longer")
    stiffness: FloatProperty(name="Stiffness (kPa)", default=500, min=1e-3, max=1e9, soft_min=1, soft_max=1e5, precision=1,
                             description="Young's modulus in kilopascals: gelatine 8, foam 50, rubber 1200")
    poisson: FloatProperty(name="Poisson's ratio", default=0.3, min=0, max=0.49,
                           description="How much it becomes thinner where it is stretched; 0.5 keeps its volume")
    density: FloatProperty(name="Density (kg/m³)", default=500, min=1e-3, max=1e6, soft_min=10, soft_max=3000, precision=0,
                           description="Mass per volume: foam 40, plush 57, flesh and gelatine 1050")
    damping: FloatProperty(name="Damping (ms)", default=0, min=0, max=1e5, soft_max=50, precision=1,
                           description="How fast wobbling dies away: Rayleigh damping by stiffness, in milliseconds")
    drag: FloatProperty(name="Drag (1/s)", default=0, min=0, max=1e5, soft_max=10, precision=2,
                        description="Slows all motion, falling too: Rayleigh damping by mass")
    limit: EnumProperty(name="Limit", items=LIMITS, default="hard")
    stretch: FloatProperty(name="Stretch limit", default=20, min=0.01, max=1e4, soft_min=1, soft_max=200, precision=1,
                           subtype="PERCENTAGE", description="Where deforming stops: as much as this stretch takes")
    touches: EnumProperty(name="Touches", items=TOUCHES, default="all")
    velocity: FloatVectorProperty(name="Velocity (m/s)", size=3, subtype="XYZ", description="At the first frame")
    spin: FloatVectorProperty(name="Spin (°/s)", size=3, subtype="XYZ",
                              description="At the first frame, about the world's axes through the centre of mass")
    limit_group: StringProperty(name="Limit map", description="Vertex group that says where the limit is weaker or stronger")
    limit_range: FloatVectorProperty(name="Factors at weight 0 and 1", size=2, default=(0.1, 1), min=0.01, max=1000,
                                     description="What the limit's energy is multiplied by")
    stiffness_group: StringProperty(name="Stiffness map", description="Vertex group that says where it is softer or stiffer")
    stiffness_range: FloatVectorProperty(name="Factors at weight 0 and 1", size=2, default=(0.1, 1), min=0.01, max=1000,
                                         description="What the stiffness is multiplied by")
    pins: CollectionProperty(type=UmaxPin)
    # collider
    shape: EnumProperty(name="Shape", items=COLLIDER_SHAPES, default="AUTO")
    # whether it has a cache of a bake
    is_baked: BoolProperty(options={"HIDDEN"})


def percent_done(_):
    from . import operators  # which stands on these settings
    return 100 * operators.running.fraction if operators.running else 0


class UmaxScene(bpy.types.PropertyGroup):
    folder: StringProperty(name="Folder", subtype="DIR_PATH", default="//umax",
                           description="Where caches and states go; // is beside the .blend file")
    substeps: IntProperty(name="Steps per frame", default=1, min=1, max=1000, soft_max=20,
                          description="Time steps a frame: more for fast motion and stiff bodies")
    samples: IntProperty(name="Collider samples per frame", default=0, min=0, max=32,
                         description="How often animated colliders are evaluated; 0: more where they are fast")
    overlap: BoolProperty(name="Start although bodies overlap", default=False,
                          description="Bodies that are inside each other are pushed apart slowly")
    progress: FloatProperty(name="Done", subtype="PERCENTAGE", min=0, max=100, precision=0, get=percent_done,
                            options={"HIDDEN", "SKIP_SAVE"})
    message: StringProperty(options={"HIDDEN", "SKIP_SAVE"})
    is_error: BoolProperty(options={"HIDDEN", "SKIP_SAVE"})


class UmaxPreferences(bpy.types.AddonPreferences):
    bl_idname = __package__
    program: StringProperty(name="Program", subtype="FILE_PATH", default="umax",
                            description="The program umax: its path, or its name where the system finds it")

    def draw(self, _):
        self.layout.prop(self, "program")


def preferences():
    return bpy.context.preferences.addons[__package__].preferences


classes = (UmaxPin, UmaxObject, UmaxScene, UmaxPreferences)


def register():
    for each in classes:
        bpy.utils.register_class(each)
    bpy.types.Object.umax = PointerProperty(type=UmaxObject)
    bpy.types.Scene.umax = PointerProperty(type=UmaxScene)


def unregister():
    del bpy.types.Object.umax
    del bpy.types.Scene.umax
    for each in reversed(classes):
        bpy.utils.unregister_class(each)
