"""Drawing, fits, compensation, maps, evaluation, generation, import: each against the program or the truth."""

from __future__ import annotations

import json
import math
import os
import shutil
import subprocess
from pathlib import Path
from typing import Any

import ffprocams as ffp
import numpy as np
import pytest
from ffprocams import devices, protocols


def program() -> str:
    """The program of the same build, to compare with."""
    found = os.environ.get("FFPROCAMS_PROGRAM") or shutil.which("ffprocams")
    if not found:
        pytest.skip("skipped: no program `ffprocams` to compare with (FFPROCAMS_PROGRAM)")
    return found


def test_the_same_bits_as_the_program(capture: ffp.Capture, sample: Path, tmp_path: Path) -> None:
    command = [program(), "reconstruct", sample, "--polish", "5", "-o", tmp_path / "program.ply"]
    subprocess.run(command, check=True, capture_output=True)
    gaussians = ffp.reconstruct(capture, polish=5)
    gaussians.save(tmp_path / "python.ply")
    assert (tmp_path / "python.ply").read_bytes() == (tmp_path / "program.ply").read_bytes()

    command = [program(), "refine", tmp_path / "program.ply", "--capture", sample, "--steps", "16"]
    subprocess.run([*command, "-o", tmp_path / "program_fit.ply"], check=True, capture_output=True)
    ffp.refine(ffp.Gaussians.load(tmp_path / "python.ply"), capture, steps=16).save(
        tmp_path / "python_fit.ply"
    )
    assert (tmp_path / "python_fit.ply").read_bytes() == (tmp_path / "program_fit.ply").read_bytes()


def test_pictures_show_the_object(capture: ffp.Capture, gaussians: ffp.Gaussians) -> None:
    renderer = ffp.Renderer().aim(gaussians, capture.camera(2), capture.projector(2))
    names = capture.pattern_names
    pictures = renderer.shade_many([protocols.shown(capture, n) for n in names], capture.intensity)
    assert pictures.shape == (len(names), 128, 128, 3) and pictures.dtype == np.uint8
    for name, picture in zip(names, pictures):
        assert protocols.psnr(picture / 255, ffp.encode(capture.photograph(2, name))) > 30, name
    out = np.zeros((128, 300, 3), np.uint8)
    assert (
        renderer.shade(protocols.shown(capture, names[3]), capture.intensity, out=out[:, 100:228]).base is out
    )
    np.testing.assert_array_equal(out[:, 100:228], pictures[3])
    assert not out[:, :100].any() and not out[:, 228:].any()
    exact = renderer.shade(protocols.shown(capture, names[3]), capture.intensity, dtype=np.float32)
    assert np.abs(exact * 255 - pictures[3]).max() <= 0.5 + 1e-3
    np.testing.assert_array_equal(
        renderer.shade(None, capture.intensity), pictures[names.index(capture.black)]
    )


