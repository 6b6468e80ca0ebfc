#!/usr/bin/env python3
"""Loads the demonstration page in headless Chromium and tries everything a reader would.

page_in_browser.py PROGRAM [PICTURES]: PROGRAM is report_page_demo; screenshots go to PICTURES.
Ends with 77 (skipped) when there is no Chromium, unless KINEMESH_REQUIRE_DATA is set.
"""

import json
import os
import re
import subprocess
import sys
import tempfile

from browser import Browser

COUNT_PIXELS = """(() => {
  const painter = kinemeshViewers[%d].painter, gl = painter.gl;
  const [w, h] = [painter.canvas.width, painter.canvas.height];
  const p = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, p);
  let drawn = 0, filled = 0, sum = 0;
  for (let i = 0; i < p.length; i += 4) {
    const background = Math.abs(p[i] - 244) < 4 && Math.abs(p[i + 1] - 246) < 4 && Math.abs(p[i + 2] - 248) < 4;
    if (!background) { ++drawn; sum = (sum * 31 + p[i] + 7 * p[i + 1] + i) %% 1000003; }
    if (p[i] > 200 && p[i + 1] > 100 && p[i + 1] < 145 && p[i + 2] < 20) ++filled;
  }
  return { share: drawn / (w * h), filled, sum };
})()"""


def check(holds, what):
    if not holds:
        raise AssertionError(what)
    print("ok:", what)


def pixels(browser, view=0):
    return browser.run(COUNT_PIXELS % view)


def check_views(browser, expected):
    check(browser.run("kinemeshViewers.length") == 3, "three 3D views work")
    for view in range(3):
        found = pixels(browser, view)
        check(0.1 < found["share"] < 0.9, f"view {view} draws ({found['share']:.0%} of its pixels)")
    check(pixels(browser)["filled"] > 20, "estimated vertices are drawn in their colour")
    for frame, positions in expected["positions"].items():
        decoded = browser.run(f"kinemeshViewers[0].goTo({frame}),"
                              "Array.from(kinemeshViewers[0].data.positions)")
        worst = max(sum((a - b) ** 2 for a, b in zip(positions[i:i + 3], decoded[i:i + 3])) ** 0.5
                    for i in range(0, len(positions), 3))
        check(worst <= expected["max_error_mm"] + 1e-4,
              f"frame {frame} is within the stated error ({worst:.4f} mm)")
    browser.run("kinemeshViewers[0].goTo(0)")


def check_keyboard(browser, expected):
    slider = "kinemeshViewers[0].part('slider')"
    before = pixels(browser)
    browser.run(f"{slider}.focus()")
    for _ in range(5):
        browser.press("ArrowRight", 39)
    check(browser.run("kinemeshViewers[0].group.step") == 5, "arrow keys move the scrubber")
    browser.press("End", 35)
    check(browser.run(f"{slider}.value") == str(expected["frames"] - 1), "End goes to the last frame")
    last = expected["first_frame"] + expected["frames"] - 1
    check(f"frame {last}" in browser.run("kinemeshViewers[0].part('output').textContent"),
          "the frame's number is shown")
    check(pixels(browser)["sum"] != before["sum"], "the scrubber moves the mesh")
    browser.press("Home", 36)
    check(pixels(browser)["sum"] == before["sum"], "the first frame looks as before")

    browser.run("kinemeshViewers[0].canvas.focus()")
    browser.press("ArrowLeft", 37)
    turned = pixels(browser)
    check(turned["sum"] != before["sum"], "arrow keys turn the view")
    browser.press("+", 187)
    check(pixels(browser)["share"] > turned["share"], "plus zooms in")
    browser.press(" ", 32)
    # A busy machine may draw its first frame late: wait for it rather than for a time.
    browser.run("new Promise((done) => { const wait = () => kinemeshViewers[0].group.step > 0 "
                "? done() : setTimeout(wait, 50); wait(); })")
    browser.press(" ", 32)
    check(browser.run("kinemeshViewers[0].group.step") > 0, "space plays")
    browser.press("Home", 36)
    browser.run("kinemeshViewers[0].goTo(0), document.activeElement.blur()")
    reached = []
    for _ in range(45):
        browser.press("Tab", 9)
        reached.append(browser.run(
            "document.activeElement.dataset.part || document.activeElement.className || "
            "document.activeElement.tagName"))
    for part in ("skip", "A", "canvas", "play", "slider", "speed", "front", "edges", "field",
                 "scroll", "copy", "SUMMARY"):
        check(part in reached, f"Tab reaches {part}")


