#!/usr/bin/env python3
"""bench/without_board.py WORK [--rigs 10]: `calibrate --without-board` on generated rigs whose truth is known.

Walks (whole scenes, five places of the camera, 488 x 360) and turntables (objects, eight stops of 45 degrees, 480 x 360) are photographed under a
panel of 640 x 400 with lens distortion, noise, defocus and gamma. Prints as JSON, for each kind, lists over the rigs: errors of the focal
lengths of camera and projector in per cent, and PSNR at a place or stop that was held out, reconstructed with the calibration found and with
the true one; null where calibration was refused. WORK keeps photographs and scores, so that a stopped run goes on."""
import argparse
import json
import os
import re
import subprocess
import sys

SENSOR = ["--sensor", "read=0.004", "--sensor", "shot=0.0005", "--sensor", "defocus=0.5", "--sensor", "gamma=0.1"]
HELD = {"walks": "place-03", "turntables": "135"}


def run(program, *command, refused=False):
    done = subprocess.run([program, *map(str, command)], capture_output=True, text=True, check=False)
    if done.returncode and not refused:
        sys.exit(f"without_board: error: {' '.join(map(str, command))}: {done.stderr.strip()[-800:]}")
    return done.returncode == 0


def focal_lengths(path):
    """Of camera and projector: COLMAP's text, OpenCV's XML or the generator's truth."""
    with open(f"{path}/cameras.txt" if os.path.isdir(path) else path, encoding="utf-8") as file:
        text = file.read()
    if os.path.isdir(path):
        return [float(line.split()[4]) for line in text.splitlines() if line[:1] in "12"]
    if path.endswith(".json"):
        return [json.loads(text)[key][0][0] for key in ("cam_K", "proj_K")]
    return [float(re.search(rf"<{key}.*?<data>\s*(\S+)", text, re.DOTALL)[1]) for key in ("cam_int", "proj_int")]


def psnr(program, kind, rig, out, calibration, shown):
    """At the place or stop that was held out, of a reconstruction from the others."""
    scores, held = f"{out}.json", HELD[kind]
    if not os.path.exists(scores):
        if kind == "walks":
            views = [f"place-{i:02d}" for i in range(5)]
            options = ["-c", calibration[0], "--scene", "-i", f"{rig}/{{view}}/*.png", "-w", "160"]
        else:
            prefix = "" if calibration[1].endswith("truth.json") else "view-"  # the axis found names stops by their folders
            folder, held = ("" if prefix else "view-") + "{view}", prefix + held
            views = [f"{prefix}{turn:03d}" for turn in range(0, 360, 45)]
            options = ["-c", calibration[0], "-t", calibration[1], "-i", f"{rig}/{folder}/*.png", "-m", f"{rig}/masks/{folder}.png", "-w", "240"]
        given = [x for view in views if view != held for x in ("-v", view)]
        run(program, "import", *options, "--shown", shown, *given, "--name", "rig", "-o", f"{out}-given")
        run(program, "import", *options, "--shown", shown, "-v", held, "--name", "rig", "-o", f"{out}-held")
        run(program, "reconstruct", f"{out}-given", "-o", f"{out}.ply")
        run(program, "evaluate", f"{out}-given", "--gaussians", f"{out}.ply", "--targets", f"{out}-held/scene.json", "--json", scores)
    with open(scores, encoding="utf-8") as file:
        return next(round(row["psnr"], 3) for row in json.load(file)["rows"] if row["protocol"] == "novel_pose")


def one(program, work, kind, number, shown):
    """Errors of camera and projector in per cent, PSNR with the calibration found and with the true one."""
    rig = f"{work}/{kind}{number}"
    how = ["--rig", "walk", "--views", "5"] if kind == "walks" else ["--attitudes", "0"]
    if not os.path.exists(f"{rig}/done"):
        run(program, "generate", rig, "--photographs", shown, *how, "--seed", number + 1, "--split", "test", "--first", number, "--resolution", "360", *SENSOR)
        with open(f"{rig}/done", "w", encoding="utf-8"):
            pass
    truth = [f"{rig}/colmap"] if kind == "walks" else [f"{rig}/truth.json", f"{rig}/truth.json"]
    found = [f"{rig}-colmap"] if kind == "walks" else [f"{rig}.xml", f"{rig}-axis.json"]
    folders = sorted(f"{rig}/{name}" for name in os.listdir(rig) if name.startswith(("place-", "view-")))
    outs = ["-o", found[0]] if kind == "walks" else ["--angles", "8x45", "-o", found[0], "--turntable-output", found[1]]
    if not os.path.exists(found[0]) and not run(program, "calibrate", *folders, "--without-board", "--shown", shown, *outs, refused=True):
        return None, None, None, psnr(program, kind, rig, f"{rig}-true", truth, shown)
    errors = [round(100 * abs(a / b - 1), 3) for a, b in zip(focal_lengths(found[0]), focal_lengths(truth[0]))]
    return *errors, psnr(program, kind, rig, f"{rig}-found", found, shown), psnr(program, kind, rig, f"{rig}-true", truth, shown)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("work", metavar="WORK")
    parser.add_argument("--program", default="build/ffprocams")
    parser.add_argument("--rigs", type=int, default=10)
    options = parser.parse_args()
    os.makedirs(options.work, exist_ok=True)
    shown = f"{options.work}/patterns"
    if not os.path.exists(shown):
        run(options.program, "patterns", "-o", shown, "--projector", "640x400", "--only", "capture", "--only", "graycode")
    figures = {}
    for kind in HELD:
        rows = [one(options.program, options.work, kind, number, shown) for number in range(options.rigs)]
        figures[kind] = dict(zip(("camera", "projector", "found", "true"), map(list, zip(*rows))))
    json.dump(figures, sys.stdout, indent=1)


if __name__ == "__main__":
    main()
