#!/usr/bin/python3
"""Looks at the page of umax live as a user does, in a real browser with software GL: it opens, moves, a slider changes the
limit and the readout obeys, pulling lifts the body, going back and on works, what is saved gives the same bytes, a second
browser watches, reloading reconnects, and nothing comes from elsewhere.

usage: live_page.py PROGRAM [SCREENSHOTS]    needs the packages of tools/packages.test
"""
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

from live_browser import Live, Page, check, page_of, until

SCENE = """[clip]
frames = 60
[body.ball]
shape = "sphere"
radius = 0.4
position = [0, 0.9, 0]
cage.cells = 60
material.young = "60 kPa"
material.damping_stiffness = 0.002
limit.stretch = "30 %"
look.color = "#c05030"
[obstacle.block]
shape = "box"
size = [0.3, 0.3, 0.3]
position = [-0.9, 0.15, 0]
[obstacle.ground]
shape = "plane"
friction = 0.5
"""
SLIDER = "input[data-key='body.ball.limit.stretch']"


def shows_body(page):
    """Is the red ball where the page says that it is? While it moves, the picture may be a frame behind."""
    red, _, blue, _ = page.pixel(*page.middle())
    return red > 1.4 * blue and red > 60


def test_opening(page):
    check("the page tells the scene", page.text("name") == "ball" and "hexes" in page.text("size"))
    check("the cookie is out of reach of scripts", page.run("return document.cookie") == "")
    hosts = page.run("return performance.getEntriesByType('resource').map(entry => new URL(entry.name).host)")
    check("nothing comes from elsewhere", set(hosts) == {page.run("return location.host")})
    until("the body drawn in its colour", lambda: shows_body(page))
    check("nothing stands where nothing is", max(page.pixel(-400, -300)[:3]) < 60)


def test_motion(page):
    before = page.height()
    page.click("step")
    until("one step", lambda: page.frame("step") == 1)
    page.click("play")
    until("the fall", lambda: page.height() < before - 0.2)
    until("lying on the ground", lambda: page.frame("time") > 2.5 and page.frame("contacts") > 0 and abs(page.height()) < 0.01)
    until("the word for it", lambda: page.text("status") == "converged")
    check("it falls, and the ground holds it", True)


def test_slider(page):
    page.slide(SLIDER, 0)
    until("the goal", lambda: page.run("return umaxLive.sliders[0].goal") == 0.005)
    until("a ghost of where the limit is", lambda: "falling" in page.browser.find_element(By.CSS_SELECTOR, ".key .now").text)
    values = []
    until("the limit at its goal", lambda: values.append(page.run("return umaxLive.sliders[0].value")) or values[-1] == 0.005)
    check("the limit falls gradually", len([value for value in values if 0.005 < value < 0.3]) >= 2 and values == sorted(values, reverse=True))
    box = page.browser.find_element(By.CSS_SELECTOR, "input[type=text][aria-label='body.ball.limit.stretch']")
    check("the readout obeys", float(box.get_attribute("value")) == 0.5)
    until("hexes at their limit", lambda: page.frame("limits") > 0)
    ratios = [page.frame("ratio") for _ in range(20)]
    check("no hex exceeds it by more than 0.1 %", max(ratios) <= 1.001)
    box.send_keys(Keys.CONTROL, "a")
    box.send_keys("35 %", Keys.ENTER)
    until("what was typed", lambda: page.run("return umaxLive.sliders[0].value") == 0.35)
    page.run("document.activeElement.blur()")


def test_no_limit(program, folder):
    """A ball without a limit is given one while it moves, and loses it again."""
    folder.mkdir()
    lines = [line for line in SCENE.splitlines() if not line.startswith("limit.")]
    check("there was a limit", len(lines) < len(SCENE.splitlines()))
    (folder / "soft.toml").write_text("\n".join(lines))
    with page_of(program, folder / "soft.toml") as page:
        box = page.browser.find_element(By.CSS_SELECTOR, "input[type=text][aria-label='body.ball.limit.stretch']")
        check("a limit that is not there is none", box.get_attribute("value") == "none")
        page.click("play")
        until("it lies on the ground", lambda: page.frame("contacts") > 0)
        check("no hex is at a limit", page.frame("limits") == 0)
        page.slide("input[type=range][data-key='body.ball.limit.stretch']", 0)
        until("the limit at its goal", lambda: page.run("return umaxLive.sliders[0].value") == 0.005)
        until("hexes at their limit", lambda: page.frame("limits") > 0)
        box.send_keys(Keys.CONTROL, "a")
        box.send_keys("none", Keys.ENTER)
        until("none again", lambda: page.run("return umaxLive.sliders[0].value") == 10 and page.frame("limits") == 0)
        check("which the readout says", box.get_attribute("value") == "none")


