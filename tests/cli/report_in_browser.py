#!/usr/bin/env python3
"""Loads the report of a real conversion in headless Chromium and tries everything a reader would.

report_in_browser.py KINEMESH SESSION [PICTURES]: screenshots and the printed page go to PICTURES.
Ends with 77 (skipped) when there is no Chromium, unless KINEMESH_REQUIRE_DATA is set.
"""

import json
import os
import re
import struct
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "report"))
from browser import Browser  # noqa: E402
from page_in_browser import check, check_keyboard, check_layout, pixels  # noqa: E402


def convert(program, session, folder, name, *options):
    mesh = os.path.join(folder, name + ".ply")
    run = subprocess.run([program, "convert", session, "-o", mesh, "--no-pictures", "--json", "-q", *options],
                         check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(run.stdout), os.path.join(folder, name + "_report.html"), os.path.join(folder, name + ".pc2")


def frames_of(path):
    with open(path, "rb") as file:
        data = file.read()
    vertices, frames = struct.unpack_from("<i8xi", data, 16)
    return [struct.unpack_from(f"<{3 * vertices}f", data, 32 + 12 * vertices * f) for f in range(frames)]


def check_report(browser, page, summary, exact):
    browser.open("file://" + page, 1200, 900)
    check(browser.run("kinemeshViewers.length") == 1, "the 3D view works")
    share = pixels(browser)["share"]
    check(0.1 < share < 0.9, f"it draws ({share:.0%} of its pixels)")
    text = browser.run("document.body.innerText")
    stated = re.search(r"error is at most ([0-9.]+) mm", text)
    check(stated, "the error of the compression is stated")
    for frame in (0, len(exact) // 2, len(exact) - 1):
        decoded = browser.run(f"kinemeshViewers[0].goTo({frame}), Array.from(kinemeshViewers[0].data.positions)")
        worst = max(sum((a - b) ** 2 for a, b in zip(exact[frame][i:i + 3], decoded[i:i + 3])) ** 0.5
                    for i in range(0, len(decoded), 3))
        check(worst <= float(stated.group(1)) + 1e-3, f"frame {frame}: the error stated holds ({worst:.4f} mm)")
    browser.run("kinemeshViewers[0].goTo(0)")
    content = browser.run("document.body.textContent")
    for what, words in (("the input's hash", summary["inputs"][0]["sha256"]), ("the command", summary["command"]),
                        ("the program", summary["program"]), ("the options", summary["options"].strip()),
                        *((f"warning {i}", w[1:]) for i, w in enumerate(summary["doubtful"][:60]))):
        check(words in content, f"{what} is in it")
    first = browser.run("document.querySelector('main h2, h2').textContent")
    check(first == "Look at this first", "warnings come first")


def check_anonymous(program, session, folder):
    name = os.path.splitext(os.path.basename(session))[0]
    person = name.split("_")[0]
    _, report, _ = convert(program, session, folder, name, "--anonymous")
    for file in (report, os.path.join(folder, name + ".ply"), os.path.join(folder, name + "_summary.json")):
        with open(file, encoding="utf-8", errors="replace") as opened:
            # What is compressed may hold any letters.
            text = re.sub(r'data-part="data">[^<]*<', "", opened.read().split("end_header")[0])
        check(person.lower() not in text.lower(), f"{os.path.basename(file).replace(name, 'NAME')}: anonymous")


def main():
    chromium = Browser.find()
    if chromium is None:
        print("skipped: no Chromium on this machine")
        return 1 if os.environ.get("KINEMESH_REQUIRE_DATA") else 77
    program, session = sys.argv[1:3]
    pictures = sys.argv[3] if len(sys.argv) > 3 else None
    with tempfile.TemporaryDirectory() as folder:
        check_anonymous(program, session, folder)
        summary, page, cache = convert(program, session, folder, "report")
        size = os.path.getsize(page)
        check(size <= 3_000_000, f"the report has at most 3 MB ({size / 1e6:.2f} MB)")
        exact = frames_of(cache)
        with Browser(chromium) as browser:
            check_report(browser, page, summary, exact)
            check_keyboard(browser, {"frames": len(exact), "first_frame": summary["session"]["first_frame"]})
            check_layout(browser, pictures)
            outside = [u for u in browser.requests if not u.startswith(("file://" + page, "data:", "about:"))]
            check(not outside, f"nothing is loaded from outside {outside}")
            check(not browser.errors, f"no errors on the console {browser.errors}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
