"""The panels: an object's part in the simulation, and the bake. In the physics properties and the 3D viewport's sidebar."""
import textwrap

import bpy

from . import operators, presets


def draw_object(layout, thing):
    settings = thing.umax
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(settings, "role")
    if settings.role == "BODY":
        draw_body(layout, thing, settings)
    elif settings.role == "COLLIDER":
        layout.prop(settings, "shape")
        layout.prop(settings, "friction")


def draw_body(layout, thing, settings):
    if thing.type != "MESH":
        layout.label(text="Only meshes can be soft bodies", icon="ERROR")
        return
    layout.menu("UMAX_MT_presets")
    column = layout.column(align=True)
    column.prop(settings, "limit")
    part = column.column(align=True)
    part.active = settings.limit != "none"
    part.prop(settings, "stretch")
    column = layout.column(align=True)
    for name in ("stiffness", "poisson", "density"):
        column.prop(settings, name)
    column = layout.column(align=True)
    for name in ("damping", "drag"):
        column.prop(settings, name)
    layout.prop(settings, "cells")
    column = layout.column(align=True)
    for name in ("friction", "touches"):
        column.prop(settings, name)


def draw_maps(layout, thing):
    settings = thing.umax
    layout.use_property_split = True
    layout.use_property_decorate = False
    for kind in ("limit", "stiffness"):
        column = layout.column(align=True)
        column.prop_search(settings, f"{kind}_group", thing, "vertex_groups")
        row = column.row(align=True)
        row.active = bool(getattr(settings, f"{kind}_group"))
        row.prop(settings, f"{kind}_range")


def draw_choice(layout, settings, choice, names):
    """a choice, and what belongs to it once it is taken"""
    row = layout.row(align=True)
    row.prop(settings, choice)
    if getattr(settings, choice):
        for name in names:
            row.prop(settings, name, text="")


def draw_pins(layout, thing):
    for index, pin in enumerate(thing.umax.pins):
        row = layout.row(align=True)
        row.prop_search(pin, "group", thing, "vertex_groups", text="")
        row.prop(pin, "target", text="")
        row.operator("umax.remove_pin", text="", icon="X").index = index
        draw_choice(layout, pin, "is_timed", ("first_frame", "last_frame"))
        draw_choice(layout, pin, "is_spring", ("spring",))
    layout.operator("umax.add_pin", icon="PINNED")


def draw_start(layout, thing):
    layout.use_property_split = True
    layout.use_property_decorate = False
    layout.prop(thing.umax, "velocity")
    layout.prop(thing.umax, "spin")


def draw_bake(layout, context):
    scene = context.scene
    running = operators.running
    if running:
        draw_progress(layout, running, scene.umax)
    else:
        row = layout.row(align=True)
        row.scale_y = 1.4
        row.operator("umax.bake", icon="PHYSICS")
        row.operator("umax.free", icon="TRASH")
    draw_message(layout, scene.umax, context.region.width)
    column = layout.column()
    column.use_property_split = True
    column.use_property_decorate = False
    column.active = running is None
    for name in ("folder", "substeps", "samples", "overlap"):
        column.prop(scene.umax, name)


def draw_progress(layout, running, settings):
    text = f"{running.stage}: {running.done} of {running.total}"
    if running.left is not None:
        text += f", {running.left:.0f} s left"
    row = layout.row(align=True)
    row.scale_y = 1.4
    row.prop(settings, "progress", text=text, slider=True)
    row.operator("umax.cancel", icon="CANCEL", text="Cancel")


