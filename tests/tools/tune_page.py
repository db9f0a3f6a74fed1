#!/usr/bin/python3
"""Looks at tune.html as a user does, in a real browser: nothing comes from a network, panes are in step, wipe, difference,
keyboard, table and snippet do what they should.

usage: tune_page.py PROGRAM [SCREENSHOTS]    needs the packages of tools/packages.test
"""
import base64
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.ui import Select

BODY = """[clip]
frames = 20
substeps = 2
[body.block]
{lines}shape = "box"
size = [0.4, 0.4, 0.4]
position = [0, 0.24, 0]
rotation = [10, 0, 20]
cage.cells = [2, 2, 2]
look.color = "#c03020"
[obstacle.ground]
shape = "plane"
"""
SIZE = (96, 54)

# mean difference, in codes of 255, of a region [x0, x1) of a canvas and of what is made of one or two pictures
COMPARE = """
const [canvas, urls, kind, x0, x1, done] = arguments;
const load = url => new Promise(ok => { const image = new Image(); image.onload = () => ok(image); image.src = url; });
Promise.all(urls.map(load)).then(images => {
  const {width, height} = canvas;
  const codes = image => {
    const other = document.createElement("canvas");
    [other.width, other.height] = [width, height];
    const context = other.getContext("2d");
    context.drawImage(image, 0, 0, width, height);
    return context.getImageData(0, 0, width, height).data;
  };
  const [a, b] = images.map(codes), found = codes(canvas);
  let sum = 0, count = 0;
  for (let y = 0; y < height; ++y)
    for (let x = x0; x < x1; ++x)
      for (let c = 0; c < 3; ++c, ++count) {
        const i = 4 * (y * width + x) + c;
        const wanted = kind === "difference" ? Math.abs(a[i] - b[i]) : a[i];
        sum += Math.abs(found[i] - wanted);
      }
  done(sum / count);
});
"""


def check(condition, what):
    if not condition:
        sys.exit(f"FAILED: {what}")


def run(program, *words):
    result = subprocess.run([program, *map(str, words)], capture_output=True, text=True)
    check(result.returncode == 0, f"umax {' '.join(map(str, words))}: {result.returncode}: {result.stderr}")


def start_browser(profile):
    options = Options()
    for word in ("headless", "no-sandbox", "disable-gpu", "disable-quic", "no-first-run", "disable-dev-shm-usage",
                 "disable-background-networking", "disable-component-update", "disable-sync", "disable-extensions",
                 "window-size=1366,900", f"user-data-dir={profile}"):
        options.add_argument("--" + word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    return webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)


class Page:
    def __init__(self, browser, folder):
        self.browser, self.folder = browser, folder
        self.record = json.loads((folder / "tune.json").read_text())
        browser.get((folder / "tune.html").as_uri())
        self.wait(lambda: self.dataset("ready") == "yes" and self.dataset("drawn"), "the page gets ready")

    def wait(self, condition, what):
        end = time.monotonic() + 10
        while not condition():
            check(time.monotonic() < end, f"in ten seconds: {what}")
            time.sleep(0.02)

    def find(self, selector):
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def find_all(self, selector):
        return self.browser.find_elements(By.CSS_SELECTOR, selector)

    def dataset(self, name):
        return self.browser.execute_script("return document.body.dataset[arguments[0]]", name)

    def value(self, selector):
        return int(self.find(selector).get_attribute("value"))

    def keys(self, *keys):
        self.find("body").send_keys(*keys)

    def scrub(self, frame):
        self.browser.execute_script(
            "const s = document.getElementById('scrubber'); s.value = arguments[0]; s.dispatchEvent(new Event('input'))",
            frame)
        self.wait(lambda: self.dataset("drawn") == str(frame), f"frame {frame} is drawn")

    def picture(self, variant, frame):
        name = self.record["variants"][variant]["name"]
        png = (self.folder / "runs" / name / "frames" / f"{frame:04}.png").read_bytes()
        return "data:image/png;base64," + base64.b64encode(png).decode()

    def difference(self, canvas, pictures, kind="same", x0=0, x1=SIZE[0]):
        self.browser.set_script_timeout(10)
        return self.browser.execute_async_script(COMPARE, canvas, pictures, kind, x0, x1)

    def brightness(self, selector):
        return self.browser.execute_script("""
            const [canvas] = arguments;
            const codes = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
            return codes.reduce((sum, code, i) => sum + (i % 4 === 3 ? 0 : code), 0);""", self.find(selector))

    def view(self, selector, pictures, what, **how):
        """What is drawn comes to be what it should be, but for the losses of WebP."""
        self.wait(lambda: self.difference(self.find(selector), pictures, **how) < 4, what)


