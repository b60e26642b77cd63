#!/usr/bin/env python3
"""bench/ablate.py PROGRAM FOLDER TABLE [STEPS [RESOLUTION]]: trainings of equal cost, side by side, as a Markdown table.

TABLE is `additions` (from the paper's form to ours, each row the one before with one change) or `parts` (ours with one part
changed). All rows have the same scenes, the same number of steps and the same seed, and begin from nothing. Figures are PSNR in dB on
the validation scenes: lollipops not given at the input poses, all patterns at new poses; `polished` after the fit to the input
views. The perceptual row of `parts` needs lpips_squeeze.safetensors in the folder FFPROCAMS_PERCEPTUAL. FOLDER keeps what each training leaves; existing rows are not trained again."""
import json
import os
import sys
from pathlib import Path

COMMON = {"seed": 11, "lollipops": 3, "pool": 8, "reuse": 4, "warmup_steps": 20, "ema": 0.98, "learning_rate": 6e-4,
          "final_learning_rate": 1e-5, "validation_scenes": 6, "log_every": 5, "polish_steps": 24}

PLAIN = {"supervised_inputs": 4, "supervised_targets": 0}
ADDITIONS = [("the paper's form, small", {"model": {"preset": "paper-small"}}),
             ("+ new poses among the supervised ones", {"supervised_inputs": 2, "supervised_targets": 2}),
             ("+ pixel skip", {"model": {"pixel_skip": True, "pixel_features": 24, "pixel_hidden": 96}}),
             ("+ the classical initialisation among the inputs", {"model": {"match_input": True}}),
             ("+ heads as residuals around it", {"model": {"residual": True}}),
             ("+ our drawing (no blur, firm splats, footprint, shadows)", {"model": {"render": "ours"}}),
             ("+ true albedo and normals in the loss", {"truth_albedo": 0.05, "truth_normal": 0.02}),
             ("+ half of the steps through the polish", {"polish_share": 0.5})]

OURS = {"model": {"preset": "small"}, "truth_albedo": 0.05, "truth_normal": 0.02, "polish_share": 0.5}
PARTS = [("ours: MTMTMTMT, 8 views", {}),
         ("TTTTTTTT", {"model": {"modules": "TTTTTTTT"}}),
         ("MMMTMMMT", {"model": {"modules": "MMMTMMMT"}}),
         ("MMMMMMMM", {"model": {"modules": "MMMMMMMM"}}),
         ("6 views", {"views": 6}),
         ("4 views", {"views": 4}),
         ("2 views", {"views": 2}),
         ("without true albedo and normals", {"truth_albedo": 0, "truth_normal": 0}),
         ("with the perceptual term", {"perceptual": 0.05, "perceptual_from": 0}),
         ("with a convolutional head for appearance", {"model": {"appearance_cnn": True}}),
         ("TMTMTMTM", {"model": {"modules": "TMTMTMTM"}}),
         ("learning rate 4e-4 instead of 6e-4", {"learning_rate": 4e-4}),
         ("learning rate 2e-4", {"learning_rate": 2e-4}),
         ("learning rate 1e-4", {"learning_rate": 1e-4})]


def merged(base, change):
    return {**base, **change, "model": {**base.get("model", {}), **change.get("model", {})}}


def configurations(table):
    if table == "parts":
        return [(name, merged(OURS, change)) for name, change in PARTS]
    rows, config = [], dict(PLAIN)
    for name, change in ADDITIONS:
        config = merged(config, change)
        rows.append((name, config))
    return rows


def train(program, folder, config):
    """Runs a training that is not there yet; what it measured, and its peak memory in GB."""
    done = folder / "done.json"
    if done.exists():
        return json.loads(done.read_text())
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    settings = folder.with_suffix(".json")
    settings.write_text(json.dumps(config, indent=1))
    arguments = [program, "train", "--out", str(folder), "--config", str(settings)]
    if "perceptual" in config:
        arguments += ["--perceptual", os.environ["FFPROCAMS_PERCEPTUAL"] + "/lpips_squeeze.safetensors"]
    child = os.posix_spawn(program, arguments, os.environ,
                           file_actions=[(os.POSIX_SPAWN_OPEN, fd, os.devnull, os.O_WRONLY, 0) for fd in (1, 2)])
    _, status, usage = os.wait4(child, 0)
    if status:
        sys.exit(f"{folder}: the training failed")
    lines = [json.loads(line) for line in (folder / "metrics.jsonl").read_text().splitlines()]
    steps = sorted(line["seconds"]["step"] for line in lines if "seconds" in line)
    last = [line for line in lines if "validation_rendering" in line][-1]
    last.update(step_s=steps[len(steps) // 2], memory_gb=usage.ru_maxrss / 1e6)
    done.write_text(json.dumps(last))
    return last


def main():
    if len(sys.argv) < 4 or sys.argv[3] not in ("additions", "parts"):
        sys.exit(__doc__)
    program, folder, table = os.path.realpath(sys.argv[1]), Path(sys.argv[2]), sys.argv[3]
    steps, resolution = (int(x) for x in (sys.argv[4:6] + ["300", "64"][len(sys.argv) - 4:]))
    print("| | input poses | polished | new poses | polished | depth, % | s a step | GB |\n|---|---|---|---|---|---|---|---|")
    for i, (name, config) in enumerate(configurations(table)):
        config = {**COMMON, **config, "steps": steps, "resolution": resolution, "validate_every": steps}
        r = train(program, folder / f"{table}_{i}", config)
        print(f"| {name} | {r['validation_rendering']:.2f} | {r['polished_rendering']:.2f} | "
              f"{r['validation_novel_pose']:.2f} | {r['polished_novel_pose']:.2f} | {r['depth_median_percent']:.2f} | "
              f"{r['step_s']:.2f} | {r['memory_gb']:.2f} |", flush=True)
    print(f"| classical initialisation | {r['start_rendering']:.2f} | | {r['start_novel_pose']:.2f} | | | | |")


main()
