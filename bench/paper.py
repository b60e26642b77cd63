#!/usr/bin/env python3
"""bench/paper.py: the paper's recipe at a small size, with one thing changed or none, in pieces.

    bench/paper.py OUT RECIPE [--steps N] [--program build/ffprocams] [--perceptual FILE] [--device cuda] [--minutes M]
    bench/paper.py OUT table

RECIPE is `staged` (models/paper-small.json), `unstaged` (white and active patterns from the first step), an order of blocks (`all-T`, `3M1T`, `7M1T`,
`all-M`; `staged` is MTMT), `no-perceptual` or `cnn-appearance`. White counts from 5 % of the N steps on, active patterns from 10 %. A call goes on
where the last one with the same OUT, RECIPE and N stopped, after M minutes at most, and keeps the averaged weights of steps 1000, 2000, 4000, 8000 and N
as OUT/RECIPE-N/weights-STEP.safetensors. FILE is the network of the perceptual term; all recipes but `no-perceptual` need it. `table` prints what the runs
in OUT measured, as Markdown: PSNR in dB on validation scenes (lollipops not given at the input poses, all patterns at new poses), the mean loss of the last
hundred steps that were logged, the share of steps skipped for their gradient, seconds a step (median) and peak memory."""
import argparse
import json
import os
import signal
import sys
import threading
from pathlib import Path
from statistics import mean, median

BASE = Path(__file__).resolve().parent.parent / "models" / "paper-small.json"
KEPT = (1000, 2000, 4000, 8000)
RECIPES = {"staged": {}, "unstaged": {"white_from": 0, "active_from": 0}, "all-T": {"modules": "TTTTTTTT"}, "3M1T": {"modules": "MMMTMMMT"},
           "7M1T": {"modules": "MMMMMMMT"}, "all-M": {"modules": "MMMMMMMM"}, "no-perceptual": {"perceptual": 0},
           "cnn-appearance": {"appearance_cnn": True}}


def configuration(recipe, steps):
    config = json.loads(BASE.read_text()) | {"steps": steps, "white_from": steps // 20, "active_from": steps // 10}
    for field, value in RECIPES[recipe].items():
        (config["model"] if field in ("modules", "appearance_cnn") else config)[field] = value
    return config


def metrics(folder):
    path = folder / "metrics.jsonl"
    return [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []


def checkpoint_step(folder):
    path = folder / "checkpoint.safetensors"
    if not path.exists():
        return 0
    with path.open("rb") as file:
        return int(json.loads(file.read(int.from_bytes(file.read(8), "little")))["__metadata__"]["step"])


def piece(options, folder, stop, seconds):
    """Trains up to step `stop`, or for so many seconds (None: no limit); notes what it took."""
    first = checkpoint_step(folder)
    command = [options.program, "train", "--out", str(folder), "--stop-at", str(stop), "--device", options.device]
    if first:
        command += ["--resume"]
    else:
        settings = folder / "config.json"
        settings.write_text(json.dumps(configuration(options.recipe, options.steps), indent=1))
        command += ["--config", str(settings)]
    if options.recipe != "no-perceptual":
        command += ["--perceptual", options.perceptual]
    child = os.posix_spawnp(command[0], command, os.environ)
    alarm = threading.Timer(seconds if seconds is not None else 1e9, os.kill, (child, signal.SIGINT))
    alarm.daemon = True
    alarm.start()
    _, status, usage = os.wait4(child, 0)
    alarm.cancel()
    if status:
        sys.exit(f"{folder}: the training ended with status {os.waitstatus_to_exitcode(status)}")
    last = checkpoint_step(folder)
    with (folder / "pieces.jsonl").open("a") as file:
        file.write(json.dumps({"first": first, "last": last, "cpu_s": usage.ru_utime + usage.ru_stime, "peak_gb": usage.ru_maxrss / 1e6}) + "\n")
    return last


def train(options):
    folder = Path(options.out) / f"{options.recipe}-{options.steps}"
    folder.mkdir(parents=True, exist_ok=True)
    left = options.minutes * 60 if options.minutes else None
    for stop in [step for step in KEPT if step < options.steps] + [options.steps]:
        kept = folder / f"weights-{stop}.safetensors"
        if checkpoint_step(folder) < stop:
            begin = os.times().elapsed
            last = piece(options, folder, stop, left)
            left = None if left is None else left - (os.times().elapsed - begin)
            if last < stop:
                print(f"{folder}: step {last} of {options.steps}; the same command goes on from there")
                return
        if not kept.exists():
            os.link(folder / "weights.safetensors", kept)
    print(f"{folder}: done")


def row(folder):
    lines = metrics(folder)
    steps = [line for line in lines if "loss" in line]
    scored = [line for line in lines if "validation_rendering" in line]
    if not steps or not scored:
        return
    pieces = [json.loads(line) for line in (folder / "pieces.jsonl").read_text().splitlines()]
    losses = [line["loss"] for line in steps[-100:] if line["loss"] is not None]
    loss = f"{mean(losses):.4f}" if losses else "not finite"
    print(f"| {folder.name} | {scored[-1]['step']} | {scored[-1]['validation_rendering']:.2f} | {scored[-1]['validation_novel_pose']:.2f} | "
          f"{scored[-1]['depth_median_percent']:.2f} | {loss} | {mean(line['skipped'] for line in steps):.3f} | "
          f"{median(line['seconds']['step'] for line in steps):.2f} | {max(p['peak_gb'] for p in pieces):.2f} |")


def main():
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("out")
    parser.add_argument("recipe", choices=[*RECIPES, "table"])
    parser.add_argument("--steps", type=int, default=json.loads(BASE.read_text())["steps"])
    parser.add_argument("--program", default="build/ffprocams")
    parser.add_argument("--perceptual")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--minutes", type=float)
    options = parser.parse_args()
    if options.recipe == "table":
        print("| run | scored at step | input poses | new poses | depth, % | loss | skipped | s a step | GB |\n|---|---|---|---|---|---|---|---|---|")
        for folder in sorted(Path(options.out).iterdir()):
            if folder.is_dir():
                row(folder)
    elif options.recipe != "no-perceptual" and not options.perceptual:
        sys.exit("--perceptual FILE is missing: the recipe has that term")
    else:
        train(options)


main()
