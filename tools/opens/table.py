#!/usr/bin/env python3
"""The table of docs/formats.md: what `kinemesh formats` says of each format, and which programs open it.

table.py [--check] [BUILD]: writes it, or ends with 1 when it is not up to date. Which programs open what is
measured by tools/verify 5_opens and kept in docs/opens.json.
"""
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
OPENS = ROOT / "docs" / "opens.json"
PAGE = ROOT / "docs" / "formats.md"
BEGIN, END = "<!-- by tools/opens/table.py -->\n", "<!-- end -->\n"
# The encodings of a format are one row.
KINDS = {"ply": ["ply", "ply ascii", "ply big-endian"], "glb": ["glb", "glb of one frame"]}
FILES = {"ply+pc2": "`.ply` + `.pc2`", "mdd": "`.mdd` + `.ply`", "pvd": "`.pvd` + `STEM_frames/*.vtp`", "gltf": "`.gltf` + `.bin`"}
READS = {"ply": "ascii, both binary orders", "stl": "ascii, binary", "vtp": "ascii, base64, appended; zlib", "npz": "uncompressed"}
WRITES = {"ply": "the same (`--encoding`)", "vtp": "appended raw, ascii"}
UNITS = {"glb": "metres", "gltf": "metres", "c3d": "mm", "trc": "mm", "csv": "mm"}


def store(results):
    OPENS.write_text(json.dumps(results, indent=1) + "\n")


def difference(answers):
    """Of all encodings of a format, in words."""
    worst = [a["worst_mm"] for a in answers]
    if None in worst:
        return "as a table"
    return "equal" if max(worst) == 0 else f"within {max(worst):.6f}".rstrip("0") + " mm"


def opens_in(name, results):
    answers = {}
    for kind in KINDS.get(name, [name]):
        for program, answer in results.get(kind, {}).items():
            # A program that shows only stills has no part in the animated format.
            answers.setdefault(program + (" (one frame)" if program not in results.get(name, {}) else ""), []).append(answer)
    return ", ".join(f"{program}: {difference(found)}" for program, found in answers.items()) or "–"


def cells(f, results):
    keeps, name = f["keeps"], f["name"]

    def kept(key):
        return "kept" if keeps[key] else "lost"

    def yes(does, words):
        return words.get(name, "yes") if does else "no"

    files = FILES.get(name) or ", ".join(f"`{e}`" for e in f["extensions"]) + ("; numbered" if f["numbered_sequence"] else "")
    return [f"`{name}`", files, yes(f["read"], READS), yes(f["write"], WRITES), "yes" if keeps["faces"] else "no", kept("names"),
            UNITS.get(name, kept("unit")), kept("rate"), kept("events"), kept("filled"), kept("uncertainty"), kept("provenance"),
            f["exactness"], opens_in(name, results)]


def text(build):
    listed = json.loads(subprocess.run([pathlib.Path(build) / "cli" / "kinemesh", "formats", "--json"], check=True,
                                       stdout=subprocess.PIPE).stdout)["formats"]
    results = json.loads(OPENS.read_text())
    head = ["format", "files", "read", "write", "faces", "names", "unit", "rate, first frame", "events", "filled flags", "uncertainty",
            "provenance", "exactness", "opens in"]
    rows = [head, ["---"] * len(head), *(cells(f, results) for f in listed)]
    versions = {program: answer["version"] for answers in results.values() for program, answer in answers.items()}
    return "\n".join("| " + " | ".join(row) + " |" for row in rows) + "\n\nOpened by " + ", ".join(
        f"{program} {version}" for program, version in versions.items()) + ".\n"


def page(build):
    old = PAGE.read_text()
    return old, old[:old.index(BEGIN) + len(BEGIN)] + text(build) + old[old.index(END):]


def write(build):
    PAGE.write_text(page(build)[1])


if __name__ == "__main__":
    words = [w for w in sys.argv[1:] if w != "--check"]
    before, now = page(words[0] if words else ROOT / "build" / "release")
    if "--check" in sys.argv and before != now:
        sys.exit("docs/formats.md is out of date: run tools/opens/table.py")
    if before != now:
        PAGE.write_text(now)
