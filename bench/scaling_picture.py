#!/usr/bin/env python3
"""bench/scaling_picture.py WORK OUT.png: the picture of docs/lab/results.md on growth, from what `bench/scaling.py sizes WORK ..` has left.

Means over the scenes against the pixels of a view, both axes logarithmic: seconds of each stage, and peak memory and size of the PLY file, with a line
that grows as the pixels do. Needs python3-matplotlib and numpy."""
import argparse
import json
import re
from pathlib import Path

import matplotlib
import numpy

matplotlib.use("Agg")
from matplotlib import pyplot, ticker  # noqa: E402

STAGES = {"seconds": "all", "matching": "matching", "network": "network", "polish": "polish", "noise": "noise"}
SPACE = {"peak_gb": "peak memory, GB", "ply_gb": "PLY file, GB"}


def read(work):
    """Sides in pixels, and the means of each column, one number a side."""
    sizes = {}
    for path in work.glob("sizes_turntable_*.json"):
        rows = json.loads(path.read_text(encoding="utf-8"))
        means = {column: numpy.mean([row[column] for row in rows]) for column in (*STAGES, "peak_gb", "ply_mb")}
        sizes[int(re.search(r"(\d+)\.json$", path.name)[1])] = means | {"ply_gb": means["ply_mb"] / 1e3}
    sides = sorted(sizes)
    return numpy.array(sides), {column: [sizes[side][column] for side in sides] for column in (*STAGES, *SPACE)}


def draw(axes, sides, columns, labels, title):
    pixels = sides.astype(float) ** 2
    for column, label in labels.items():
        axes.loglog(pixels, columns[column], "o-", label=label, linewidth=2.5 if column == "seconds" else 1.5)
    first = next(iter(labels))
    axes.loglog(pixels, columns[first][0] * pixels / pixels[0], ":", color="grey", label="as the pixels do")
    axes.set_xticks(pixels, [f"{side} x {side}" for side in sides])
    axes.minorticks_off()
    axes.yaxis.set_major_locator(ticker.LogLocator(subs=(1, 3)))
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_title(title)
    axes.grid(True, alpha=0.3)
    axes.legend(loc="upper left", fontsize="small")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", type=Path)
    parser.add_argument("out")
    options = parser.parse_args()
    sides, columns = read(options.work)
    if len(sides) < 2:
        parser.error(f"{options.work}: fewer than two sizes (sizes_turntable_*.json)")
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 5), layout="constrained")
    draw(left, sides, columns, STAGES, "Seconds of a reconstruction from 8 views")
    draw(right, sides, columns, SPACE, "Memory and file")
    figure.savefig(options.out, dpi=90)


if __name__ == "__main__":
    main()