def check_pair(browser):
    browser.run("kinemeshViewers[1].turn(0.5, 0.2), kinemeshViewers[1].goTo(200)")
    check(browser.run("kinemeshViewers[2].part('slider').value") == "200", "linked views play together")
    check(browser.run("JSON.stringify(kinemeshViewers[1].axes()) === "
                      "JSON.stringify(kinemeshViewers[2].axes())"), "linked views turn together")
    coloured = pixels(browser, 1)["sum"]
    browser.run("const select = kinemeshViewers[1].part('field'); select.value = '-1';"
                "select.dispatchEvent(new Event('change'))")
    check(pixels(browser, 1)["sum"] != coloured, "colours can be turned off")


def check_layout(browser, pictures):
    for width in (380, 1200):
        browser.resize(width, 900)
        wide = browser.run("document.documentElement.scrollWidth")
        check(wide <= width, f"at {width} px nothing sticks out ({wide} px)")
    browser.resize(380, 800)
    least = browser.run("Math.min(...[...document.querySelectorAll('p, li, td, dd, button, figcaption')]"
                        ".map((e) => parseFloat(getComputedStyle(e).fontSize)))")
    check(least >= 12, f"at 380 px no text is smaller than 12 px ({least} px)")
    chart = browser.run("Math.min(...[...document.querySelectorAll('svg text')].map((e) => {"
                        "const svg = e.ownerSVGElement; return parseFloat(getComputedStyle(e).fontSize) *"
                        "svg.getBoundingClientRect().width / svg.viewBox.baseVal.width; }))")
    check(chart >= 10, f"at 380 px no text of a chart is smaller than 10 px ({chart:.1f} px)")
    covered = browser.run("[...document.querySelectorAll('.code')].filter((e) => "
                          "e.querySelector('.copy').getBoundingClientRect().bottom > "
                          "e.querySelector('pre').getBoundingClientRect().top).length")
    check(covered == 0, f"at 380 px no button covers text ({covered})")
    if pictures:
        browser.screenshot(os.path.join(pictures, "page_380.png"), whole=True)
    browser.resize(1200, 900)
    pdf = browser.pdf()
    boxes = re.findall(rb"/MediaBox\s*\[\s*0 0 ([\d.]+) ([\d.]+)", pdf)
    check(pdf.startswith(b"%PDF") and boxes and all(
        abs(float(w) - 595) < 2 and abs(float(h) - 842) < 2 for w, h in boxes),
        f"prints on A4 ({len(boxes)} pages)")
    browser.call("Emulation.setEmulatedMedia", media="print")
    browser.resize(688, 1000)  # A4 less its margins
    wide = browser.run("document.documentElement.scrollWidth")
    check(wide <= 688, f"in print nothing sticks out ({wide} px)")
    browser.call("Emulation.setEmulatedMedia", media="")
    if pictures:
        browser.resize(1200, 900)
        browser.screenshot(os.path.join(pictures, "page.png"), whole=True)
        with open(os.path.join(pictures, "page.pdf"), "wb") as file:
            file.write(pdf)


def main():
    program = Browser.find()
    if program is None:
        print("skipped: no Chromium on this machine")
        return 1 if os.environ.get("KINEMESH_REQUIRE_DATA") else 77
    pictures = sys.argv[2] if len(sys.argv) > 2 else None
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run([sys.argv[1], folder], check=True)
        page = os.path.join(folder, "page.html")
        with open(os.path.join(folder, "expected.json"), encoding="utf-8") as file:
            expected = json.load(file)
        size = os.path.getsize(page)
        check(size <= 3_000_000, f"the page has at most 3 MB ({size / 1e6:.2f} MB)")
        with Browser(program) as browser:
            browser.open("file://" + page, 1200, 900)
            check_views(browser, expected)
            check_keyboard(browser, expected)
            check_pair(browser)
            check_layout(browser, pictures)
            text = browser.run("document.body.innerText")
            check(expected["statement"] in text, "the error of the compression is stated")
            check(expected["hostile"] in text, "a hostile label is shown as text")
            check(browser.run("typeof window.hostile") == "undefined", "a hostile label runs nothing")
            outside = [u for u in browser.requests if not u.startswith(("file://" + page, "data:", "about:"))]
            check(not outside, f"nothing is loaded from outside {outside}")
            check(not browser.errors, f"no errors on the console {browser.errors}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
