"""Wrong arguments of public functions and types are refused by their names."""

from __future__ import annotations

import dataclasses
import importlib.util
import inspect
import re
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Callable

import ffprocams as ffp
import numpy as np
import pytest
from ffprocams import interop, perceptual, protocols

MODULES = [ffp, protocols, interop, perceptual]
if importlib.util.find_spec("torch"):
    MODULES.append(importlib.import_module("ffprocams.torch"))
PICTURE = np.zeros((4, 4, 3), np.float32)
PINHOLE = ffp.Pinhole(4, 4, 4.0, 4.0, 2.0, 2.0)
ROW = ([[0, 0, 0]], [[1, 1, 1]], [[1, 0, 0, 0]], [1], [[1, 1, 1]], [1], [[0, 0, 0]])
K = np.diag([4.0, 4.0, 1.0])


@pytest.fixture(scope="module")
def at(capture: ffp.Capture, gaussians: ffp.Gaussians, tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """Arguments for the calls below, which write nothing."""
    aimed = ffp.Renderer().aim(gaussians, capture.camera(0), capture.projector(0))
    out, light = tmp_path_factory.mktemp("arguments") / "none", capture.intensity
    return SimpleNamespace(c=capture, g=gaussians, r=aimed, light=light, out=out, model=ffp.Model.open())


# The argument that the error names, and the call.
WRONG: list[tuple[str, Callable[[Any], Any]]] = [
    ("capture", lambda at: ffp.reconstruct(None)),
    ("capture", lambda at: ffp.reconstruct(at.g)),
    ("model", lambda at: ffp.reconstruct(at.c, 3)),
    ("pattern", lambda at: ffp.reconstruct(at.c, pattern=[1])),
    ("polish", lambda at: ffp.reconstruct(at.c, polish=1.5)),
    ("polish", lambda at: ffp.reconstruct(at.c, polish=True)),
    ("polish", lambda at: ffp.reconstruct(at.c, polish=-2)),
    ("noise", lambda at: ffp.reconstruct(at.c, noise=float("nan"))),
    ("noise", lambda at: ffp.reconstruct(at.c, noise="0.1")),
    ("layers", lambda at: ffp.reconstruct(at.c, layers=-1)),
    ("form", lambda at: ffp.reconstruct(at.c, form="round")),
    ("samples", lambda at: ffp.reconstruct(at.c, samples=5)),
    ("force", lambda at: ffp.reconstruct(at.c, force="no")),
    ("width", lambda at: ffp.reconstruct(at.c, width=2**40)),
    ("progress", lambda at: ffp.reconstruct(at.c, progress=1)),
    ("threads", lambda at: ffp.reconstruct(at.c, threads=-1)),
    ("threads", lambda at: ffp.reconstruct(at.c, threads=1.0)),
    ("device", lambda at: ffp.reconstruct(at.c, device="gpu")),
    ("gaussians", lambda at: ffp.refine(None, at.c)),
    ("steps", lambda at: ffp.refine(at.g, at.c, steps=2.5)),
    ("seconds", lambda at: ffp.refine(at.g, at.c, seconds=float("inf"))),
    ("seed", lambda at: ffp.refine(at.g, at.c, seed=2**63)),
    ("seed", lambda at: ffp.refine(at.g, at.c, seed="1")),
    ("metrics", lambda at: ffp.refine(at.g, at.c, metrics=1)),
    ("points", lambda at: ffp.fit_from_scratch(at.c, points=at.c)),
    ("patterns", lambda at: ffp.fit_from_scratch(at.c, patterns=None)),
    ("gaussians", lambda at: ffp.Renderer().aim(None, PINHOLE, PINHOLE)),
    ("camera", lambda at: ffp.Renderer().aim(at.g, np.eye(4), PINHOLE)),
    ("projector", lambda at: ffp.Renderer().aim(at.g, PINHOLE, None)),
    ("samples", lambda at: ffp.Renderer(samples=True)),
    ("pattern", lambda at: at.r.shade("white", at.light)),
    ("intensity", lambda at: at.r.shade(None, None)),
    ("intensity", lambda at: at.r.shade(None, [1, 2])),
    ("out", lambda at: at.r.shade(None, at.light, out=[[[0, 0, 0]]])),
    ("dtype", lambda at: at.r.shade(None, at.light, dtype="uint9")),
    ("linear", lambda at: at.r.shade(None, at.light, linear=1)),
    ("patterns", lambda at: at.r.shade_many(None, at.light)),
    ("name", lambda at: at.r.map("gloss")),
    ("name", lambda at: at.r.map(0)),
    ("path", lambda at: ffp.Capture.open(None)),
    ("path", lambda at: ffp.Capture.open("a\0b")),
    ("views", lambda at: ffp.Capture.from_arrays([PICTURE], {})),
    ("patterns", lambda at: ffp.Capture.from_arrays([], ["black"])),
    ("radius", lambda at: ffp.Capture.from_arrays([], {}, radius="1")),
    ("held_out", lambda at: ffp.Capture.from_arrays([], {}, held_out="white")),
    ("view", lambda at: at.c.camera(1.0)),
    ("view", lambda at: at.c.projector("nowhere")),
    ("pattern", lambda at: at.c.photograph(0, None)),
    ("pattern", lambda at: at.c.pattern(True)),
    ("view", lambda at: at.c.coverage(None)),
    ("folder", lambda at: at.c.save(None)),
    ("threads", lambda at: at.c.check(threads="4")),
    ("photographs", lambda at: ffp.View("a", PINHOLE, PINHOLE, [PICTURE])),
    ("mask", lambda at: ffp.View("a", PINHOLE, PINHOLE, {}, mask="mask.png")),
    ("capture", lambda at: ffp.align("folder")),
    ("focal_lengths", lambda at: ffp.align(at.c, focal_lengths=2)),
    ("gaussians", lambda at: ffp.find_projector(at.c, None)),
    ("width", lambda at: ffp.Pinhole(4.5, 4, 4.0, 4.0, 2.0, 2.0)),
    ("fx", lambda at: ffp.Pinhole(4, 4, float("nan"), 4.0, 2.0, 2.0)),
    ("pose", lambda at: at.g and ffp.Renderer().aim(at.g, dataclasses.replace(PINHOLE, pose=np.eye(3)), PINHOLE)),
    ("matrix", lambda at: ffp.Pinhole.from_opencv(np.eye(2), np.eye(3), np.zeros(3), (4, 4))),
    ("size", lambda at: ffp.Pinhole.from_opencv(K, np.eye(3), np.zeros(3), 4)),
    ("size", lambda at: ffp.Pinhole.look_at((0, 0, 0), (0, 0, 1), (4, 4, 4), 50)),
    ("fov", lambda at: ffp.Pinhole.look_at((0, 0, 0), (1, 0, 0), (4, 4), None)),
    ("fov", lambda at: ffp.Pinhole.look_at((0, 0, 0), (1, 0, 0), (4, 4), 0)),
    ("translation", lambda at: ffp.Pinhole.from_opencv(K, np.eye(3), (0, 0), (4, 4))),
    ("motion", lambda at: PINHOLE.moved("left")),
    ("motion", lambda at: PINHOLE.moved(np.eye(3))),
    ("width", lambda at: PINHOLE.resized(0, 4)),
    ("height", lambda at: PINHOLE.resized(4, 2.5)),
    ("source", lambda at: ffp.Calibration.from_dict(None)),
    ("path", lambda at: ffp.Calibration.load(7)),
    ("camera", lambda at: ffp.Calibration(None, PINHOLE)),
    ("axis", lambda at: ffp.Calibration(PINHOLE, PINHOLE).turned((0, 0, 0), (0, 0, 0), [45])),
    ("angles", lambda at: ffp.Calibration(PINHOLE, PINHOLE).turned((0, 0, 1), (0, 0, 0), 45)),
    ("path", lambda at: ffp.Gaussians.load(b"object.ply")),
    ("contents", lambda at: ffp.Gaussians.from_bytes("ply")),
    ("centre", lambda at: ffp.Gaussians.from_arrays(None, *ROW[1:])),
    ("opacity", lambda at: ffp.Gaussians.from_arrays(*ROW[:3], ["firm"], *ROW[4:])),
    ("rows", lambda at: at.g["first"]),
    ("parts", lambda at: ffp.Gaussians.concatenate("object.ply")),
    ("parts", lambda at: ffp.Gaussians.concatenate([at.g, None])),
    ("scale", lambda at: at.g.transformed(scale="2")),
    ("roughness", lambda at: ffp.Gaussians.from_3dgs(ROW[0], ROW[1], ROW[2], [0], ROW[4], roughness=None)),
    ("path", lambda at: at.g.save(None)),
    ("resolution", lambda at: at.g.export(at.out, at.c, resolution=64.0)),
    ("up", lambda at: at.g.export(at.out, up="x")),
    ("capture", lambda at: at.g.page(at.out, None)),
    ("frames", lambda at: at.g.render(at.out, at.c, frames="4")),
    ("path", lambda at: ffp.Model.open(1)),
    ("exact", lambda at: at.model.to_bytes(exact="yes")),
    ("targets", lambda at: ffp.compensate(at.g, at.c, None)),
    ("gain", lambda at: ffp.compensate(at.g, at.c, PICTURE, gain=float("nan"))),
    ("fit", lambda at: ffp.compensate(at.g, at.c, PICTURE, fit="fill")),
    ("camera", lambda at: ffp.maps(at.g, at.c, 0, PINHOLE)),
    ("captures", lambda at: ffp.evaluate(None)),
    ("predictor", lambda at: ffp.evaluate(at.out, predictor="guess")),
    ("folder", lambda at: ffp.generate(None)),
    ("views", lambda at: ffp.generate(at.out, views=1.5)),
    ("sensor", lambda at: ffp.generate(at.out, sensor={"read": 0.1})),
    ("read", lambda at: ffp.SensorFaults(read="0.1")),
    ("glare", lambda at: ffp.LightFaults(glare=None)),
    ("calibrations", lambda at: ffp.import_capture(at.out, 5)),
    ("images", lambda at: ffp.import_capture(at.out, "a.xml", images={"black": None})),
    ("views", lambda at: ffp.import_capture(at.out, "a.xml", views="first")),
    ("angles", lambda at: ffp.Turntable(angles=["45"])),
    ("axis", lambda at: ffp.import_capture(at.out, "a.xml", turntable=ffp.Turntable(axis=(1, 0)))),
    ("left", lambda at: ffp.CalibratedAt(left=0.5)),
    ("path", lambda at: ffp.info(None)),
    ("width", lambda at: ffp.write_patterns(at.out, "800", 800)),
    ("board", lambda at: ffp.calibrate_rig(None, board=(9, 6, 1), square=1)),
    ("fix_camera", lambda at: ffp.calibrate_rig(None, board=(9, 6), square=1, fix_camera="k1")),
    ("steps", lambda at: ffp.train(at.out, steps=None)),
    ("linear", lambda at: ffp.encode("white")),
    ("encoded", lambda at: ffp.decode(None)),
    ("a", lambda at: protocols.psnr("a.png", PICTURE)),
    ("b", lambda at: protocols.ssim(PICTURE, None)),
    ("b", lambda at: protocols.ssim(PICTURE, PICTURE[:2])),
    ("mask", lambda at: protocols.psnr(PICTURE, PICTURE, np.ones((2, 2)))),
    ("weights", lambda at: protocols.lpips([PICTURE], [PICTURE], None)),
    ("methods", lambda at: protocols.run(at.out, {"ours": 1})),
    ("capture", lambda at: protocols.inputs_of("folder")),
    ("rows", lambda at: protocols.table(None)),
    ("folder", lambda at: interop.to_transforms(at.c, None)),
    ("capture", lambda at: interop.to_colmap("folder", at.out)),
    ("file", lambda at: interop.from_transforms(None)),
    ("folder", lambda at: interop.from_colmap(3)),
    ("files", lambda at: perceptual.convert("alex.pth", at.out)),
]  # fmt: skip


@pytest.mark.parametrize(("name", "call"), WRONG)
def test_wrong_arguments_are_named(at: SimpleNamespace, name: str, call: Callable[[Any], Any]) -> None:
    with pytest.raises((TypeError, ValueError)) as wrong:
        call(at)
    assert isinstance(wrong.value, ffp.ArgumentError) and name in re.split(r"\W+", wrong.value.field or ""), str(wrong.value)
    assert not at.out.exists()


def test_errors_say_what_was_expected_and_given(at: SimpleNamespace) -> None:
    for call, text in (
        (lambda: ffp.reconstruct(at.c, polish=1.5), "expected an integer or None, not 1.5 (polish)"),
        (lambda: at.r.aim(None, PINHOLE, PINHOLE), "expected Gaussians or a path, not None (gaussians)"),
        (lambda: ffp.reconstruct(at.c, polish=np.float32(1.5)), "expected an integer or None, not 1.5 (polish)"),
        (lambda: ffp.calibrate_rig(None, board=9, square=1), "expected 2 integers, not 9 (board)"),
        (lambda: ffp.reconstruct(at.c, device="gpu"), "expected one of cpu, cuda, not 'gpu' (device)"),
    ):  # fmt: skip
        with pytest.raises(ffp.ArgumentError) as wrong:
            call()  # type: ignore[no-untyped-call]
        assert str(wrong.value) == text
    with pytest.raises(ffp.ArgumentTypeError):
        ffp.info(1)  # type: ignore[arg-type]


def test_numpy_s_numbers_and_pathlib_s_paths_serve(at: SimpleNamespace, sample: Path) -> None:
    made = ffp.reconstruct(sample, None, polish=np.int64(0), noise=np.float32(0), force=np.bool_(False))
    assert len(made) > 0 and at.c.camera(np.int32(1)).width == 128
    assert ffp.Pinhole(np.int16(8), np.uint8(4), 1, np.float64(1), 2, 2).resized(np.int64(4), 2).width == 4
    assert len(ffp.refine(made, at.c, steps=np.uint16(1), seed=2**40, patterns=np.array(["lollipop_1"]))) > 0


def entries() -> Iterator[tuple[str, Any]]:
    """All public functions and methods, by their names, and the types that are made by calling them."""
    for module in MODULES:
        names = getattr(module, "__all__", [n for n, m in vars(module).items() if n[0] != "_" and getattr(m, "__module__", "") == module.__name__])
        for name in names:
            public = getattr(module, name)
            if inspect.isfunction(public):
                yield f"{module.__name__}.{name}", public
            elif inspect.isclass(public) and public.__module__.startswith("ffprocams") and not issubclass(public, (Exception, int)):
                for inner, method in inspect.getmembers(public, callable):
                    if inner[0] != "_" and inspect.isroutine(method) and (getattr(method, "__module__", None) or "").startswith("ffprocams"):
                        yield f"{module.__name__}.{name}.{inner}", method


def test_public_functions_check_their_arguments() -> None:
    unchecked = [name for name, public in entries() if inspect.signature(public).parameters.keys() - {"self"} and not hasattr(public, "__wrapped__")]
    assert unchecked == ["ffprocams.perceptual.main"]


def test_docstrings_say_what_is_raised() -> None:
    assert [name for name, public in entries() if inspect.signature(public).parameters.keys() - {"self"} and "Raises" not in (public.__doc__ or "")] == []
