#!/usr/bin/python3
"""The add-on in Blender with its window, on a screen in memory (Xvfb): a bake tells its progress while Blender goes on with
other things, Cancel ends it and keeps what is done, and the next bake goes on from there.

usage: blender_addon_window.py PROGRAM ZIP [PICTURE_FOLDER]    PICTURE_FOLDER: where pictures of the panel go
"""
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import addon  # noqa: E402

INSIDE = r"""
import time, traceback
module = install()
operators = sys.modules[module.__name__ + ".operators"]

def children():
    '''processes that Blender has started and that still run'''
    found = []
    for process in filter(str.isdigit, os.listdir("/proc")):
        try:
            fields = open(f"/proc/{process}/stat").read().rsplit(")", 1)[1].split()
        except OSError:
            continue
        if int(fields[1]) == os.getpid() and fields[0] != "Z":
            found.append(int(process))
    return found

def call(operator, **words):
    '''as a button does it'''
    window = bpy.context.window_manager.windows[0]
    area = next(a for a in window.screen.areas if a.type == "VIEW_3D")
    region = next(r for r in area.regions if r.type == "WINDOW")
    with bpy.context.temp_override(window=window, area=area, region=region):
        return operator("INVOKE_DEFAULT", **words)

def show_panel():
    '''the physics properties in the left half of the window, beside the view'''
    window = bpy.context.window_manager.windows[0]
    view = next(a for a in window.screen.areas if a.type == "VIEW_3D")
    with bpy.context.temp_override(window=window, area=view):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.45)
    view.type = "PROPERTIES"
    yield 0.5
    view.spaces.active.context = "PHYSICS"
    return view

def picture(panel, name):
    '''of the panel, and, as NAME-window, of all that Blender shows'''
    if not job["pictures"]:
        return
    window = bpy.context.window_manager.windows[0]
    bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=1)
    with bpy.context.temp_override(window=window, area=panel):
        bpy.ops.screen.screenshot_area(filepath=f"{job['pictures']}/{name}.png")
        bpy.ops.screen.screenshot(filepath=f"{job['pictures']}/{name}-window.png")

def states():
    folder = job["folder"] + "/run/states"
    return {name: os.stat(folder + "/" + name).st_mtime_ns for name in sorted(os.listdir(folder))
            if name.endswith(".state")}

def watch(until):
    '''notes what the bake tells whenever Blender comes to other things'''
    seen = []
    while operators.running and not until(operators.running):
        seen.append([operators.running.stage, operators.running.done, operators.running.total])
        yield 0.02
    return seen

longest = [0, ""]  # processor time that a step of the bake keeps Blender from other things, and what it was at
step = sys.modules[module.__name__ + ".bake"].Bake.step

def timed_step(bake):
    start = time.thread_time()
    try:
        step(bake)
    finally:
        longest[:] = max(longest, [time.thread_time() - start, f"{bake.stage} {bake.done}"])

sys.modules[module.__name__ + ".bake"].Bake.step = timed_step

def course():
    scene, ball, box = make_scene()
    bpy.ops.wm.save_as_mainfile(filepath=os.path.dirname(job["folder"]) + "/scene.blend")
    scene.umax.folder = "//bake"
    scene.frame_end = 104
    ball.umax.cells = 12000  # which takes some seconds
    for thing in bpy.context.selected_objects:
        thing.select_set(False)
    ball.select_set(True)
    bpy.context.view_layer.objects.active = ball
    panel = yield from show_panel()
    yield 0.5
    picture(panel, "panel")
    told["invoked"] = list(call(bpy.ops.umax.bake))
    told["refused_twice"] = not bpy.ops.umax.bake.poll()
    told["seen"] = yield from watch(lambda bake: bake.stage == "Simulating" and bake.done >= 25)
    told["children_while"] = len(children())
    picture(panel, "progress")
    told["before_cancel"] = operators.running is not None
    call(bpy.ops.umax.cancel)
    yield 0.3
    told["running_after"] = operators.running is not None
    told["children_after"] = len(children())
    told["message"] = scene.umax.message
    told["states"] = [states()]
    told["frame"] = scene.frame_current
    told["modifiers"] = [m.name for m in ball.modifiers]
    call(bpy.ops.umax.bake)
    told["seen_again"] = yield from watch(lambda bake: False)
    told["longest"] = longest
    told["states"].append(states())
    told["message_again"] = scene.umax.message
    told["modifiers_again"] = [m.name for m in ball.modifiers]
    told["path"] = ball.modifiers["umax"].filepath if "umax" in ball.modifiers else ""
    scene.frame_set(40)
    told["height"] = min(z for _, _, z in world_points(box))
    module_preferences = bpy.context.preferences.addons[module.__name__].preferences
    module_preferences.program = "/nowhere/umax"
    try:
        call(bpy.ops.umax.bake)
        yield from watch(lambda bake: False)
    except RuntimeError:
        pass
    told["error"] = [scene.umax.message, scene.umax.is_error]
    yield 0.3
    picture(panel, "error")

def run_course():
    steps = course()
    def tick():
        try:
            return next(steps)
        except StopIteration:
            pass
        except BaseException:
            told["failed"] = traceback.format_exc()
        tell()
        bpy.ops.wm.quit_blender()
        return None
    bpy.app.timers.register(tick, first_interval=1.0)

run_course()
"""


def test(program, zip_file, folder, pictures):
    blender = addon.Blender(program, zip_file, folder)
    with addon.Screen() as screen:
        told = blender.run(INSIDE, "--window-geometry", "0", "0", "1500", "1100", environment={"DISPLAY": screen},
                           pictures=pictures)
    assert "failed" not in told, told["failed"]
    assert told["invoked"] == ["RUNNING_MODAL"] and told["refused_twice"]

    counts = [done for stage, done, _ in told["seen"] if stage == "Simulating"]
    assert counts == sorted(counts) and len(set(counts)) >= 4, counts
    assert {total for stage, _, total in told["seen"] if stage == "Simulating"} == {100}
    assert len(counts) >= 8, "Blender came to other things so often while umax simulated"
    assert told["longest"][0] < 0.5, told["longest"]

    assert told["children_while"] == 1 and told["before_cancel"]
    assert not told["running_after"] and told["children_after"] == 0
    assert told["message"].startswith("Cancelled: Simulating"), told["message"]
    assert told["modifiers"] == ["smooth"] and told["frame"] == 1
    first, all_states = told["states"]
    assert 25 <= len(first) < 100, len(first)
    assert len(all_states) == 100 and all(all_states[name] == time for name, time in first.items())
    assert told["message_again"].startswith("100 frames of 2 bodies"), told["message_again"]
    assert told["modifiers_again"] == ["umax", "smooth"] and told["path"] == "//bake/caches/My_Ball.pc2", told["path"]
    assert -0.01 < told["height"] < 0.4, told["height"]  # the box lies on the floor
    assert "/nowhere/umax" in told["error"][0] and told["error"][1]


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary:
        test(sys.argv[1], sys.argv[2], Path(temporary), str(Path(sys.argv[3]).resolve()) if len(sys.argv) > 3 else "")
    print("passed")
