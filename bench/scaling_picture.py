#!/usr/bin/env python3
"""bench/scaling_picture.py OUT.png [FIGURES.json]: the picture of docs/lab/results.md on growth, from docs/lab/measured.json.

Means over the scenes against the pixels of a view, both axes logarithmic: processor seconds, and peak memory and size of the PLY file, with a line that
grows as the pixels do. Needs python3-matplotlib and numpy."""
import argparse
import json
from pathlib import Path

import matplotlib
import numpy

matplotlib.use("Agg")
from matplotlib import pyplot, ticker  # noqa: E402

FIGURES = Path(__file__).resolve().parents[1] / "docs/lab/measured.json"
SECONDS = {"processor": "one thread"}
SPACE = {"peak_gb": "peak memory, GB", "ply_gb": "PLY file, GB"}


def draw(axes, sides, columns, labels, title):
    pixels = sides.astype(float) ** 2
    for column, label in labels.items():
        axes.loglog(pixels, columns[column], "o-", label=label)
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
    parser.add_argument("out")
    parser.add_argument("figures", type=Path, nargs="?", default=FIGURES)
    options = parser.parse_args()
    rows = json.loads(options.figures.read_text(encoding="utf-8"))["sizes"]["rows"]
    columns = {column: [row[column] for row in rows.values()] for column in (*SECONDS, "peak_gb", "ply_mb")}
    columns["ply_gb"] = [mb / 1e3 for mb in columns["ply_mb"]]
    sides = numpy.array([int(size) for size in rows])
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 5), layout="constrained")
    draw(left, sides, columns, SECONDS, "Processor seconds of a reconstruction from 8 views")
    draw(right, sides, columns, SPACE, "Memory and file")
    figure.savefig(options.out, dpi=90)


if __name__ == "__main__":
    main()
