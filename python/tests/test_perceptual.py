"""LPIPS weights: from what torch.load gives to figures. The numbers are made up, the names and shapes are the real ones."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from ffprocams import FileFormatError, perceptual, protocols


class Tensor:
    """The used part of a torch.Tensor, which CI does not have."""

    def __init__(self, values: Any) -> None:
        self.values, self.shape = values, values.shape

    def detach(self) -> Tensor:
        return self

    float = detach

    def flatten(self) -> Any:
        return self.values.ravel()


def backbone(name: str) -> dict[str, Any]:
    """As torchvision's: of all convolutions, and of a classifier, which is not for us."""
    rng, network = np.random.default_rng(1), perceptual.NETWORKS[name]
    state = {n: Tensor(rng.normal(0, 0.05, shape).astype(np.float32)) for n, shape in network["backbone"]}
    for i in range(network["convolutions"] - len(state) // 2):
        state[f"features.{90 + i}.weight"] = Tensor(np.zeros((1, 1, 1, 1), np.float32))
    return {**state, "classifier.1.weight": Tensor(np.zeros((2, 2), np.float32))}


def heads(name: str) -> dict[str, Any]:
    rng, channels = np.random.default_rng(2), perceptual.NETWORKS[name]["heads"]
    return {
        f"lin{i}.model.1.weight": Tensor(rng.uniform(0, 1, (1, c, 1, 1)).astype(np.float32))
        for i, c in enumerate(channels)
    }


@pytest.fixture
def given(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    states = {
        "a.pth": heads("alex"),
        "b.pth": backbone("squeeze"),
        "c.pth": backbone("vgg16"),
        "d.pth": heads("squeeze"),
        "e.pth": backbone("alex"),
    }
    monkeypatch.setattr(perceptual, "_load", lambda path: states[path.name])
    return states


def test_one_command_makes_them_all(
    given: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "new" / "weights"
    perceptual.main(["-o", str(folder), *given])
    names = ["lpips_alex.safetensors", "lpips_squeeze.safetensors", "vgg16_relu2_2.safetensors"]
    assert sorted(p.name for p in folder.iterdir()) == names
    assert f"FFPROCAMS_PERCEPTUAL={folder}" in capsys.readouterr().out
    rng = np.random.default_rng(3)
    a = rng.integers(0, 256, (2, 40, 48, 3), np.uint8)
    near = np.clip(a.astype(int) + rng.integers(-4, 5, a.shape), 0, 255).astype(np.uint8)
    for name in names[:2]:
        same, little, much = (protocols.lpips(a, b, folder / name) for b in (a, near, a[::-1]))
        assert (same == 0).all() and (little > 0).all() and (much > 4 * little).all()
    with pytest.raises(FileFormatError, match="holds no LPIPS weights"):
        protocols.lpips(a, a, folder / names[2])
    assert np.isnan(protocols.lpips(a[:, :20], a[:, :20], folder / names[0])).all()


@pytest.mark.parametrize(
    ("files", "fault"),
    [
        (["e.pth", "b.pth"], "backbone of alex, backbone of squeeze"),  # no heads
        (["e.pth", "e.pth"], "twice"),
        (["vgg19.pth"], "neither AlexNet"),
        (["cut.pth", "a.pth"], r"no such tensor \(cut.pth: features.6.bias\)"),
    ],
)
def test_faults_are_named(given: dict[str, Any], tmp_path: Path, files: list[str], fault: str) -> None:
    given["vgg19.pth"] = {**backbone("vgg16"), **{f"features.{99 + i}.weight": None for i in range(9, 12)}}
    given["cut.pth"] = {n: t for n, t in backbone("alex").items() if n != "features.6.bias"}
    with pytest.raises(SystemExit, match=fault):
        perceptual.main(["-o", str(tmp_path), *files])
    assert not list(tmp_path.iterdir())


def test_files_of_torch(tmp_path: Path) -> None:
    torch = pytest.importorskip("torch", reason="torch is not installed: its files are not opened")
    for name, state in (("x.pth", backbone("alex")), ("y.pth", heads("alex"))):
        torch.save({n: torch.from_numpy(t.values) for n, t in state.items()}, tmp_path / name)
    (tmp_path / "z.pth").write_bytes(b"not one")
    (written,) = perceptual.convert([tmp_path / "x.pth", tmp_path / "y.pth"], tmp_path)
    a = np.random.default_rng(4).integers(0, 256, (1, 64, 64, 3), np.uint8)
    assert protocols.lpips(a, a[:, ::-1], written)[0] > 0
    with pytest.raises(SystemExit, match="z.pth"):
        perceptual.main(["-o", str(tmp_path), str(tmp_path / "z.pth")])