def test_pin(program, folder):
    """The mark of a pin is dragged, and its body comes along."""
    folder.mkdir()
    pin = "pin.top.box = { min = [-1, 1.15, -1], max = [1, 2, 1] }\nlook.color"
    (folder / "held.toml").write_text(SCENE.replace("look.color", pin))
    with page_of(program, folder / "held.toml") as page:
        page.click("play")
        page.choose("handles at the pin", lambda: page.run("""
          const at = new THREE.Vector3(...umaxLive.hello.pins[0].place).project(camera), canvas = document.getElementById('view');
          return [0.5 * at.x * canvas.clientWidth, -0.5 * at.y * canvas.clientHeight];"""))
        check("they are the pin's", page.run("return umaxLive.chosen === 2"))
        lowest = page.height()
        page.run("handle.position.y += 0.3; live.placed = live.places = true;")  # as dragging does
        until("the body comes along", lambda: page.height() > lowest + 0.2)
        mark = "return umaxLive.obstacles[2].matrix.elements[13] - umaxLive.hello.pins[0].place[1]"
        until("and the mark", lambda: abs(page.run(mark) - 0.3) < 1e-3)
        check("a pin is moved by its handle, and leads its body", True)


def test_pull(page, pictures):
    resting = page.height()
    x, y = page.middle()
    canvas = page.browser.find_element(By.ID, "view")
    chain = ActionChains(page.browser)
    chain.move_to_element_with_offset(canvas, int(x), int(y)).click_and_hold()
    for _ in range(6):
        chain.move_by_offset(0, -40).pause(0.1)
    chain.perform()
    until("the body in the air", lambda: page.height() > resting + 0.15)
    page.picture(pictures, "live-pull.png")
    ActionChains(page.browser).release().perform()
    until("letting go", lambda: not page.frame("flags") & 4)
    until("the body back", lambda: page.height() < resting + 0.05)
    check("a pull lifts the body, and letting go drops it", True)


def test_obstacle(page, pictures):
    place = "return umaxLive.obstacles[0].matrix.elements.slice(12, 15)"
    on_screen = """
      const at = new THREE.Vector3(...arguments[0]);
      const canvas = document.getElementById('view');
      at.project(camera);
      return [0.5 * at.x * canvas.clientWidth, -0.5 * at.y * canvas.clientHeight];"""
    canvas = page.browser.find_element(By.ID, "view")
    page.click("restart")  # the ball may have rolled in front of it
    until("a new start", lambda: page.frame("time") < 2 and page.is_playing())
    before = page.run(place)
    page.choose("handles", lambda: page.run(on_screen, before))
    reach = page.run("return 0.7 * camera.position.distanceTo(handle.position) * handles.size / 7")
    x, y = page.run(on_screen, [before[0] + reach, before[1], before[2]])
    page.picture(pictures, "live-handles.png")

    def drag():  # again where the browser was too busy to see the pointer come before it was pressed
        chain = ActionChains(page.browser).move_to_element_with_offset(canvas, int(x) + 3, int(y)).pause(0.5)
        chain.move_to_element_with_offset(canvas, int(x), int(y)).pause(0.5).click_and_hold()
        for _ in range(5):
            chain.move_by_offset(-12, 0).pause(0.1)
        chain.release().perform()
        time.sleep(1)
        return page.run(place)[0] < before[0] - 0.1

    until("the obstacle elsewhere", drag)
    after = page.run(place)
    check("an obstacle is moved along its handle", abs(after[1] - before[1]) < 1e-3 and abs(after[2] - before[2]) < 1e-3)
    ActionChains(page.browser).move_to_element_with_offset(canvas, -380, -100).click().perform()
    until("no handles", lambda: page.run("return !handles.object"))


def test_looks(page, pictures):
    for value, name in ((1, "energy"), (2, "stretch"), (3, "multiplier")):
        page.run("document.querySelector('input[name=heat][value=\"%d\"]').click()" % value)
        time.sleep(0.4)
        check(f"{name} has a legend", page.run("return !document.getElementById('legend').hidden"))
        page.picture(pictures, f"live-{name}.png")
    page.run("document.getElementById('cage').click(); document.getElementById('touch').click()")
    time.sleep(0.4)
    page.picture(pictures, "live-cage.png")
    page.run("document.querySelector('input[name=heat][value=\"0\"]').click(); document.getElementById('cage').click()")


def test_past(page):
    page.click("play")
    until("a pause", lambda: not page.is_playing())
    last = page.frame("frame")
    page.run("const range = document.getElementById('scrub'); range.value = 10; range.dispatchEvent(new Event('input'))")
    until("the past", lambda: page.frame("frame") == 10)
    until("words on it", lambda: page.text("status") == "looking back")
    page.click("goon")
    until("another present", lambda: page.is_playing() and 10 < page.frame("frame") < last)
    until("a second of it", lambda: page.frame("time") > 1.2)
    check("it goes on from there", True)


