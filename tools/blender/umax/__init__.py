"""Soft bodies with energy limits, baked by the program umax: panel, bake, Mesh Cache. docs/blender.md tells how to use it."""
bl_info = {
    "name": "umax",
    "author": "The umax authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "Properties > Physics, and 3D Viewport > Sidebar > umax",
    "description": "Soft bodies that stop deforming exactly where you say",
    "category": "Physics",
}

from . import operators, panels, settings  # noqa: E402

modules = (settings, operators, panels)


def register():
    for module in modules:
        module.register()


def unregister():
    for module in reversed(modules):
        module.unregister()