def test_files_as_the_program_writes_them(
    capture: ffp.Capture, gaussians: ffp.Gaussians, sample: Path, tmp_path: Path
) -> None:
    """Exports, pages, pictures and films: the same bytes."""
    ours, theirs, ply = tmp_path / "python", tmp_path / "program", tmp_path / "spot.ply"
    ours.mkdir(), theirs.mkdir()
    gaussians.save(ply)
    spot, white, view = ffp.Gaussians.load(ply), capture.white, capture.view_ids[3]

    def run(*command: object) -> None:
        subprocess.run([program(), *map(str, command)], check=True, capture_output=True, cwd=theirs)

    run("export", ply, "-o", "plain.spz", "--up=-y", "--drawing", "paper")
    plain = spot.export(ours / "plain.spz", up="-y", form="paper")
    run("export", ply, "-c", sample, "-o", "lit.ply", "--light", "lollipop_3", "--projector-view", view, "--camera-view", view)
    lit = spot.export(ours / "lit.ply", capture, light="lollipop_3", projector_view=view, camera_view=view)
    run("export", ply, "-c", sample, "-o", "mesh.glb", "--mesh", "--resolution", "32")
    mesh = spot.export(ours / "mesh.glb", sample, mesh=True, resolution=32)
    assert mesh.triangles > 1000 and mesh.splats == 0 and plain.triangles == 0
    assert plain.splats == lit.splats == len(spot) and plain.bytes == (ours / "plain.spz").stat().st_size
    run("view", ply, "-c", sample, "-o", "page.html", "--photographs", "64")
    page = spot.page(ours / "page.html", capture, photographs=64)
    assert page.gaussians == len(spot) and page.photographs > 0 and page.bytes == (ours / "page.html").stat().st_size
    run("render", ply, "-c", sample, "-o", "stills", "--view", view, "--pattern", "lollipop_1", "--pattern", white, "--size", "64x48", "--maps")
    assert spot.render(ours / "stills", sample, views=view, patterns=["lollipop_1", white], width=64, height=48, maps=True) == 9
    run("render", ply, "-c", sample, "-o", "film", "--orbit", "object,4", "--size", "64", "--video", "film.png")
    assert spot.render(ours / "film", capture, orbit="object", frames=4, width=64, video=ours / "film.png") == 4
    for kind, start in (("plain.spz", b"\x1f\x8b"), ("lit.ply", b"ply\n"), ("mesh.glb", b"glTF"), ("film.png", b"\x89PNG")):
        assert (ours / kind).read_bytes().startswith(start), kind
    files = sorted(f.relative_to(theirs) for f in theirs.rglob("*") if f.is_file())
    assert files == sorted(f.relative_to(ours) for f in ours.rglob("*") if f.is_file()) and len(files) > 15
    for file in files:
        assert (ours / file).read_bytes() == (theirs / file).read_bytes(), file

    for wrong, name in (
        (lambda: spot.export(ours / "a.ply", up="x"), "up"),
        (lambda: spot.export(ours / "a.obj"), "mesh"),
        (lambda: spot.export(ply), "relightable"),
        (lambda: spot.page(ours / "a.html", capture, form="gs-procams"), "falloff"),
        (lambda: spot.render(ours / "a", capture, orbit="moon"), "moon"),
        (lambda: spot.render(ours / "a", capture, views="nowhere"), "nowhere"),
    ):
        with pytest.raises(ffp.Error, match=name):
            wrong()
    assert not list(ours.glob("a*")) and ffp.Gaussians.load(ply).albedo.any()


def test_gaussians_are_put_together_and_moved(capture: ffp.Capture, gaussians: ffp.Gaussians) -> None:
    """A world that is turned, moved and enlarged looks the same to devices that go with it."""
    first, rest = gaussians[:700], gaussians[700:]
    whole = ffp.Gaussians.concatenate(part for part in (first, rest))
    for name, array in whole.arrays().items():
        np.testing.assert_array_equal(array, getattr(gaussians.copy(), name), name)

    turn, way, scale = devices.rotation_of((0.4, -1.1, 2.3)), np.array([3.0, -2.0, 1.0]), 2.5
    moved = gaussians.transformed(turn, way, scale)
    cameras = capture.camera(1), capture.projector(1)
    after = [p.moved(devices.rigid(turn, way)) for p in cameras]
    for p, q in zip(cameras, after):
        q.pose[:3, 3] = scale * turn @ p.position + way
    pattern, light = capture.pattern("lollipop_3"), capture.intensity
    renderer = ffp.Renderer()
    before = renderer.aim(gaussians, *cameras).shade(pattern, light, linear=True)
    shown = renderer.aim(moved, *after).shade(pattern, scale**2 * light, linear=True)
    assert before.max() > 0.3 and np.abs(shown - before).mean() < 2e-4 * before.mean()
    rvec = gaussians.transformed((0.4, -1.1, 2.3), way, scale)
    np.testing.assert_allclose(rvec.rotation, moved.rotation, atol=1e-6)
    np.testing.assert_array_equal(gaussians.transformed().centre, gaussians.centre)
    for given, name in (
        ({"rotation": 2 * np.eye(3)}, "rotation"),
        ({"rotation": -np.eye(3)}, "rotation"),
        ({"translation": (1, 2)}, "translation"),
        ({"scale": 0}, "scale"),
    ):
        with pytest.raises(ffp.ArgumentError, match=name):
            gaussians.transformed(**given)  # type: ignore[arg-type]
    with pytest.raises(ffp.ArgumentError, match="at least one"):
        ffp.Gaussians.concatenate([])