def test_people(page, live):
    second = Page(live.address())
    try:
        check("the second browser watches", not second.run("return umaxLive.steers") and page.run("return umaxLive.steers"))
        check("and cannot press play", second.run("return document.getElementById('play').disabled"))
        now = second.frame("time")
        until("the same motion", lambda: second.frame("time") > now)
        second.click("steer")
        until("the wheel handed over", lambda: second.run("return umaxLive.steers") and not page.run("return umaxLive.steers"))
    finally:
        second.browser.quit()
    until("the wheel back", lambda: page.run("return umaxLive.steers"))
    page.browser.refresh()
    until("pictures after reloading", lambda: page.run("return window.umaxLive && umaxLive.frame !== null && umaxLive.hello !== null"))
    now = page.frame("time")
    until("motion after reloading", lambda: page.frame("time") > now)
    check("reloading reconnects", True)


def pause(page):
    """The frame at which it stands still. Right after a page is loaded, what it says of playing may be of before."""
    for _ in range(5):
        if page.is_playing():
            page.click("play")
            until("a pause", lambda: not page.is_playing())
        frame = page.frame("frame")
        time.sleep(1)
        if page.frame("frame") == frame and not page.is_playing():
            return frame
    raise AssertionError("waited in vain: a pause that lasts")


def test_cage(page, pictures):
    """Another cage restarts, which is said, with the values of the moment."""
    field = "input[aria-label='body.ball.cage.cells']"
    find = lambda: page.browser.find_element(By.CSS_SELECTOR, field)
    before, limit = int(find().get_attribute("value")), page.run("return umaxLive.sliders[0].goal")
    nodes = page.run("return umaxLive.bodies[0].numNodes")
    find().send_keys(Keys.CONTROL, "a")
    find().send_keys("many", Keys.ENTER)
    until("a refusal", lambda: "a cage has 1 to" in page.text("toast"))
    check("which changes nothing", int(find().get_attribute("value")) == before)
    find().send_keys(Keys.CONTROL, "a")
    find().send_keys("200", Keys.ENTER)
    until("another cage", lambda: page.run("return umaxLive.hello && umaxLive.frame && umaxLive.bodies[0].numNodes") not in (None, nodes))
    until("the word for it", lambda: "everything starts again" in page.text("toast"))
    now = int(find().get_attribute("value"))
    check(f"it has about as many hexes as were asked for ({now})", 150 < now < 250 and str(now) in page.text("size"))
    check("values stay as they were", page.run("return umaxLive.sliders[0].goal") == limit)
    until("it falls again", lambda: 0.1 < page.frame("time"))
    until("and lies on the ground", lambda: page.frame("contacts") > 0 and page.height() > -0.01)
    until("the body drawn with it", lambda: shows_body(page))
    page.run("document.activeElement.blur()")
    page.picture(pictures, "live-other-cage.png")


def test_saving(page, program, folder):
    frames = pause(page)
    page.click("save")
    until("the scene saved", lambda: "session-01.toml" in page.text("toast"))
    page.click("render")
    until("the session as a run", lambda: "umax render" in page.text("toast"))
    page.click("lines")
    until("lines of the scene", lambda: "body.ball.limit.stretch = 0.35" in page.text("toast"))
    check("the cage is among them", "body.ball.cage.cells = 200" in page.text("toast"))
    again = folder / "again"
    subprocess.run([program, "simulate", str(folder / "live/session-01.toml"), "-o", str(again), "--quiet"], check=True)
    states = sorted((again / "states").iterdir())
    run = folder / "live/session-02/states"
    check(f"all {frames} frames are there", len(states) == frames == len(list(run.iterdir())))
    check("what was saved gives the same bytes", all(state.read_bytes() == (run / state.name).read_bytes() for state in states))
    subprocess.run([program, "render", str(run.parent), "--frames", "5", "--size", "64x36", "--samples", "1", "--quiet"], check=True)
    check("the session is rendered", (run.parent / "frames/0005.png").exists())


def main(program, pictures=None):
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "ball.toml").write_text(SCENE)
        live = Live(program, folder / "ball.toml", folder)
        page = None
        try:
            page = Page(live.address())
            test_opening(page)
            test_motion(page)
            test_slider(page)
            test_looks(page, pictures)
            test_pull(page, pictures)
            test_obstacle(page, pictures)
            test_past(page)
            test_people(page, live)
            test_cage(page, pictures)
            test_saving(page, program, folder)
            check(f"no error in the browser {page.errors()}", not page.errors())
        except BaseException:
            print(live.text(), page and page.errors(), file=sys.stderr)
            if page:
                page.picture(os.environ.get("UMAX_KEEP_PICTURES"), "failed.png")
            raise
        finally:
            if page:
                page.browser.quit()
            live.process.send_signal(signal.SIGINT)
            code = live.process.wait(timeout=20)
        test_no_limit(program, folder / "soft")
        test_pin(program, folder / "held")
        check(f"Ctrl-C ends it with 130, not {code}, and keeps the session", code == 130 and "session-03.toml" in live.text())


if __name__ == "__main__":
    main(*sys.argv[1:])
