#!/usr/bin/env python3
"""bench/cores.py: what a command would take on more cores than there are, and what limits it.

    bench/cores.py [--wait SECONDS] [--rows N] build/ffprocams reconstruct data/sample -o /tmp/spot.ply

Runs the command with one thread and with two, each under bench/regions.c, which records the parallel regions: their work, their longest part, and how long
threads wait for each other. From the run with one thread (processor time, so other programs disturb it little) it predicts the time on 2, 4, 8 and 16: what
lies between regions, plus each region with its parts shared out, plus a wait for each call, which is the one measured with two threads (or --wait) times
log2 of the threads. Prints Markdown: the table of cores, and the regions that lose most on 16. Memory bandwidth and clock rates are not in the model. Needs
a C compiler and nm; the program must be linked with libgomp."""
import argparse
import bisect
import json
import math
import os
import subprocess
import sys
import tempfile
import time

COUNTS = (2, 4, 8, 16)


def record(command, threads, folder):
    out = f"{folder}/{threads}.json"
    environment = os.environ | {"OMP_NUM_THREADS": str(threads), "LD_PRELOAD": f"{folder}/regions.so", "REGIONS_FILE": out}
    begin = time.monotonic()
    subprocess.run(command, env=environment, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    wall = time.monotonic() - begin
    with open(out, encoding="utf-8") as file:
        first, *regions = [json.loads(line) for line in file]
    return wall, first["process"], regions


def names(path):
    said = subprocess.run(["nm", path], capture_output=True, text=True, check=False).stdout
    symbols = [line.split() for line in said.splitlines()]
    return sorted((int(s[0], 16), s[2]) for s in symbols if len(s) == 3 and s[1] in "tT")


def name_of(region, tables):
    table = tables.setdefault(region["file"], names(region["file"]))
    at = bisect.bisect(table, (region["at"], "\uffff")) - 1
    return table[at][1] if at >= 0 else hex(region["at"])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--wait", type=float, help="seconds that a call waits with two threads, instead of measuring")
    parser.add_argument("--rows", type=int, default=12)
    parser.add_argument("command", nargs=argparse.REMAINDER)
    given = parser.parse_args()
    if not given.command:
        parser.error("no command")
    with tempfile.TemporaryDirectory() as folder:
        source = os.path.join(os.path.dirname(os.path.abspath(__file__)), "regions.c")
        subprocess.run(["cc", "-O2", "-fopenmp", "-fPIC", "-shared", source, "-o", f"{folder}/regions.so", "-ldl"], check=True)
        wall, process, regions = record(given.command, 1, folder)
        wall_of_two, process_of_two, of_two = record(given.command, 2, folder)
    work = sum(r["work"] for r in regions)
    calls = sum(r["calls"] for r in regions)
    wait = given.wait
    if wait is None:
        wait = sum(r["wait"] * r["calls"] for r in of_two) / max(1, sum(r["calls"] for r in of_two))
    serial = process - work
    print(f"{calls} regions, {work:.2f} of {process:.2f} s in them, {1e6 * wait:.1f} us of waiting a call with two threads\n")
    print("| threads | seconds | times as fast | outside regions | parts that cannot be shared evenly | waiting |\n|---|---|---|---|---|---|")
    print(f"| 1, measured | {process:.2f} (wall {wall:.2f}) | 1 | {serial:.2f} | | |")
    print(f"| 2, measured | wall {wall_of_two:.2f} (processor {process_of_two:.2f}) | {process / wall_of_two:.2f} | | | |")
    for k, n in enumerate(COUNTS):
        shared = sum(r["on"][k] for r in regions)
        waiting = calls * wait * math.log2(n)
        total = serial + shared + waiting
        print(f"| {n}, predicted | {total:.2f} | {process / total:.1f} | {serial:.2f} | {shared - work / n:.2f} | {waiting:.2f} |")
    tables = {}
    regions.sort(key=lambda r: r["work"] / 16 - r["on"][3])
    print("\n| region | calls | work, s | longest part, s | on 16, s | of that lost |\n|---|---|---|---|---|---|")
    for r in regions[: given.rows]:
        print(
            f"| `{name_of(r, tables)}` | {r['calls']} | {r['work']:.3f} | {r['longest']:.3f} | {r['on'][3]:.3f} | {r['on'][3] - r['work'] / 16:.3f} |"
        )


if __name__ == "__main__":
    sys.exit(main())
