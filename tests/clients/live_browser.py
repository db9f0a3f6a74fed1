"""The page of umax live in a real browser with software GL: what live_page.py and live_picture.py do with it."""
import contextlib
import signal
import subprocess
import time
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By


def until(what, check, seconds=60):
    """The first true value of check(). Seconds are for a machine that has much else to do."""
    end = time.time() + seconds
    while time.time() < end:
        found = check()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError("waited in vain: " + what)


def check(what, is_so):
    if not is_so:
        raise AssertionError(what)
    print("ok:", what, flush=True)


def open_browser():
    options = Options()
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader",
                     "--enable-unsafe-swiftshader", "--window-size=1280,800", "--force-device-scale-factor=1"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    return webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)


class Live:
    """The program, and what it says."""

    def __init__(self, program, scene, folder, *options):
        self.said = open(folder / "said.txt", "w+")
        self.process = subprocess.Popen([program, "live", str(scene), "-o", str(folder / "live"), "--no-browser", *options],
                                        stdout=self.said, stderr=subprocess.STDOUT, cwd=folder)

    def text(self):
        return Path(self.said.name).read_text()

    def address(self):
        """The newest one."""
        return until("an address", lambda: [word for word in self.text().split() if "?token=" in word])[-1]


class Page:
    def __init__(self, address):
        self.browser = open_browser()
        self.browser.get(address)
        until("a first picture", lambda: self.run("return Boolean(window.umaxLive && umaxLive.frame && umaxLive.hello && umaxLive.role)"))
        told = self.drawn()
        until("it is drawn", lambda: self.drawn() > told + 1)  # before that nothing is where a click would meet it

    def run(self, script, *arguments):
        return self.browser.execute_script(script, *arguments)

    def frame(self, name):
        return self.run("return umaxLive.frame[arguments[0]]", name)

    def height(self):
        """Of the surface's lowest vertex [m]."""
        return self.run("""
          const body = umaxLive.bodies[0], at = [0, 0, 0];
          let lowest = Infinity;
          for (let v = 0; v < body.vertexHex.length; ++v) body.place(v, at, 0), lowest = Math.min(lowest, at[1]);
          return lowest;""")

    def drawn(self):
        """How many times."""
        return self.run("return renderer.info.render.frame")

    def click(self, name):
        self.browser.find_element(By.ID, name).click()

    def choose(self, what, place):
        """Clicks at a point that place() tells, from the canvas's middle [px], until handles are there: a browser that is busy
        may see the click while the camera still moves."""
        canvas = self.browser.find_element(By.ID, "view")

        def chosen():
            x, y = place()
            ActionChains(self.browser).move_to_element_with_offset(canvas, int(x), int(y)).click().perform()
            end = time.time() + 2
            while time.time() < end and not self.run("return Boolean(handles.object)"):
                time.sleep(0.05)
            return self.run("return Boolean(handles.object)")

        until(what, chosen)

    def text(self, name):
        return self.browser.find_element(By.ID, name).text

    def is_playing(self):
        return self.run("return umaxLive.plays")

    def slide(self, selector, share):
        """Moves a slider to a share of its length, as a finger would."""
        self.run("const range = document.querySelector(arguments[0]); range.value = 1000 * arguments[1];"
                 "range.dispatchEvent(new Event('input', {bubbles: true}));", selector, share)

    def middle(self):
        """Where the body's middle is in the picture, from the canvas's middle [px]."""
        return self.run("""
          const body = umaxLive.frame.bodies[0], at = new THREE.Vector3(...body.low).add(new THREE.Vector3(...body.extent).multiplyScalar(0.5));
          at.project(camera);
          const canvas = document.getElementById('view');
          return [0.5 * at.x * canvas.clientWidth, -0.5 * at.y * canvas.clientHeight];""")

    def pixel(self, x, y):
        """A pixel of what is drawn, from the canvas's middle."""
        return self.run("""
          renderer.render(scene, camera);
          const gl = renderer.context || renderer.getContext(), pixel = new Uint8Array(4);
          gl.readPixels(gl.drawingBufferWidth / 2 + arguments[0], gl.drawingBufferHeight / 2 - arguments[1], 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
          return Array.from(pixel);""", x, y)

    def picture(self, folder, name):
        if folder:
            self.browser.save_screenshot(str(Path(folder) / name))

    def errors(self):
        return [entry["message"] for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE"]


@contextlib.contextmanager
def page_of(program, scene):
    """A live session of its own, and its page, in which no error may come up."""
    live = Live(program, scene, scene.parent)
    page = None
    try:
        page = Page(live.address())
        yield page
        check(f"no error in the browser {page.errors()}", not page.errors())
    finally:
        if page:
            page.browser.quit()
        live.process.send_signal(signal.SIGINT)
        live.process.wait(timeout=20)