def draw_message(layout, settings, width):
    if not settings.message:
        return
    box = layout.box()
    box.alert = settings.is_error
    column = box.column(align=True)
    lines = [line for part in settings.message.splitlines() for line in textwrap.wrap(part, max(20, width // 7))]
    for index, line in enumerate(lines[:12]):
        column.label(text=line, icon=("ERROR" if settings.is_error else "INFO") if index == 0 else "BLANK1")


class UMAX_MT_presets(bpy.types.Menu):
    """Materials with stiffness, density, damping and limit"""
    bl_idname = "UMAX_MT_presets"
    bl_label = "Material"

    def draw(self, _):
        names = presets.names()
        for name, description in names:
            self.layout.operator("umax.preset", text=f"{name.replace('_', ' ')}: {description}").name = name
        if not names:
            self.layout.label(text="the program umax is not there: see the add-on's preferences", icon="ERROR")


class PhysicsPanel:
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "physics"


class SidebarPanel:
    bl_space_type, bl_region_type, bl_category = "VIEW_3D", "UI", "umax"


class ObjectPanel:
    bl_label = "umax"

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type in {"MESH", "CURVE", "SURFACE", "FONT", "META"}

    def draw(self, context):
        draw_object(self.layout, context.object)


class BodyPanel:
    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "MESH" and context.object.umax.role == "BODY"


class MapsPanel(BodyPanel):
    bl_label = "Maps"

    def draw(self, context):
        draw_maps(self.layout, context.object)


class PinsPanel(BodyPanel):
    bl_label = "Pins"

    def draw(self, context):
        draw_pins(self.layout, context.object)


class StartPanel(BodyPanel):
    bl_label = "At the First Frame"

    def draw(self, context):
        draw_start(self.layout, context.object)


class BakePanel:
    bl_label = "Bake"

    def draw(self, context):
        draw_bake(self.layout, context)


class UMAX_PT_physics(PhysicsPanel, ObjectPanel, bpy.types.Panel):
    pass


class UMAX_PT_physics_maps(PhysicsPanel, MapsPanel, bpy.types.Panel):
    bl_parent_id = "UMAX_PT_physics"
    bl_options = {"DEFAULT_CLOSED"}


class UMAX_PT_physics_pins(PhysicsPanel, PinsPanel, bpy.types.Panel):
    bl_parent_id = "UMAX_PT_physics"
    bl_options = {"DEFAULT_CLOSED"}


class UMAX_PT_physics_start(PhysicsPanel, StartPanel, bpy.types.Panel):
    bl_parent_id = "UMAX_PT_physics"
    bl_options = {"DEFAULT_CLOSED"}


class UMAX_PT_physics_bake(PhysicsPanel, BakePanel, bpy.types.Panel):
    bl_parent_id = "UMAX_PT_physics"


class UMAX_PT_sidebar(SidebarPanel, ObjectPanel, bpy.types.Panel):
    bl_label = "Object"


class UMAX_PT_sidebar_maps(SidebarPanel, MapsPanel, bpy.types.Panel):
    bl_parent_id = "UMAX_PT_sidebar"
    bl_options = {"DEFAULT_CLOSED"}


class UMAX_PT_sidebar_pins(SidebarPanel, PinsPanel, bpy.types.Panel):
    bl_parent_id = "UMAX_PT_sidebar"
    bl_options = {"DEFAULT_CLOSED"}


class UMAX_PT_sidebar_start(SidebarPanel, StartPanel, bpy.types.Panel):
    bl_parent_id = "UMAX_PT_sidebar"
    bl_options = {"DEFAULT_CLOSED"}


class UMAX_PT_sidebar_bake(SidebarPanel, BakePanel, bpy.types.Panel):
    pass


classes = (UMAX_MT_presets, UMAX_PT_physics, UMAX_PT_physics_maps, UMAX_PT_physics_pins, UMAX_PT_physics_start, UMAX_PT_physics_bake,
           UMAX_PT_sidebar, UMAX_PT_sidebar_maps, UMAX_PT_sidebar_pins,
           UMAX_PT_sidebar_start, UMAX_PT_sidebar_bake)


def register():
    for each in classes:
        bpy.utils.register_class(each)


def unregister():
    for each in reversed(classes):
        bpy.utils.unregister_class(each)
