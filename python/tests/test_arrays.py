"""Inputs and outputs of the library as numpy arrays."""

from __future__ import annotations

import gc
import pickle
from pathlib import Path

import ffprocams as ffp
import numpy as np
import pytest


def rebuilt(capture: ffp.Capture, **changes: object) -> ffp.Capture:
    views = [
        ffp.View(
            v,
            capture.camera(v),
            capture.projector(v),
            {p: capture.photograph(v, p) for p in capture.pattern_names},
            mask=capture.coverage(v),
            masked=True,
        )
        for v in capture.view_ids
    ]
    given = {
        "black": "all_black",
        "white": "all_white",
        "intensity": capture.intensity,
        "centre": capture.centre,
    }
    patterns = {p: capture.pattern(p) for p in capture.pattern_names}
    return ffp.Capture.from_arrays(views, patterns, **{**given, "radius": capture.radius, **changes})


def test_a_capture_from_arrays_is_the_capture_from_files(capture: ffp.Capture) -> None:
    memory = rebuilt(capture, held_out=["lollipop_5"])
    assert memory.view_ids == capture.view_ids and memory.pattern_names == capture.pattern_names
    assert (memory.black, memory.white, memory.held_out) == ("all_black", "all_white", ("lollipop_5",))
    a, b = (ffp.reconstruct(c, "none", pattern="lollipop_0", polish=1) for c in (capture, memory))
    assert len(a) > 1000
    for name, array in a.arrays().items():
        np.testing.assert_array_equal(array, b.arrays()[name], name)


def test_files_may_be_bytes(gaussians: ffp.Gaussians, tmp_path: Path) -> None:
    path = tmp_path / "saved.ply"
    gaussians.save(path)
    contents = gaussians.to_bytes()
    assert contents == path.read_bytes()
    again = ffp.Gaussians.from_bytes(contents)
    assert len(again) > 1000 and again.to_bytes() == ffp.Gaussians.load(path).to_bytes()
    with pytest.raises(ffp.FileFormatError, match="mine"):
        ffp.Gaussians.from_bytes(contents[:-1], "mine")
    model = ffp.Model.open()
    for name, values in ffp.Model.from_bytes(model.to_bytes(exact=True)).weights().items():
        np.testing.assert_array_equal(values, model.weights()[name], name)


def test_several_patterns_are_used(capture: ffp.Capture) -> None:
    one = ffp.reconstruct(capture, "none", pattern="lollipop_2", polish=0)
    two = ffp.reconstruct(capture, "none", pattern=["lollipop_2", "lollipop_4"], polish=0)
    assert (one.stats.pattern, one.stats.patterns) == ("lollipop_2", 1)
    assert (two.stats.pattern, two.stats.patterns) == ("lollipop_2", 2)
    assert len(one) != len(two) or not np.array_equal(one.centre, two.centre)
    with pytest.raises(ffp.Error, match="named twice"):
        ffp.reconstruct(capture, "none", pattern=["lollipop_2", "lollipop_2"], polish=0)


def test_scattered_light(capture: ffp.Capture, gaussians: ffp.Gaussians, tmp_path: Path) -> None:
    """None is none; it follows the pattern's mean, and comes back from a file, a pickle, a slice and a sum of sets."""
    camera, projector = capture.camera(0), capture.projector(0)
    given = gaussians.arrays()
    plain = ffp.Gaussians.from_arrays(**{**given, "scattered": None})
    assert not plain.scattered.any() and plain.to_bytes() == gaussians.copy().to_bytes()
    light = np.full((len(gaussians), 3), (0.03, 0.02, 0.01), np.float32)
    lit = ffp.Gaussians.from_arrays(**{**given, "scattered": light})
    lit.save(tmp_path / "lit.ply")
    for other in (ffp.Gaussians.load(tmp_path / "lit.ply"), pickle.loads(pickle.dumps(lit)), lit[:], lit.transformed()):
        np.testing.assert_array_equal(other.scattered, light)
    assert ffp.Gaussians.concatenate([plain, lit]).scattered.sum() == pytest.approx(light.sum(), rel=1e-5)
    half = np.zeros((projector.height, projector.width, 3), np.float32) + 0.5

    def shown(which: ffp.Gaussians, pattern: np.ndarray | None) -> np.ndarray:
        return ffp.Renderer().aim(which, camera, projector).shade(pattern, capture.intensity, dtype=np.float32, linear=True)

    np.testing.assert_array_equal(shown(lit, None), shown(plain, None))
    covered = ffp.Renderer().aim(lit, camera, projector).map("opacity") > 0.9999
    added = (shown(lit, half) - shown(plain, half))[covered]
    assert np.allclose(added, 0.5 * light[0], atol=2e-5)
    with pytest.raises(ffp.Error, match="scattered"):
        ffp.Gaussians.from_arrays(**{**given, "scattered": -light})


def test_arrays_are_the_librarys_memory_and_keep_it(capture: ffp.Capture, gaussians: ffp.Gaussians) -> None:
    own = gaussians.copy()
    centre, before = own.centre, own.centre.copy()
    centre += 1  # seen by the library, not by a copy
    np.testing.assert_array_equal(own.centre, before + np.float32(1))
    np.testing.assert_array_equal(gaussians.centre, before)
    opacity = own.opacity
    del own, centre
    gc.collect()
    others = [gaussians.copy() for _ in range(5)]
    for other in others:  # freed memory would be theirs now
        other.opacity[:] = 0
    np.testing.assert_array_equal(opacity, gaussians.opacity)
    photograph = capture.photograph(0, "all_white")
    assert photograph is not None and photograph.shape == (128, 128, 3) and photograph.dtype == np.float32
    with pytest.raises(ValueError, match="read-only"):
        photograph[0] = 1


