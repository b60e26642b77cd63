#!/usr/bin/env python3
"""bench/results.py: tables of docs/lab/results.md from what `ffprocams evaluate --json` wrote.

    bench/results.py "the network alone=alone.json" "polished=first.json,second.json" ...

Files with commas between count as one. Prints Markdown: a table a protocol with a row a file, the errors of depth and albedo, and the scenes of the last file with
the highest, median and lowest novel_pose PSNR."""
import json
import sys

PROTOCOLS = {"rendering": "Rendering (black, white and lollipops at the input poses)",
             "novel_pattern": "Novel pattern (input poses)",
             "novel_pose": "Novel pose (of camera and projector)"}
FIGURES = [("psnr", "PSNR", 2), ("psnr_foreground", "object's pixels", 2), ("psnr_gloss", "highlights", 2), ("ssim", "SSIM", 4), ("lpips", "LPIPS", 4)]
TRUTH = [("depth_lit_median", 2), ("depth_lit_p90", 2), ("depth_unlit_median", 2), ("depth_unlit_p90", 2),
         ("albedo_mse", 5), ("albedo_lit_mse", 5), ("albedo_unlit_mse", 5)]


def cell(value, digits):
    return "–" if value is None else f"{value:.{digits}f}"


def rows_of(paths):
    rows = []
    for path in paths.split(","):
        with open(path, encoding="utf-8") as file:
            rows += json.load(file)["rows"]
    return rows


def mean_of(rows, protocol, key):
    """None where a row lacks the figure; of highlights, over the rows that have any."""
    values = [row.get(key) for row in rows if row["protocol"] == protocol]
    if key == "psnr_gloss":
        values = [value for value in values if value is not None]
    return None if not values or None in values else sum(values) / len(values)


def scenes_of(rows, protocol):
    return sorted((row["psnr"], row["capture"]) for row in rows if row["protocol"] == protocol)


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    files = {}
    for argument in sys.argv[1:]:
        name, _, paths = argument.partition("=")
        files[name] = rows_of(paths)
    for protocol, title in PROTOCOLS.items():
        print(f"| {title} | scenes | pictures | " + " | ".join(label for _, label, _ in FIGURES) + " |")
        print("|---|---|---|" + "---|" * len(FIGURES))
        for name, rows in files.items():
            count = len(scenes_of(rows, protocol))
            if count:
                pictures = sum(row["images"] for row in rows if row["protocol"] == protocol)
                figures = " | ".join(cell(mean_of(rows, protocol, key), digits) for key, _, digits in FIGURES)
                print(f"| {name} | {count} | {pictures:,} | {figures} |")
        print()
    print("| | depth error where lit: median | 90th percentile | where unlit: median | 90th percentile "
          "| albedo MSE | where lit | where unlit |")
    print("|---|---|---|---|---|---|---|---|")
    for name, rows in files.items():
        print(f"| {name} | " + " | ".join(cell(mean_of(rows, "rendering", key), digits) for key, digits in TRUTH) + " |")
    ranked = scenes_of(rows, "novel_pose")
    if ranked:
        print("\nbest {1} {0:.2f}, median {3} {2:.2f}, worst {5} {4:.2f}".format(
            *ranked[-1], *ranked[len(ranked) // 2], *ranked[0]))


main()
