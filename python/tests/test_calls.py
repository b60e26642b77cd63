"""Progress, cancelling, errors, threads."""

from __future__ import annotations

import logging
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import ffprocams as ffp
import numpy as np
import pytest


def test_progress_is_told(capture: ffp.Capture) -> None:
    told: list[ffp.Progress] = []
    ffp.reconstruct(capture, "none", polish=100, progress=told.append)  # takes longer than the time between two reports
    assert any(p.total == 100 and 0 <= p.done <= 100 and p.stage for p in told)


def test_progress_cancels(capture: ffp.Capture) -> None:
    begin = time.monotonic()
    with pytest.raises(ffp.CancelledError) as cancelled:
        ffp.reconstruct(capture, "none", polish=100000, progress=lambda p: p.done < 2)
    assert cancelled.value.code == ffp.ErrorCode.CANCELLED
    assert time.monotonic() - begin < 60


def test_what_the_progress_function_raises_comes_out(capture: ffp.Capture) -> None:
    def fail(progress: ffp.Progress) -> None:
        raise LookupError("mine")

    with pytest.raises(LookupError, match="mine"):
        ffp.reconstruct(capture, "none", polish=100000, progress=fail)

    def again(progress: ffp.Progress) -> None:
        ffp.info("README.md")

    with pytest.raises(RuntimeError, match="must not call"):
        ffp.reconstruct(capture, "none", polish=100000, progress=again)
    assert len(ffp.reconstruct(capture, "none", polish=0)) > 0  # nothing is left behind


def test_ctrl_c_ends_a_call(sample: Path, tmp_path: Path) -> None:
    program = (
        "import ffprocams as f, signal, sys, time\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # whoever runs the tests may ignore it
        "c = f.Capture.open(sys.argv[1])\n"
        "print('begun', flush=True)\n"
        "try:\n"
        "    f.reconstruct(c, 'none', polish=10**7, progress=False)\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted', f.reconstruct(c, 'none', polish=0), flush=True)\n"
    )
    child = subprocess.Popen([sys.executable, "-c", program, sample], stdout=subprocess.PIPE, text=True)
    assert child.stdout is not None
    assert child.stdout.readline() == "begun\n"
    time.sleep(1)
    begin = time.monotonic()
    child.send_signal(signal.SIGINT)
    try:
        rest, _ = child.communicate(timeout=60)
    finally:
        child.kill()
    assert "interrupted <Reconstructed" in rest and child.returncode == 0
    assert time.monotonic() - begin < 30


def test_a_fit_that_is_stopped_gives_the_best_so_far(capture: ffp.Capture, gaussians: ffp.Gaussians) -> None:
    before = {n: a.copy() for n, a in gaussians.arrays().items()}
    better = ffp.refine(gaussians, capture, steps=10**6, progress=lambda p: p.done < 4)
    assert better.stats.stopped and better.stats.steps < 10**6
    for name, array in gaussians.arrays().items():  # what was given stays
        np.testing.assert_array_equal(array, before[name], name)

    def fail(progress: ffp.Progress) -> None:
        raise LookupError

    with pytest.raises(LookupError):
        ffp.refine(gaussians, capture, steps=10**6, progress=fail)


def test_bars(capture: ffp.Capture, capsys: pytest.CaptureFixture[str]) -> None:
    tqdm = pytest.importorskip("tqdm")
    ffp.reconstruct(capture, "none", polish=0, progress=None)
    assert capsys.readouterr().err == ""  # nobody looks
    bars = []

    class Bar(tqdm.tqdm):  # type: ignore[misc,name-defined]
        def __init__(self, *args: object, **named: object) -> None:
            super().__init__(*args, **{**named, "delay": 0, "mininterval": 0})
            bars.append(self)

    original, tqdm.tqdm = tqdm.tqdm, Bar
    try:
        ffp.reconstruct(capture, "none", polish=40, progress=True)
    finally:
        tqdm.tqdm = original
    assert any(bar.total == 40 and bar.n > 0 for bar in bars) and "/40" in capsys.readouterr().err