def test_maps_of_a_view(capture: ffp.Capture, gaussians: ffp.Gaussians) -> None:
    camera = capture.camera(0)
    maps = ffp.Renderer().aim(gaussians, camera, capture.projector(0)).maps()
    assert set(maps) == {"opacity", "depth", "normal", "albedo", "roughness", "ambient", "distortion"}
    there = maps["depth"] > 0
    distance = np.linalg.norm(camera.position - capture.centre)
    assert there.mean() > 0.1 and np.abs(maps["depth"][there] - distance).max() < 1.1 * capture.radius
    np.testing.assert_allclose(np.linalg.norm(maps["normal"][there], axis=-1), 1, atol=1e-4)
    assert np.abs(there - capture.coverage(0)).mean() < 0.02
    small = ffp.Renderer(form="paper", samples=1).aim(gaussians, camera.resized(33, 17), capture.projector(0))
    assert small.map("albedo").shape == (17, 33, 3)
    with pytest.raises(ffp.ArgumentError, match="expected one of"):
        small.map("gloss")


def test_a_camera_of_ones_own(capture: ffp.Capture, gaussians: ffp.Gaussians) -> None:
    camera = ffp.Pinhole.look_at(capture.camera(0).position, capture.centre, (200, 150), 50)
    opacity = ffp.Renderer().aim(gaussians, camera, capture.projector(0)).map("opacity")
    rows, columns = np.nonzero(opacity > 0.5)
    assert abs(rows.mean() - 75) < 25 and abs(columns.mean() - 100) < 25 and len(rows) > 1000
    own = capture.camera(0).pose[:3, 1]
    assert camera.pose[:3, 1] @ own > 0.9  # up is up


def test_refine_gains(capture: ffp.Capture, gaussians: ffp.Gaussians, tmp_path: Path) -> None:
    better = ffp.refine(gaussians, capture, steps=24, metrics=tmp_path / "metrics.jsonl")
    assert better.stats.psnr_after > better.stats.psnr_before + 1 and better.stats.steps == 24
    assert json.loads((tmp_path / "metrics.jsonl").read_text().splitlines()[-1])["step"] == 24
    scratch = ffp.fit_from_scratch(capture, steps=8)
    given = ffp.fit_from_scratch(capture, points=scratch, steps=8)
    assert given.stats.gaussians <= scratch.stats.gaussians
    assert len(scratch) == scratch.stats.gaussians > 100


def test_compensation_reaches_its_target(capture: ffp.Capture, gaussians: ffp.Gaussians) -> None:
    view = capture.view_ids[0]
    target = ffp.encode(capture.photograph(view, "all_white")) * 0.7  # as floats these are linear light
    found = ffp.compensate(gaussians, capture, target.astype(np.float32), views=view, steps=5)
    assert list(found.patterns) == list(found.seen) == list(found.targets) == [view]
    assert found.patterns[view].shape == (800, 800, 3) and found.seen[view].shape == (128, 128, 3)
    assert found.stats.psnr > found.stats.psnr_dark + 3
    with pytest.raises(ffp.ArgumentError):
        ffp.compensate(gaussians, capture, [])


def test_maps_go_to_and_fro(capture: ffp.Capture, gaussians: ffp.Gaussians) -> None:
    maps, stats = ffp.maps(gaussians, capture, capture.camera(1), capture.projector(1))
    assert maps["camera_to_projector"].shape == (128, 128, 3) and maps["lit"].shape[:2] == (800, 800)
    assert stats.lit_pixels > 500 and stats.median < 1 and 0 < stats.lit_share < 1
    place = maps["camera_to_projector"][maps["camera_to_projector"][..., 2] > 0]
    assert place[:, :2].min() > 0 and place[:, :2].max() < 800


