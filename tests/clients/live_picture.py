#!/usr/bin/python3
"""The picture of the page of umax live for docs: the figure, pulled up by a hand, with its energies.

usage: live_picture.py PROGRAM PICTURE    needs the packages of tools/packages.test
"""
import signal
import sys
import tempfile
from pathlib import Path

from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By

from live_browser import Live, Page, until


def main(program, picture):
    with tempfile.TemporaryDirectory() as name:
        live = Live(program, "figure", Path(name))
        page = Page(live.address())
        try:
            page.run("document.querySelector('input[name=heat][value=\"1\"]').click()")
            page.click("play")
            until("lying on the ground", lambda: page.frame("time") > 3, 60)
            x, y = page.middle()
            chain = ActionChains(page.browser)
            chain.move_to_element_with_offset(page.browser.find_element(By.ID, "view"), int(x), int(y)).click_and_hold()
            for _ in range(8):
                chain.move_by_offset(6, -32).pause(0.1)
            chain.perform()
            lifted = page.frame("time")
            until("the figure in the air", lambda: page.frame("time") > lifted + 2.2, 60)
            page.browser.save_screenshot(picture)
        finally:
            page.browser.quit()
            live.process.send_signal(signal.SIGINT)
            live.process.wait(timeout=20)


main(*sys.argv[1:])