def test_errors_know_code_file_and_field(tmp_path: Path, sample: Path, capture: ffp.Capture) -> None:
    (tmp_path / "render_poses.json").write_text("{")
    with pytest.raises(ffp.FileFormatError) as wrong:
        ffp.Capture.open(tmp_path / "render_poses.json")
    assert wrong.value.code == ffp.ErrorCode.FILE
    assert wrong.value.file == str(tmp_path / "render_poses.json")
    assert isinstance(wrong.value, ValueError) and isinstance(wrong.value, ffp.Error)
    (tmp_path / "scene.json").write_text('{"format": "ffprocams-capture", "version": 99}')
    with pytest.raises(ffp.Error) as wrong:
        ffp.Capture.open(tmp_path)
    assert wrong.value.file == str(tmp_path / "scene.json") and wrong.value.field == "version"
    with pytest.raises(ffp.InputOutputError) as unwritten:
        ffp.reconstruct(capture, "none", polish=0).save(tmp_path / "no" / "where.ply")
    assert isinstance(unwritten.value, OSError) and unwritten.value.code == ffp.ErrorCode.IO
    with pytest.raises(ffp.Error):
        ffp.Model.open(sample / "README.md")
    for bad in ({"polish": -5}, {"form": "other"}, {"samples": 9}, {"threads": -1}, {"device": "abacus"}):
        with pytest.raises(ffp.ArgumentError) as argument:
            ffp.reconstruct(capture, "none", **bad)  # type: ignore[arg-type]
        assert argument.value.field == next(iter(bad))
    with pytest.raises(ffp.UnsupportedError, match="GPU"):  # the package is built without one
        ffp.reconstruct(capture, "none", device="cuda")
    with pytest.raises(IndexError):
        capture.camera(99)


def test_messages_are_taken_apart() -> None:
    from ffprocams.errors import _CLASSES, ErrorCode

    where = "/a (b)/scene.json: views[0].c2w"
    error = _CLASSES[ErrorCode.FILE](f"is not 4 x 4 ({where})", ErrorCode.FILE, where)
    assert (error.what, error.file, error.field) == ("is not 4 x 4", "/a (b)/scene.json", "views[0].c2w")
    error = _CLASSES[ErrorCode.MEMORY]("out of memory", ErrorCode.MEMORY)
    assert (error.what, error.file, error.field) == ("out of memory", None, None)
    assert isinstance(error, MemoryError)


def test_what_the_library_says_is_logged(capture: ffp.Capture, caplog: pytest.LogCaptureFixture) -> None:
    white = np.zeros((128, 128, 3), np.uint8)
    white[40:90, 40:90] = 200
    photographs = {
        "black": np.zeros_like(white),
        "white": white,
    }  # no mask and no alpha: it is guessed, and said
    view = ffp.View("a", capture.camera(0), capture.projector(0), photographs)
    with caplog.at_level(logging.INFO, "ffprocams"):
        made = ffp.Capture.from_arrays(
            [view], {"black": None, "white": None, "x": np.zeros((800, 800, 3), np.uint8)}
        )
    assert made.coverage(0)[60, 60] == 1 and made.coverage(0)[0, 0] == 0
    assert caplog.records and all(r.name == "ffprocams" for r in caplog.records)


def test_threads_side_by_side(sample: Path) -> None:
    """Two captures at once give what they give alone, and other threads run meanwhile."""
    captures = [ffp.Capture.open(sample) for _ in range(2)]
    patterns = ("lollipop_0", "lollipop_3")

    def work(i: int) -> ffp.Gaussians:
        return ffp.reconstruct(captures[i], "none", pattern=patterns[i], polish=4, threads=2)

    alone = [work(i).arrays() for i in range(2)]
    together: list[object] = [None, None]
    threads = [
        threading.Thread(target=lambda i=i: together.__setitem__(i, work(i).arrays())) for i in range(2)
    ]
    ticks = 0
    for thread in threads:
        thread.start()
    while any(thread.is_alive() for thread in threads):
        time.sleep(0.002)
        ticks += 1
    assert ticks > 20  # the GIL was free
    for want, got in zip(alone, together):
        assert isinstance(got, dict)
        for name, array in want.items():
            np.testing.assert_array_equal(array, got[name], name)


def test_one_handle_serves_many_threads(capture: ffp.Capture, gaussians: ffp.Gaussians) -> None:
    renderer = ffp.Renderer(threads=1).aim(gaussians, capture.camera(0), capture.projector(0))
    names = capture.pattern_names[2:]
    want = {n: renderer.shade(capture.pattern(n), capture.intensity) for n in names}
    wrong: list[str] = []

    def work(name: str) -> None:
        for _ in range(10):
            if not np.array_equal(renderer.shade(capture.pattern(name), capture.intensity), want[name]):
                wrong.append(name)

    threads = [threading.Thread(target=work, args=(n,)) for n in names]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_gaussians_are_pickled_and_other_handles_are_not(gaussians: ffp.Reconstructed, capture: ffp.Capture) -> None:
    import pickle

    again = pickle.loads(pickle.dumps(gaussians))
    assert isinstance(again, ffp.Reconstructed) and repr(again.stats) == repr(gaussians.stats)  # NaN is not itself
    for name, array in gaussians.arrays().items():
        np.testing.assert_array_equal(again.arrays()[name], array, name)
    with pytest.raises(TypeError, match="save"):
        pickle.dumps(capture)