def test_protocols_give_the_figures_of_evaluate(capture: ffp.Capture, sample: Path) -> None:
    scores = ffp.evaluate(sample, polish=0, targets="targets.json")

    def ours(inputs: protocols.Inputs) -> protocols.Predictor:
        gaussians, renderer = ffp.reconstruct(inputs.capture(), polish=0), ffp.Renderer()
        return lambda camera, projector, pattern: renderer.aim(gaussians, camera, projector).shade(
            pattern, inputs.intensity
        )

    rows = protocols.run(sample, {"ours": ours}, targets="targets.json")
    assert [s.protocol for s in scores] == ["novel_pose", "unseen", "rendering", "given"]
    assert [r.protocol for r in rows] == ["rendering", "novel_pose"]
    by_protocol = {score.protocol: score for score in scores}
    for row in rows:
        score = by_protocol[row.protocol]
        assert score.images == row.images > 10 and score.psnr > 25
        assert row.psnr == pytest.approx(score.psnr, abs=2e-3)
        assert row.psnr_foreground == pytest.approx(score.psnr_foreground, abs=2e-3)
        assert row.ssim == pytest.approx(score.ssim, abs=2e-5)
        assert math.isnan(row.lpips)
    assert math.isnan(scores[0].lpips) and scores[0].capture == "spot"
    assert "novel_pose" in protocols.table(rows) and "LPIPS" not in protocols.table(rows)
    for wrong in (math.nan, 255.0):
        picture = np.full((128, 128, 3), wrong)
        with pytest.raises(ffp.ArgumentError, match="floats in .0,1."):
            protocols.run(sample, {"wrong": lambda inputs, picture=picture: lambda *_: picture})


def test_rows_say_what_predicted(gaussians: ffp.Gaussians, sample: Path, tmp_path: Path) -> None:
    """By the names of the program, whose --merge takes rows of one predictor alone."""
    ply, out = tmp_path / "object.ply", tmp_path / "rows.json"
    gaussians.save(ply)

    def name(**options: Any) -> str:
        ffp.evaluate(sample, polish=0, json=out, **options)
        found: str = json.loads(out.read_text())["predictor"]
        return found

    shipped = Path(os.environ.get("FFPROCAMS_MODELS", sample.parents[1] / "models")) / "small.safetensors"
    assert name(gaussians=ply) == str(ply)
    assert name(predictor="match") == "pattern lookup at the matched depth"
    assert name(model="none") == "the classical initialisation, without weights"
    assert name() == name(model=ffp.Model.open()) == "the shipped weights"
    assert name(model=shipped) == name(model=ffp.Model.open(shipped)) == str(shipped)
    assert name(model="none", model_name="mine") == "mine"
    asked = [program(), "evaluate", sample, "--gaussians", ply, "--json", tmp_path / "program.json"]
    subprocess.run(asked, check=True, capture_output=True)
    assert json.loads((tmp_path / "program.json").read_text())["predictor"] == str(ply)


def test_generated_captures_are_captures(tmp_path: Path) -> None:
    folders = ffp.generate(
        tmp_path, preset="smoke", count=1, resolution=32, views=2, sensor=ffp.SensorFaults(read=0.01)
    )
    assert len(folders) == 1
    capture = ffp.Capture.open(folders[0])
    assert len(capture.view_ids) == 2 and capture.camera(0).width == 32
    assert "views" in ffp.info(folders[0])
    assert "views" in ffp.info(folders[0], report=tmp_path / "report.html")
    assert (tmp_path / "report.html").read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    capture.save(tmp_path / "again")
    again = ffp.Capture.open(tmp_path / "again")
    assert again.pattern_names == capture.pattern_names and again.view_ids == capture.view_ids
    before = capture.camera(1).pose.copy()
    stats = ffp.align(capture)
    assert stats.after <= stats.before and stats.elapsed_s > 0
    assert np.abs(capture.camera(1).pose - before).max() < 0.5
    known = ffp.align(again, gaussians=ffp.reconstruct(again, model="none", polish=0))
    assert known.known and not stats.known and 0 < known.after <= known.before
    with pytest.raises(ffp.ArgumentError, match="preset"):
        ffp.generate(tmp_path, preset="huge")