def test_a_reconstruction_outlives_its_capture(sample: object) -> None:
    photograph = ffp.Capture.open(str(sample)).photograph(1, "lollipop_0")
    again = ffp.Capture.open(str(sample))
    gc.collect()
    np.testing.assert_array_equal(photograph, again.photograph(1, "lollipop_0"))


def test_gaussians_go_out_and_in(gaussians: ffp.Gaussians, tmp_path: object) -> None:
    again = ffp.Gaussians.from_arrays(**{n: a.tolist() for n, a in gaussians.arrays().items()})
    for name, array in gaussians.arrays().items():
        np.testing.assert_array_equal(array, again.arrays()[name], name)
    arrays = gaussians.arrays()
    with pytest.raises(ffp.ArgumentError, match="opacity") as wrong:
        ffp.Gaussians.from_arrays(**{**arrays, "opacity": arrays["opacity"] + 1})
    assert wrong.value.field == "opacity" and wrong.value.code == ffp.ErrorCode.ARGUMENT
    with pytest.raises(ffp.ArgumentError, match="shape"):
        ffp.Gaussians.from_arrays(**{**arrays, "rotation": arrays["centre"]})
    broken = gaussians.copy()
    broken.scale[7] = np.nan
    with pytest.raises(ffp.ArgumentError, match="row 7"):
        broken.check()


def test_3dgs_is_what_the_ply_holds(gaussians: ffp.Gaussians, tmp_path: object) -> None:
    gaussians.save(f"{tmp_path}/spot.ply")
    data = Path(f"{tmp_path}/spot.ply").read_bytes()
    head, _, body = data.partition(b"end_header\n")
    names = [line.split()[2].decode() for line in head.splitlines() if line.startswith(b"property")]
    ply = np.frombuffer(body, [(n, "<f4") for n in names])
    kept = gaussians.opacity >= np.float32(1 / 255)
    assert len(ply) == kept.sum()
    ours = {n: a[kept] for n, a in gaussians.to_3dgs().items()}
    columns = {"means": ("x", "y", "z"), "quats": ("rot_0", "rot_1", "rot_2", "rot_3")}
    columns |= {"scales": ("scale_0", "scale_1", "scale_2"), "opacities": ("opacity",)}
    columns |= {"sh0": ("f_dc_0", "f_dc_1", "f_dc_2")}
    for name, of in columns.items():
        stored = np.stack([ply[c] for c in of], -1).reshape(ours[name].shape)
        np.testing.assert_allclose(ours[name], stored, rtol=1e-5, atol=1e-5, err_msg=name)
    again = ffp.Gaussians.load(f"{tmp_path}/spot.ply")
    np.testing.assert_allclose(again.albedo, gaussians.albedo[kept], atol=1e-5)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16, np.float32, np.float64, np.bool_])
def test_pictures_of_any_kind_and_layout(capture: ffp.Capture, gaussians: ffp.Gaussians, kind: type) -> None:
    renderer = ffp.Renderer().aim(gaussians, capture.camera(0), capture.projector(0))
    one = (np.indices((800, 800)).sum(0) // 50 % 2).astype(
        np.uint8
    )  # black and white: the same in every encoding
    most = {np.uint8: 255, np.uint16: 65535}.get(kind, 1)
    plain = np.repeat((one.astype(np.int64) * most).astype(kind)[:, :, None], 3, 2)
    want = renderer.shade(np.repeat(one[:, :, None] * np.uint8(255), 3, 2), capture.intensity)
    assert want.max() > 100
    framed = np.zeros((810, 820, 3), kind)
    framed[5:-5, 10:-10] = plain
    layouts = {
        "plain": plain,
        "grey": plain[:, :, 0],
        "Fortran": np.asfortranarray(plain),
        "inside another": framed[5:-5, 10:-10],
        "upside down": np.flipud(np.flipud(plain).copy()),
        "reversed colours": plain[:, :, ::-1],
    }
    for name, pattern in layouts.items():
        np.testing.assert_array_equal(renderer.shade(pattern, capture.intensity), want, name)


def test_wrong_pictures_are_refused(capture: ffp.Capture, gaussians: ffp.Gaussians) -> None:
    renderer = ffp.Renderer()
    with pytest.raises(ffp.ArgumentError, match="aimed"):
        renderer.shade(None, 1)
    renderer.aim(gaussians, capture.camera(0), capture.projector(0))
    for pattern in (
        np.zeros((800, 800, 2), np.uint8),
        np.zeros(800, np.uint8),
        np.zeros((800, 800), np.int64),
    ):
        with pytest.raises(ffp.ArgumentError) as wrong:
            renderer.shade(pattern, 1)
        assert wrong.value.field == "pattern"
    with pytest.raises(ffp.ArgumentError):  # not of the projector's size
        renderer.shade(np.zeros((80, 80, 3), np.uint8), 1)
    for out in (
        np.zeros((128, 128, 3), np.int32),
        np.zeros((128, 128, 4), np.uint8)[..., :3],
        np.zeros((9, 9, 3), np.uint8),
    ):
        with pytest.raises(ffp.ArgumentError):
            renderer.shade(None, 1, out=out)


def test_wrong_captures_are_refused_by_name(capture: ffp.Capture) -> None:
    def message(**changes: object) -> str:
        with pytest.raises(ffp.ArgumentError) as wrong:
            rebuilt(capture, **changes)
        return str(wrong.value)

    assert "grey" in message(white="grey")
    assert "numbers" in message(intensity=[1, 2])
    view = ffp.View("a", capture.camera(0), capture.projector(0), {"black": np.zeros((5, 5, 3), np.uint8)})
    with pytest.raises(ffp.Error) as wrong:
        ffp.Capture.from_arrays([view], {"black": None, "white": None})
    assert "a" in str(wrong.value)
