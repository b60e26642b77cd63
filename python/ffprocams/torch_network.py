"""The network in PyTorch, with the library's weights and to its numbers: for training it another way. The part for
users is in ffprocams.torch.

The blocks are described in docs/design/architecture.md, "network". The state-space scan is the chunked form of Dao and
Gu 2024 (Sec. 6, block decomposition), in batched products.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import torch
import torch.nn.functional as F
from torch import Tensor

from ._arguments import checked
from ._call import Call, Keep, PathLike, ProgressOption, holding, some
from ._library import ffi, lib
from ._pixels import floats_at
from .capture import Capture, capture_of
from .errors import argument_error
from .gaussians import Gaussians, Model

_HEAD_DIM, _TAPS, _EPSILON = 64, 4, 1e-5
_HIDDEN_LAYERS = 2
# Of the heads' formulas (src/engine/network/splat_formula.h).
_REACH, _CORRECTION, _FLATNESS, _WIDTH, _PLAIN_OPACITY, _ROUGHNESS_FLOOR = 1.05, 0.05, 0.1, 0.425, -2.0, 0.05
_LOG_SCALES, _PLAIN_LOG_SCALES = (-4.0, 2.7725887), (-8.0, 2.0794415)
_BASE = (3, 3, 1, 1, 1, 1, 1, 4, 3, 3)


@checked
class Parts(NamedTuple):
    """The numbers of Gaussians, as ffprocams.Gaussians has them. Rotations may have any length other than 0."""

    centre: Tensor  #: [count,3] world
    scale: Tensor  #: [count,3] standard deviations along the rotated axes, world units, above 0
    rotation: Tensor  #: [count,4] quaternions w x y z: the splat's axes to the world
    opacity: Tensor  #: [count] in [0,1]
    albedo: Tensor  #: [count,3] linear
    roughness: Tensor  #: [count] in [0,1]
    ambient: Tensor  #: [count,3] linear radiance with the projector black
    scattered: Tensor | None = None  #: [count,3] linear radiance that white adds in other ways; None: none

    @classmethod
    def of(cls, gaussians: Gaussians) -> Parts:
        """Copies of the arrays. Raises ArgumentError for anything but Gaussians."""
        return cls(*(torch.from_numpy(array.copy()) for array in gaussians.arrays().values()))


@checked
@dataclass
class Prepared:
    """The network's inputs from a capture, as tensors: noise filtered, matched, with the classical initialisation. It
    depends on a model's configuration, not on its weights: make it once, and run the network on it any number of times.
    ``FfpPreparedArrays`` in ffprocams/gradients.h describes the fields."""

    inputs: Tensor  #: [tokens,patch^2 channels]
    used: Tensor  #: [n] tokens that the Gaussians take features from
    row: Tensor  #: [count,taps] rows of the map of features
    weight: Tensor  #: [count,taps]
    own: Tensor  #: [count,channels] the pixels' own inputs, or none
    context: Tensor  #: [count,2] or [0,2]
    base: Tensor  #: [count,21] what the heads start from
    centre: Tensor  #: [3] of the capture's bounding sphere, world units
    radius: float
    handle: Any  #: the library's, for looks
    seen_width: int  #: numbers of a Gaussian at a look; 0: the model has none

    @classmethod
    def of(
        cls,
        capture: Capture | PathLike,
        model: Model | PathLike | None = None,
        *,
        pattern: str | Sequence[str] | None = None,
        noise: float | None = None,
        force: bool = False,
        progress: ProgressOption = None,
        threads: int = 0,
    ) -> Prepared:
        """Arguments as for ffprocams.reconstruct. Raises what that raises."""
        capture, keep = capture_of(capture), Keep()
        weights = model if isinstance(model, Model) else Model.open(model)
        options = ffi.new("FfpReconstruction *", lib.ffp_reconstruction_defaults())
        names = [keep.text(p) for p in some(pattern or ())]
        options.model, options.force = weights._pointer, force
        options.patterns, options.n_patterns = keep.texts(names), len(names)
        if noise is not None:
            options.noise = noise
        with holding(capture, weights), Call(progress, threads) as call:
            made = lib.ffp_prepare(call.context, capture._pointer, options, call.error)
            handle = call.take(made, lib.ffp_prepared_close)
        a = lib.ffp_prepared_arrays(handle)
        count = int(a.count)

        def floats(pointer: Any, *shape: int) -> Tensor:
            shape = (0, *shape[1:]) if pointer == ffi.NULL else shape
            return torch.from_numpy(floats_at(pointer, shape, handle).copy())

        def integers(pointer: Any, *shape: int) -> Tensor:
            held = np.frombuffer(ffi.buffer(pointer, 4 * int(np.prod(shape))), np.int32)
            return torch.from_numpy(held.reshape(shape).astype(np.int64))

        return cls(
            inputs=floats(a.inputs, a.tokens, a.token_width),
            used=integers(a.used, a.n_used),
            row=integers(a.row, count, a.taps),
            weight=floats(a.weight, count, a.taps),
            own=floats(a.own, count, a.channels),
            context=floats(a.context, count, 2),
            base=floats(a.base, count, sum(_BASE)),
            centre=torch.from_numpy(np.asarray(capture.centre, np.float32)),
            radius=capture.radius,
            handle=handle,
            seen_width=a.seen_width,
        )

    def __len__(self) -> int:
        return len(self.base)

    def look(self, raw: Tensor) -> Tensor:
        """[count,seen_width]: errors of the input views drawn with the Gaussians of these raw numbers, as each Gaussian sees
        them. No gradient passes through it. Raises ArgumentError unless given a tensor."""
        numbers = np.ascontiguousarray(raw.detach().cpu().numpy(), np.float32)
        seen = np.empty((len(self), self.seen_width), np.float32)
        with Call() as call:
            call.check(
                lib.ffp_prepared_look(
                    call.context,
                    self.handle,
                    len(numbers),
                    ffi.from_buffer("float[]", numbers),
                    ffi.from_buffer("float[]", seen, require_writable=True),
                    call.error,
                )
            )
        return torch.from_numpy(seen).to(raw)


def _scan(
    x: Tensor, b: Tensor, c: Tensor, dt: Tensor, rate: Tensor, skip: Tensor, chunk: int, reverse: bool
) -> Tensor:
    """y [rows,heads,width] of h_t = exp(dt rate) h_{t-1} + dt x_t (outer) B_t, y_t = h_t C_t + skip x_t; x as y, b and c
    [rows,state], dt [rows,heads], rate and skip [heads]. Chunks stay in the rows' order; a reversed scan turns sums, masks
    and the chunks' order. Rows that fill the last chunk have dt 0, which changes nothing."""
    rows, heads, width = x.shape
    missing = -rows % chunk
    if missing:
        x, b, c, dt = (F.pad(v, (0, 0) * (v.dim() - 1) + (0, missing)) for v in (x, b, c, dt))
    chunks = len(x) // chunk
    b_, c_ = (v.reshape(chunks, chunk, -1) for v in (b, c))
    by_head = x.reshape(chunks, chunk, heads, width)
    dt_ = dt.reshape(chunks, chunk, heads)
    square = torch.ones(chunk, chunk, dtype=torch.bool, device=x.device)
    before = torch.ones(chunks, chunks, dtype=torch.bool, device=x.device)
    seen, before = (square.triu(), before.triu(1)) if reverse else (square.tril(), before.tril(-1))

    def running(values: Tensor, dim: int) -> Tensor:
        return values.flip(dim).cumsum(dim).flip(dim) if reverse else values.cumsum(dim)

    def decays(to: Tensor, since: Tensor, where: Tensor) -> Tensor:
        """exp(to_i - since_j) where i sees j, otherwise 0."""
        return (to.unsqueeze(-1) - since.unsqueeze(-2)).masked_fill(~where, -torch.inf).exp()

    sums = running(dt_ * rate, 1)  # [chunks,chunk,heads], a row's own step included
    total = sums[:, 0 if reverse else -1]  # [chunks,heads]
    # Contributions of rows to the rows of their chunk.
    pairs = torch.bmm(c_, b_.transpose(1, 2))  # [chunks,chunk,chunk], shared by the heads
    turned = sums.transpose(1, 2)
    weights = decays(turned, turned, seen) * pairs.unsqueeze(1) * dt_.transpose(1, 2).unsqueeze(2)
    inside = torch.matmul(weights, by_head.transpose(1, 2)).transpose(1, 2)  # [chunks,chunk,heads,width]
    # Each chunk's addition to the state; the states that enter the chunks, and their contributions.
    feed = (dt_ * (total.unsqueeze(1) - sums).exp()).unsqueeze(-1) * by_head
    own = torch.bmm(b_.transpose(1, 2), feed.flatten(2))  # [chunks,state,heads width]
    left = running(total, 0).transpose(0, 1)  # [heads,chunks]
    entered = left - total.transpose(0, 1)
    entering = torch.einsum("hij,jnhp->inhp", decays(entered, left, before), own.unflatten(2, (heads, width)))
    outside = torch.bmm(c_, entering.flatten(2)).unflatten(2, (heads, width))
    y = (inside + outside * sums.exp().unsqueeze(-1)).reshape(-1, heads, width)
    return y[:rows] + skip.unsqueeze(-1) * x[:rows]