def test_a_simulated_rig_is_calibrated(tmp_path: Path) -> None:
    """The projector's patterns, photographs of a board under them, and the calibration: near the truth that made them."""
    shown = ffp.write_patterns(tmp_path / "codes", 256, 160, lollipops=0, focus=False)
    assert len(shown) == 2 + 2 * 8 + 2 * 8
    boards = tmp_path / "boards"
    ffp.generate(boards, photographs=tmp_path / "codes", attitudes=6, resolution=200, views=1, count=1)
    truth = json.loads((boards / "truth.json").read_text())
    try:
        stats = ffp.calibrate_rig(
            tmp_path / "rig.xml",
            sorted(boards.glob("attitude-*")),
            board=(9, 6),
            square=16,
            shown=tmp_path / "codes",
            fix_camera=["k3"],
            fix_projector=["k3"],
        )
    except ffp.UnsupportedError as without:
        pytest.skip(f"skipped: {without}")
    assert stats.used >= 3 and 0 < stats.both < 1 and not stats.has_axis and len(stats.axis) == 3
    written = (tmp_path / "rig.xml").read_text()
    found = float(written.split("<cam_int")[1].split("<data>")[1].split()[0])
    assert found == pytest.approx(truth["cam_K"][0][0], rel=0.02)
    whites = [boards / f"attitude-0{i}" / "002.png" for i in (0, 1)]
    ffp.calibrate_rig(None, whites, board=(9, 6), square=16, seen=tmp_path / "seen.json")
    seen = json.loads((tmp_path / "seen.json").read_text())["photographs"]
    assert [board["found"] for board in seen] == [True, True] and all(len(board["corners"]) == 54 for board in seen)
    with pytest.raises(ffp.ArgumentError, match="k9"):
        ffp.calibrate_rig(None, board=(9, 6), square=1, projector=(256, 160), fix_camera=["k9"])


def test_photographs_in_a_room(tmp_path: Path) -> None:
    ffp.write_patterns(tmp_path / "patterns", 96, 64, lollipops=1, focus=False, gray_codes=False)
    for folder, quality in (("fine", None), ("coarse", 20)):
        ffp.generate(
            tmp_path / folder,
            preset="smoke",
            photographs=tmp_path / "patterns",
            room=True,
            quality=quality,
            views=1,
            resolution=64,
            seed=5,
        )
    name = "view-000/002.JPG"  # white
    assert (tmp_path / "coarse" / name).stat().st_size < (tmp_path / "fine" / name).stat().st_size
    assert (tmp_path / "fine" / "empty" / "003.JPG").exists()
    with pytest.raises(ffp.ArgumentError, match="room"):
        ffp.generate(tmp_path / "none", room=True)


def test_training_makes_weights(sample: Path, tmp_path: Path) -> None:
    config = tmp_path / "config.json"
    sizes = {
        "model": "tiny",
        "resolution": 16,
        "views": 2,
        "targets": 1,
        "lollipops": 1,
        "pattern_side": 64,
        "steps": 4,
    }
    scenes = {"supervised_inputs": 1, "supervised_targets": 1, "samples": 1, "ambient_rays": 1, "pool": 2}
    config.write_text(json.dumps({**sizes, **scenes, "validate_every": 0, "log_every": 1}))
    weights = ffp.train(tmp_path / "out", config=config, stop_at=2)
    assert len((tmp_path / "out" / "metrics.jsonl").read_text().splitlines()) == 2
    ffp.train(tmp_path / "out", resume=True, stop_at=3)
    ffp.train(tmp_path / "out", resume=True)
    assert len(ffp.reconstruct(ffp.Capture.open(sample), weights, polish=0)) > 0
    with pytest.raises(ffp.Error, match="scene.json"):
        ffp.train(tmp_path / "other", config=sample / "scene.json")
