#!/usr/bin/env python3
"""Draws docs/drop.svg: a measured drop, the simulation before tuning and after it. Standard Python only.

    cargo build --release -p tunenet-cli --no-default-features
    python3 docs/make_picture.py [path/to/tunenet [picture.svg]]

The dots are assets/observations/drop.csv. `tunenet tune` finds the restitution; both curves come from `tunenet simulate`,
started as that drop was (1 m of fall, released at 0.25 s, onto a floor at 0.113 m; see assets/README.md).
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
TOOL = sys.argv[1] if len(sys.argv) > 1 else str(ROOT / "target/release/tunenet")
PICTURE = pathlib.Path(sys.argv[2]) if len(sys.argv) > 2 else ROOT / "docs/drop.svg"
SCENE, DROP = ROOT / "assets/ball.toml", ROOT / "assets/observations/drop.csv"
START = ["release.height_m=1.0", "release.time_s=0.25", "surface.height_m=0.113", "record.rate_hz=240.0", "record.frames=719"]
WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM = 720, 340, 52, 14, 30, 44
LAST_S, HIGHEST_M = 3.0, 1.2

STYLE = """
  text { font: 13px system-ui, sans-serif; fill: #24292f; }
  .grid { stroke: #d0d7de; stroke-width: 1; }
  path { fill: none; stroke-linecap: round; stroke-linejoin: round; }
  .measured { stroke: #57606a; stroke-width: 4.4; }
  .before { stroke: #D55E00; stroke-width: 2; stroke-dasharray: 7 6; }
  .after { stroke: #0072B2; stroke-width: 1.8; }
  text.before { fill: #D55E00; stroke: none; }
  text.after { fill: #0072B2; stroke: none; }
  @media (prefers-color-scheme: dark) {
    text { fill: #e6edf3; }
    .grid { stroke: #3d444d; }
    .measured { stroke: #9da7b1; }
    .before { stroke: #ff8a3d; }
    .after { stroke: #56b4e9; }
    text.before { fill: #ff8a3d; }
    text.after { fill: #56b4e9; }
  }
"""


def run(*arguments):
    return subprocess.run([TOOL, *map(str, arguments)], check=True, capture_output=True, text=True).stdout


def heights(path):
    with open(path, newline="") as file:
        return [(float(row["t_s"]), float(row["z_m"])) for row in csv.DictReader(file)]


def x(time_s):
    return LEFT + (WIDTH - LEFT - RIGHT) * time_s / LAST_S


def y(height_m):
    return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * height_m / HIGHEST_M


def line(points):
    return "M" + "L".join(f"{x(t):.1f} {y(z):.1f}" for t, z in points)


def dots(points):
    return "".join(f"M{x(t):.1f} {y(z):.1f}h0" for t, z in points)


def label(time_s, height_m, name, text):
    return f'<text class="{name}" x="{x(time_s):.1f}" y="{y(height_m):.1f}" text-anchor="middle">{text}</text>'


def main():
    with tempfile.TemporaryDirectory() as folder:
        tuned, curve = pathlib.Path(folder, "tuned.toml"), pathlib.Path(folder, "curve.csv")
        found = json.loads(run("tune", "--sim", SCENE, "--observation", DROP, "--out", tuned, "--json"))
        curves = []
        for scene in (SCENE, tuned):
            run("simulate", "--sim", scene, *(word for key in START for word in ("--set", key)), "--out", curve, "--overwrite")
            curves.append(heights(curve))
    restitution = found["parameters"]["restitution"]
    before, after = restitution["before"], restitution["value"]
    title = f"A drop, measured and simulated: restitution {before} before tuning, {after:.3f} after"
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" role="img" aria-label="{title}">',
        f"<title>{title}</title>",
        f"<style>{STYLE}</style>",
    ]
    for height_m in (0.0, 0.4, 0.8, 1.2):
        parts.append(f'<path class="grid" d="M{LEFT} {y(height_m):.1f}H{WIDTH - RIGHT}"/>')
        parts.append(f'<text x="{LEFT - 8}" y="{y(height_m) + 4:.1f}" text-anchor="end">{height_m}</text>')
    for time_s in range(4):
        parts.append(f'<text x="{x(time_s):.1f}" y="{HEIGHT - BOTTOM + 19}" text-anchor="middle">{time_s}</text>')
    parts += [
        f'<text x="{LEFT}" y="{TOP - 13}">height of the ball\'s centre, m</text>',
        f'<text x="{WIDTH - RIGHT}" y="{HEIGHT - 6}" text-anchor="end">time, s</text>',
        f'<path class="measured" d="{dots(heights(DROP)[::3])}"/>',
        f'<path class="before" d="{line(curves[0])}"/>',
        f'<path class="after" d="{line(curves[1])}"/>',
        label(0.62, 1.05, "", "measured"),
        label(1.22, 0.31, "before", f"before: {before}"),
        label(1.076, 0.86, "after", f"after: {after:.3f}"),
        "</svg>",
    ]
    PICTURE.write_text("\n".join(parts) + "\n")


main()