def test_in_step(page):
    for frame in (1, 7, 20):
        page.scrub(frame)
        panes = page.find_all("#grid canvas")
        check(len(panes) == 4, "four panes")
        for index, pane in enumerate(panes):
            check(pane.get_attribute("data-frame") == str(frame), f"pane {index} is at frame {frame}")
            check(page.difference(pane, [page.picture(index, frame)]) < 4, f"pane {index} shows frame {frame}")
            other = 20 if frame < 15 else 1
            check(page.difference(pane, [page.picture(index, other)]) > 4, f"pane {index} does not show frame {other}")
        times = [float(cursor.get_attribute("data-time")) for cursor in page.find_all(".cursor")]
        check(len(times) == 3 and all(abs(t - (frame - 1) / 60) < 1e-9 for t in times), "cursors follow the scrubber")


def test_keyboard(page):
    page.scrub(5)
    page.keys(Keys.ARROW_RIGHT)
    check(page.value("#scrubber") == 6, "right: one frame on")
    page.keys(Keys.ARROW_LEFT, Keys.ARROW_LEFT)
    check(page.value("#scrubber") == 4, "left: one frame back")
    page.keys(Keys.SHIFT, Keys.ARROW_RIGHT)
    check(page.value("#scrubber") == 14, "shift and right: ten frames on")
    page.keys("3")
    chosen = [pane.get_attribute("aria-pressed") for pane in page.find_all(".pane")]
    check(chosen == ["false", "false", "true", "false"], "3 chooses the third variant")
    page.keys(" ")
    page.wait(lambda: page.value("#scrubber") != 14, "space plays")
    page.keys(" ")
    stopped = page.value("#scrubber")
    time.sleep(0.2)
    check(page.value("#scrubber") == stopped, "space stops")
    page.keys("w")
    check(page.value("#scrubber") == page.record["worst"], "w goes to the worst moment")


def test_two(page):
    page.scrub(9)
    page.keys("1")
    page.find("[data-mode=wipe]").click()
    Select(page.find("#second")).select_by_value("3")
    a, b = page.picture(0, 9), page.picture(3, 9)
    half = SIZE[0] // 2
    page.view("#view-a", [a], "the wipe's left is A", x1=half - 1)
    page.view("#view-a", [b], "the wipe's right is B", x0=half + 1)
    page.browser.execute_script(
        "const e = document.getElementById('edge'); e.value = 100; e.dispatchEvent(new Event('input'))")
    page.view("#view-a", [a], "wiped to the right end it is all A")
    page.find("[data-mode=difference]").click()
    Select(page.find("#gain")).select_by_value("1")
    page.view("#view-a", [a, b], "the difference is that of the pictures", kind="difference")
    check(page.difference(page.find("#view-a"), [a]) > 8, "the difference is no picture")
    plain = page.brightness("#view-a")
    Select(page.find("#gain")).select_by_value("4")
    page.wait(lambda: page.brightness("#view-a") > 3 * plain, "at a brightness of 4 it is about four times as bright")
    page.find("[data-mode=pair]").click()
    page.view("#view-a", [a], "A stands left")
    page.view("#view-b", [b], "B stands right")
    page.find("#swap").click()
    page.view("#view-a", [b], "A and B are swapped")
    page.scrub(15)
    check([page.find(v).get_attribute("data-frame") for v in ("#view-a", "#view-b")] == ["15", "15"], "two in step")
    page.find("[data-mode=all]").click()


def column(page, index):
    return [row.find_elements(By.TAG_NAME, "td")[index].text for row in page.find_all("#table tbody tr")]