def _unit(q: Tensor) -> Tensor:
    """normalise(q + (1,0,0,0))"""
    q = torch.cat((q[:, :1] + 1, q[:, 1:]), 1)
    return q * torch.rsqrt(q.square().sum(1, keepdim=True) + 1e-12)


def _product(f: Tensor, q: Tensor) -> Tensor:
    """Hamilton product, w x y z."""
    (a, b, c, d), (w, x, y, z) = f.unbind(1), q.unbind(1)
    rows = (a * w - b * x - c * y - d * z, a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x, a * z + b * y - c * x + d * w)  # fmt: skip
    return torch.stack(rows, 1)


class _Form(NamedTuple):
    """FfpModelForm."""

    modules: str
    dim: int
    patch: int
    state: int
    chunk: int
    residual: bool
    pixel_skip: bool
    context_inputs: bool
    appearance_cnn: bool
    looks: int

    @classmethod
    def of(cls, model: Model) -> _Form:
        form = lib.ffp_model_form(model._pointer)
        return cls(ffi.string(form.modules).decode(), *(getattr(form, name) for name in cls._fields[1:]))


@checked
class Network(torch.nn.Module):
    """The hybrid of Mamba2 and Transformer blocks, from a Prepared to Parts in world units.

    Parameters have the names of the weights file with "_" for "."; they are float32, and copies. With ``model()`` they
    go back into the library.
    """

    def __init__(self, model: Model | PathLike | None = None) -> None:
        """model: a Model, the path of a weights file, or None for the shipped weights."""
        super().__init__()
        self._model = model if isinstance(model, Model) else Model.open(model)
        self.form = _Form.of(self._model)
        if self.form.appearance_cnn:
            raise argument_error("appearance_cnn is not part of ffprocams.torch", "model")
        self.names = list(self._model.weights())  #: of the weights, in the file's order
        for name, values in self._model.weights().items():
            self.register_parameter(
                name.replace(".", "_"), torch.nn.Parameter(torch.from_numpy(values.copy()))
            )

    def at(self, *names: object) -> torch.nn.Parameter:
        """The weight of that name: ``at("blocks", 0, "norm")`` or ``at("blocks.0.norm")``.
        Raises AttributeError if there is none."""
        out: torch.nn.Parameter = getattr(self, "_".join(str(name).replace(".", "_") for name in names))
        return out

    def heads(self) -> Iterator[torch.nn.Parameter]:
        """The parameters behind the encoder: what a fine-tuning may be content with."""
        return (p for name, p in self.named_parameters() if name.startswith(("pixel_", "head_", "look_")))

    def _mamba(self, x: Tensor, i: int) -> Tensor:
        form = self.form
        inner, heads = 2 * form.dim, 2 * form.dim // _HEAD_DIM
        convolved = inner + 2 * form.state
        row = F.linear(
            F.rms_norm(x, (form.dim,), self.at("blocks", i, "norm"), _EPSILON),
            self.at("blocks", i, "in_proj"),
        )
        z, columns, raw = row.split((inner, convolved, heads), -1)
        gate = F.silu(z.float())
        columns = columns.transpose(0, 1)
        summed: Any = 0
        for direction in ("forward", "reverse"):
            reverse = direction == "reverse"

            def at(name: str, direction: str = direction) -> Tensor:
                return self.at("blocks", i, direction, name)

            taps = at("conv").to(columns.dtype).unsqueeze(1)
            padded = F.pad(columns, (0, _TAPS - 1) if reverse else (_TAPS - 1, 0))
            bias = at("conv_bias").to(columns.dtype)
            turned = F.conv1d(padded, taps.flip(-1) if reverse else taps, bias, groups=convolved)
            u, b, c = F.silu(turned).transpose(0, 1).contiguous().split((inner, form.state, form.state), -1)
            dt = F.softplus(raw.float() + at("dt_bias"))
            y = _scan(
                u.unflatten(1, (heads, _HEAD_DIM)), b, c, dt, -at("a_log").exp(), at("d"), form.chunk, reverse
            )
            summed = summed + F.rms_norm(y.flatten(1) * gate, (inner,), at("norm"), _EPSILON)
        return x + F.linear(summed, self.at("blocks", i, "out_proj"))

    def _transformer(self, x: Tensor, i: int) -> Tensor:
        def at(name: str) -> Tensor:
            return self.at("blocks", i, name)

        dim = self.form.dim
        rows = F.linear(F.layer_norm(x, (dim,), at("norm1"), None, _EPSILON), at("qkv"))
        q, k, v = rows.unflatten(1, (3, dim // _HEAD_DIM, _HEAD_DIM)).permute(1, 2, 0, 3).unsqueeze(1)
        q = F.rms_norm(q.float(), (_HEAD_DIM,), at("q_gain"), _EPSILON).to(v.dtype)
        k = F.rms_norm(k.float(), (_HEAD_DIM,), at("k_gain"), _EPSILON).to(v.dtype)
        attended = F.scaled_dot_product_attention(q, k, v)[0].transpose(0, 1).flatten(1)
        x = x + F.linear(attended, at("proj"))
        hidden = F.linear(F.layer_norm(x, (dim,), at("norm2"), None, _EPSILON), at("fc1"))
        return x + F.linear(F.gelu(hidden), at("fc2"))

    def encode(self, inputs: Tensor) -> Tensor:
        """[tokens,dim] from a Prepared's inputs. Raises ArgumentError unless given tensors."""
        dim = (self.form.dim,)
        x = F.linear(inputs, self.at("tokeniser.weight")).float()
        x = F.layer_norm(x, dim, self.at("tokeniser.norm"), None, _EPSILON)
        for i, kind in enumerate(self.form.modules):
            x = self._mamba(x, i) if kind == "M" else self._transformer(x, i)
        return F.layer_norm(x.float(), dim, self.at("final_norm"), None, _EPSILON)

    def raw(self, tokens: Tensor, prepared: Prepared) -> Tensor:
        """[count,numbers] of each Gaussian before the heads' formulas, from the encoder's tokens.
        Raises ArgumentError unless given tokens and a Prepared."""
        form, used = self.form, tokens[prepared.used]
        pixels = form.patch**2
        if form.pixel_skip:
            features = F.linear(used, self.at("pixel.features"))
        else:
            features = F.linear(used, self.at("head.weight"), self.at("head.bias"))
        rows = features.reshape(len(used) * pixels, -1)
        x = F.embedding_bag(prepared.row, rows, per_sample_weights=prepared.weight, mode="sum")
        if not form.pixel_skip:
            return x
        x = torch.cat((x, prepared.own), 1)
        told = F.linear(prepared.context, self.at("pixel.context")) if form.context_inputs and len(prepared.context) else 0
        out = self._pixel("pixel", x, told)
        for look in range(form.looks):
            name = f"look.{look}"
            out = out + self._pixel(name, x, F.linear(prepared.look(out), self.at(name, "errors")))
        return out

    def _pixel(self, name: str, x: Tensor, more: Tensor | int) -> Tensor:
        """A pixel's layers; `more` goes to the first hidden one."""
        for i in range(_HIDDEN_LAYERS):
            x = F.linear(x, self.at(name, "hidden", i, "weight"), self.at(name, "hidden", i, "bias"))
            x = F.gelu(x + more if i == 0 else x)
        return F.linear(x, self.at(name, "last.weight"), self.at(name, "last.bias"))

    def splats(self, raw: Tensor, prepared: Prepared) -> Parts:
        """The heads' formulas. Raises ArgumentError unless given raw numbers and a Prepared."""
        origin, ray, nearest, footprint, start, start_logit, opacity, frame, albedo, ambient = (
            prepared.base.split(_BASE, 1)
        )
        if self.form.residual:
            correction, gate, net, scale, turn = raw[:, :10].split((1, 1, 1, 3, 4), 1)
            look, gate, (low, high) = raw[:, 10:], gate.sigmoid(), _LOG_SCALES
            moved = 2 * _REACH * ((net + start_logit).sigmoid() - start_logit.sigmoid())
            t = start + gate * _CORRECTION * correction.tanh() + (1 - gate) * moved
            rotation = _product(frame, _unit(turn))
            width = _WIDTH * footprint * footprint.new_tensor([1, 1, _FLATNESS])
        else:
            net, scale, turn = raw[:, :8].split((1, 3, 4), 1)
            look, (low, high) = raw[:, 8:], _PLAIN_LOG_SCALES
            t = nearest + _REACH * (2 * net.sigmoid() - 1)
            rotation, width = _unit(turn), footprint
            opacity, albedo, ambient = torch.full_like(opacity, _PLAIN_OPACITY), albedo * 0, ambient * 0
        unit = prepared.radius
        return Parts(
            prepared.centre + unit * (origin + t * ray),
            unit * width * scale.clamp(low, high).exp(),
            rotation,
            (look[:, 0] + opacity[:, 0]).sigmoid(),
            (look[:, 1:4] + albedo).sigmoid(),
            _ROUGHNESS_FLOOR + (1 - _ROUGHNESS_FLOOR) * look[:, 4].sigmoid(),
            (look[:, 5:8] + ambient).sigmoid(),
            torch.zeros_like(ambient),
        )

    def forward(self, prepared: Prepared) -> Parts:
        """The Gaussians of a Prepared: one for each pixel of the object, as the library's network gives them.
        ffprocams.reconstruct goes on from there: it takes away what the photographs contradict, and polishes.
        Raises ArgumentError unless given one."""
        return self.splats(self.raw(self.encode(prepared.inputs), prepared), prepared)

    def model(self) -> Model:
        """The library's model with the present weights, for ffprocams.reconstruct and Model.save."""
        with torch.no_grad(), holding(self._model):
            for name, values in self._model.weights().items():
                values[...] = self.at(name).detach().cpu().numpy()
        return self._model
