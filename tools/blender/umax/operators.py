"""What buttons do: bake, cancel, free, presets, pins."""
import time

import bpy
from bpy.props import IntProperty, StringProperty

from . import bake, presets, program

STEP_SECONDS = 0.04   # of work between two looks at the user's input
TIMER_SECONDS = 0.05
running = None        # the bake that goes on


def tell(scene, message, is_error=False):
    scene.umax.message, scene.umax.is_error = message, is_error


def redraw():
    """the panels, and nothing of the 3D views"""
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            for region in area.regions if area.type in {"PROPERTIES", "VIEW_3D"} else ():
                if region.type == ("WINDOW" if area.type == "PROPERTIES" else "UI"):
                    region.tag_redraw()


def stop_running():
    global running
    if running:
        running.close()
    running = None


class UMAX_OT_bake(bpy.types.Operator):
    """Simulate the soft bodies of this scene and give each its motion as a Mesh Cache. What has not changed is not made again"""
    bl_idname = "umax.bake"
    bl_label = "Bake"

    @classmethod
    def poll(cls, _):
        return running is None

    def execute(self, context):
        """all at once: for scripts and for Blender without a window"""
        if not self.start(context):
            return {"CANCELLED"}
        try:
            while not running.is_done:
                running.step()
                if running.is_waiting:
                    time.sleep(0.02)
        except bake.EXPECTED as error:
            return self.fail(error)
        finally:
            message = running.message
            stop_running()
        return self.succeed(message)

    def invoke(self, context, _):
        if not self.start(context):
            return {"CANCELLED"}
        self.shown = None
        self.timer = context.window_manager.event_timer_add(TIMER_SECONDS, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """a little work at each tick; all other events are Blender's"""
        if running is None:  # cancelled, or another file was opened
            context.window_manager.event_timer_remove(self.timer)
            redraw()
            return {"CANCELLED"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        try:
            end = time.monotonic() + STEP_SECONDS
            running.step()
            while not running.is_done and not running.is_waiting and time.monotonic() < end:
                running.step()
        except bake.EXPECTED as error:
            context.window_manager.event_timer_remove(self.timer)
            stop_running()
            redraw()
            return self.fail(error)
        if not running.is_done:
            if self.shown != (running.stage, running.done):
                self.shown = (running.stage, running.done)
                redraw()
            return {"PASS_THROUGH"}
        redraw()
        context.window_manager.event_timer_remove(self.timer)
        message = running.message
        stop_running()
        return self.succeed(message)

    def start(self, context):
        global running
        self.scene_name = context.scene.name
        tell(context.scene, "")
        try:
            running = bake.Bake(context.scene)
        except bake.EXPECTED as error:
            self.fail(error)
            return False
        return True

    def scene(self):
        return bpy.data.scenes.get(self.scene_name, bpy.context.scene)

    def fail(self, error):
        tell(self.scene(), str(error), True)
        self.report({"ERROR"}, str(error))
        return {"CANCELLED"}

    def succeed(self, message):
        tell(self.scene(), message)
        self.report({"WARNING" if "\n" in message else "INFO"}, f"umax: {message}")
        return {"FINISHED"}


class UMAX_OT_cancel(bpy.types.Operator):
    """Stop the bake. What is simulated is kept: the next bake of the same goes on from there"""
    bl_idname = "umax.cancel"
    bl_label = "Cancel"

    @classmethod
    def poll(cls, _):
        return running is not None

    def execute(self, context):
        stage, done, total = running.stage, running.done, running.total
        stop_running()
        tell(context.scene, f"Cancelled: {stage}, {done} of {total}")
        redraw()
        return {"FINISHED"}


class UMAX_OT_free(bpy.types.Operator):
    """Take the motion off all bodies of this scene and delete the files of the bake"""
    bl_idname = "umax.free"
    bl_label = "Free"

    @classmethod
    def poll(cls, _):
        return running is None

    def execute(self, context):
        try:
            count = bake.free(context.scene)
        except bake.EXPECTED as error:
            tell(context.scene, str(error), True)
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        tell(context.scene, f"Freed {bake.counted(count)}")
        return {"FINISHED"}


class UMAX_OT_preset(bpy.types.Operator):
    """Set stiffness, density, damping and limit as of this material"""
    bl_idname = "umax.preset"
    bl_label = "Material"
    bl_options = {"REGISTER", "UNDO"}
    name: StringProperty()

    def execute(self, context):
        try:
            presets.apply(self.name, context.object.umax)
        except program.ProgramError as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class UMAX_OT_add_pin(bpy.types.Operator):
    """Let points of this body follow an animation"""
    bl_idname = "umax.add_pin"
    bl_label = "Add Pin"
    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        context.object.umax.pins.add()
        return {"FINISHED"}


class UMAX_OT_remove_pin(bpy.types.Operator):
    """Remove this pin"""
    bl_idname = "umax.remove_pin"
    bl_label = "Remove Pin"
    bl_options = {"REGISTER", "UNDO"}
    index: IntProperty()

    def execute(self, context):
        context.object.umax.pins.remove(self.index)
        return {"FINISHED"}


@bpy.app.handlers.persistent
def before_other_file(*_):
    stop_running()


classes = (UMAX_OT_bake, UMAX_OT_cancel, UMAX_OT_free, UMAX_OT_preset, UMAX_OT_add_pin, UMAX_OT_remove_pin)


def register():
    for each in classes:
        bpy.utils.register_class(each)
    bpy.app.handlers.load_pre.append(before_other_file)


def unregister():
    stop_running()
    bpy.app.handlers.load_pre.remove(before_other_file)
    for each in reversed(classes):
        bpy.utils.unregister_class(each)