def test_table(page):
    button = page.find_all("#table th button")[3]
    button.click()
    ratios = [float(text) for text in column(page, 3)]
    check(len(ratios) == 4 and ratios == sorted(ratios), "sorted by the largest ratio, upwards")
    button.click()
    check([float(text) for text in column(page, 3)] == sorted(ratios, reverse=True), "and downwards")
    page.find_all("#table th button")[1].click()
    check(column(page, 1) == ["5%", "5%", "20%", "20%"], "percentages are sorted as numbers")
    page.find_all("#table th button")[0].click()


def test_snippet(page, program, folder):
    page.keys("4")
    snippet = page.find("#snippet").text
    check(snippet.splitlines()[0] == "[body.block]", "the snippet names its table")
    scene = folder / "pasted.toml"
    scene.write_text(BODY.format(lines="").replace("[body.block]\n", snippet + "\n"))
    run(program, "simulate", scene, "-o", folder / "pasted", "--frames", "1", "--quiet")
    pasted = (folder / "pasted" / "scene.toml").read_text().splitlines()
    variant = (page.folder / "runs" / page.record["variants"][3]["name"] / "scene.toml").read_text().splitlines()
    for key in ("limit.stretch", "material.young"):
        of = [[line for line in lines if line.startswith(key)] for lines in (pasted, variant)]
        check(len(of[0]) == 1 and of[0] == of[1], f"{key} of the pasted scene is the variant's")
    page.find("#copy").click()
    page.wait(lambda: page.find("#copied").text != "", "copying is answered")


def test_aim(page, program, folder):
    page.keys("2")
    page.scrub(12)
    command = page.find("#aim").text
    check(command.startswith("umax aim ") and "--vary body.block.limit.stretch=5%..20%" in command, "the key is varied")
    check("--set 'body.block.material.young=60 kPa'" in command, "the other varied key is set")
    check(" at frame 12 = " in command, "the want is of this moment")
    page.scrub(13)
    check(" at frame 13 = " in page.find("#aim").text, "the want follows the scrubber")
    page.find("#copy-aim").click()
    page.wait(lambda: page.find("#aim-copied").text != "", "copying the command is answered")
    result = subprocess.run(command.replace("umax", shlex.quote(program), 1) + " --samples 1", shell=True, cwd=folder,
                            capture_output=True, text=True)
    check(result.returncode == 0, f"{command}: {result.returncode}: {result.stderr}")
    check("reached in" in result.stdout, "the value that is there is found")


def test_no_network(browser):
    # one warning is of our own making: that we read pixels back
    errors = [entry for entry in browser.get_log("browser") if "willReadFrequently" not in entry["message"]]
    check(not errors, f"no words on the console: {errors}")
    # chrome: is the browser's own first page
    for entry in browser.get_log("performance"):
        message = json.loads(entry["message"])["message"]
        if message["method"] == "Network.requestWillBeSent":
            url = message["params"]["request"]["url"]
            check(url.split(":")[0] in ("file", "data", "blob", "chrome"), f"no request to {url[:80]}")


def take_pictures(page, folder):
    """For the eyes: the page in its states."""
    folder.mkdir(parents=True, exist_ok=True)
    for mode in ("all", "pair", "wipe", "difference"):
        page.find(f"[data-mode={mode}]").click()
        time.sleep(0.3)
        page.browser.save_screenshot(str(folder / f"{mode}.png"))
    page.find("[data-mode=all]").click()


def main():
    program = os.path.realpath(sys.argv[1])
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "block.toml").write_text(BODY.format(lines='material.young = "20 kPa"\n'))
        run(program, "tune", folder / "block.toml", "-o", folder / "tune", "--quiet", "--set", f"render.size={list(SIZE)}",
            "--vary", "body.block.limit.stretch=5%,20%", "--vary", "body.block.material.young=20 kPa,60 kPa")
        browser = start_browser(folder / "profile")
        try:
            page = Page(browser, folder / "tune")
            test_in_step(page)
            test_keyboard(page)
            test_two(page)
            test_table(page)
            test_snippet(page, program, folder)
            test_aim(page, program, folder)
            if len(sys.argv) > 2:
                take_pictures(page, Path(sys.argv[2]))
            test_no_network(browser)
        finally:
            browser.quit()
    print("the page holds")


if __name__ == "__main__":
    main()