def test_gaussians_are_sliced(gaussians: ffp.Gaussians) -> None:
    upper = gaussians.centre[:, 1] > 0
    assert 0 < len(gaussians[upper]) == int(upper.sum()) < len(gaussians)
    np.testing.assert_array_equal(gaussians[upper].albedo, gaussians.albedo[upper])
    np.testing.assert_array_equal(gaussians[10:40:3].centre, gaussians.centre[10:40:3])
    np.testing.assert_array_equal(gaussians[[7, 3]].opacity, gaussians.opacity[[7, 3]])
    np.testing.assert_array_equal(gaussians[-1].scale, gaussians.scale[-1:])
    with pytest.raises(IndexError):
        gaussians[len(gaussians)]


def test_held_out_patterns_judge(sample: Path, tmp_path: Path) -> None:
    sculpture = sample.parent / "sculpture"  # holds lollipop_3 out
    made = ffp.reconstruct(sculpture, "none", polish=0)
    made.save(tmp_path / "a.ply")
    rows = {row.protocol: row for row in ffp.evaluate(sculpture, gaussians=tmp_path / "a.ply")}
    assert made.stats.unseen == 1
    assert made.stats.unseen_psnr == pytest.approx(rows["novel_pattern"].psnr, abs=0.1)  # evaluate's is of 8 bits
    assert made.stats.unseen_lit_psnr < made.stats.unseen_psnr
    named = ffp.reconstruct(sculpture, "none", pattern=["lollipop_0", "lollipop_3"], polish=0)  # none is left
    assert named.stats.unseen == 0 and np.isnan(named.stats.unseen_psnr)


def test_paths_serve_as_handles(capture: ffp.Capture, sample: Path, tmp_path: Path) -> None:
    by_path, by_handle = (ffp.reconstruct(c, "none", polish=0) for c in (sample, capture))
    np.testing.assert_array_equal(by_path.centre, by_handle.centre)
    assert by_path.stats.gaussians == len(by_path) and by_path.stats.least_view in capture.view_ids
    assert 20 < by_path.stats.least_psnr < by_path.stats.psnr
    by_path.save(tmp_path / "a.ply")
    fitted = ffp.refine(tmp_path / "a.ply", str(sample), steps=2)
    assert fitted.stats.steps == 2
    _, stats = ffp.maps(tmp_path / "a.ply", sample, capture.camera(0), capture.projector(0))
    assert 0 < stats.lit_share < 1


def test_what_is_not_there(tmp_path: Path, capture: ffp.Capture) -> None:
    for call in (
        lambda: ffp.reconstruct(tmp_path / "no"),
        lambda: ffp.Capture.open(tmp_path / "no"),
        lambda: ffp.Gaussians.load(tmp_path / "no"),
        lambda: ffp.Model.open(tmp_path / "no"),
        lambda: ffp.info(tmp_path / "no"),
    ):
        with pytest.raises(FileNotFoundError) as missing:
            call()
        assert isinstance(missing.value, ffp.Error) and missing.value.filename == str(tmp_path / "no")
        assert missing.value.errno == 2 and str(tmp_path / "no") in str(missing.value)
    (tmp_path / "empty.ply").touch()
    with pytest.raises(ffp.FileFormatError) as wrong:
        ffp.Gaussians.load(tmp_path / "empty.ply")
    assert not isinstance(wrong.value, FileNotFoundError)


def test_linear_radiance(capture: ffp.Capture, gaussians: ffp.Gaussians) -> None:
    renderer = ffp.Renderer().aim(gaussians, capture.camera(0), capture.projector(0))
    pattern = capture.pattern("lollipop_0")
    dark = renderer.shade(None, capture.intensity, linear=True)
    once = renderer.shade(pattern, capture.intensity, linear=True)
    twice = renderer.shade(pattern, 2 * capture.intensity, linear=True)
    assert once.dtype == np.float32
    np.testing.assert_allclose(twice - dark, 2 * (once - dark), atol=1e-4)  # light adds up
    full = renderer.map("opacity") > 0.999
    shown = renderer.shade(pattern, capture.intensity, dtype=np.float32)
    np.testing.assert_allclose(ffp.encode(once)[full], shown[full], atol=2e-3)
    assert renderer.shade_many([None], 1, linear=True).dtype == np.float32
    with pytest.raises(ffp.ArgumentError, match="float32"):
        renderer.shade(None, 1, dtype=np.uint8, linear=True)


def test_the_calibration_matrix(capture: ffp.Capture) -> None:
    camera = capture.camera(0)
    point = np.array([0.1, -0.2, 2.0])
    x, y, w = camera.K @ point
    assert (x / w, y / w) == (
        pytest.approx(camera.fx * 0.05 + camera.cx),
        pytest.approx(camera.cy - camera.fy * 0.1),
    )


def test_a_check_gives_findings(capture: ffp.Capture) -> None:
    found = {finding.code: finding for finding in capture.check()}
    silhouettes = found["silhouettes"]
    assert silhouettes.severity == "ok" and silhouettes.figure is not None and silhouettes.figure < (silhouettes.limit or 0)
    assert all(finding.advice for finding in found.values() if finding.severity == "doubt")
    assert found["surfaces"].figure is None and found["surfaces"].view is None
