#!/usr/bin/env python3
"""bench/scaling.py: how quality, time and memory grow with the size of pictures and the number of views.

    bench/scaling.py sizes OUT [--program build/ffprocams] [--scenes 0,25,50] [--steps N] 128 256 512 1024
    bench/scaling.py views OUT [--program ...] [--scenes ...] [--rig turntable|free] [--size 128] 1 2 4 8 16 32

Generates the scenes of the test split with these numbers once for each size or count (kept in OUT), reconstructs each of them alone in a process, scores
it, and prints Markdown: PSNR (dB) of the three protocols, seconds of the stages, peak memory, Gaussians and the size of the PLY; means over the scenes."""
import argparse
import json
import os
import re
import subprocess
import sys
from statistics import mean

PROTOCOLS = ("rendering", "novel_pattern", "novel_pose")
STAGES = ("noise", "matching", "network", "polish")


def generate(program, folder, scene, size, views, rig):
    name = f"test_{scene:05d}"
    if not os.path.exists(f"{folder}/{name}/scene.json"):
        subprocess.run([program, "generate", folder, "--split", "test", "--first", str(scene), "--count", "1", "-r", str(size),
                        "--views", str(views), "--rig", rig], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return f"{folder}/{name}"


def reconstruct(program, capture, ply, steps):
    """Seconds of each stage, peak memory in GB, Gaussians."""
    command = [program, "reconstruct", capture, "-o", ply] + (["--polish", str(steps)] if steps is not None else [])
    reader, writer = os.pipe()
    pid = os.fork()
    if pid == 0:
        os.dup2(writer, 1)
        os.execvp(command[0], command)
    os.close(writer)
    with os.fdopen(reader) as pipe:
        said = pipe.read()
    _, status, usage = os.wait4(pid, 0)
    if status:
        sys.exit(f"{' '.join(command)} failed")
    told = re.search(r": (\d+) Gaussians .*, ([\d.]+) s \(.* noise filtered ([\d.]+) s, matching ([\d.]+) s, network ([\d.]+) s, polish ([\d.]+) s", said)
    if not told:
        sys.exit(f"{' '.join(command)} printed another line than this program reads: {said.strip()}")
    figures = dict(zip(("gaussians", "seconds") + STAGES, map(float, told.groups())))
    return figures | {"peak_gb": usage.ru_maxrss / 1e6, "ply_mb": os.path.getsize(ply) / 1e6}


def score(program, capture, ply):
    subprocess.run([program, "evaluate", capture, "--gaussians", ply, "--targets", "targets/scene.json", "--json", f"{ply}.json"],
                   check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(f"{ply}.json", encoding="utf-8") as file:
        return {row["protocol"]: row["psnr"] for row in json.load(file)["rows"]}


def one(options, size, views, scene):
    folder = f"{options.out}/{options.rig}_{size}_{views}"
    capture = generate(options.program, folder, scene, size, views, options.rig)
    ply = f"{folder}/{scene}.ply"
    return reconstruct(options.program, capture, ply, options.steps) | score(options.program, capture, ply)


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("kind", choices=("sizes", "views"))
    parser.add_argument("out")
    parser.add_argument("--program", default="build/ffprocams")
    parser.add_argument("--scenes", default=",".join(str(25 * i) for i in range(12)))
    parser.add_argument("--rig", default="turntable")
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--steps", type=int)
    parser.add_argument("values", type=int, nargs="+")
    options = parser.parse_args()
    columns = ["rendering", "novel_pattern", "novel_pose", "seconds", *STAGES, "peak_gb", "gaussians", "ply_mb"]
    print(f"| {options.kind} | " + " | ".join(columns) + " |\n|" + "---|" * (len(columns) + 1), flush=True)
    for value in options.values:
        size, views = (value, 8) if options.kind == "sizes" else (options.size, value)
        rows = [one(options, size, views, int(scene)) for scene in options.scenes.split(",")]
        means = {c: mean(row[c] for row in rows) for c in columns}
        cells = [f"{v:.0f}" if c == "gaussians" else f"{v:.2f}" for c, v in means.items()]
        print(f"| {value} | " + " | ".join(cells) + " |", flush=True)
        with open(f"{options.out}/{options.kind}_{options.rig}_{value}.json", "w", encoding="utf-8") as file:
            json.dump(rows, file, indent=1)


if __name__ == "__main__":
    main()
