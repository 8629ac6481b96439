"""Depth that a network estimates: its kinds, its edges, and calm over frames."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.model.depth_words import (
    DepthConvention,
    DepthModelOutput,
    KnownDistance,
    parse_known_distance,
)
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.plate.estimate.chain import forget
from heatlens.media.plate.estimate.estimated_depth import with_sharp_edges
from heatlens.media.plate.estimate.network import network_at
from heatlens.media.plate.estimate.scale import Estimated, Fit, fitted
from heatlens.media.plate.read import read_plate
from heatlens.render.source.named import source_of
from support.networks import write_network

SIZE = (48, 64)


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("HEATLENS_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("HEATLENS_RUN_NETWORKS", "1")  # whose they are: test_trusted_networks.py


def write_picture(path, red):
    """Write a picture whose red is a depth, with the same blue everywhere."""
    values = np.zeros((*np.shape(red), 3))
    values[..., 0], values[..., 2] = red, 0.5
    Image.fromarray(np.round(values * 255).astype(np.uint8)).save(path)
    return path


def split(left: float, right: float) -> np.ndarray:
    red = np.full(SIZE, left)
    red[:, SIZE[1] // 2 :] = right
    return red


def options(network, **changes) -> PlateOptions:
    return PlateOptions(depth_model=str(network), **changes)


@pytest.mark.parametrize("size", [("h", "w"), (32, 64)], ids=["any size", "one size"])
@pytest.mark.parametrize(
    ("output", "left_m", "right_m"),
    [
        (DepthModelOutput.DISPARITY, 8.0, 2.0),
        (DepthModelOutput.METRES, 0.2, 0.8),
        (DepthModelOutput.INVERSE, 5.0, 1.25),
    ],
)
def test_each_kind_of_values_becomes_metres(tmp_path, size, output, left_m, right_m):
    """The ends of a disparity are --near and --far; the two others are in metres already."""
    picture = write_picture(tmp_path / "p.png", split(51 / 255, 204 / 255))
    network = write_network(tmp_path / "n.onnx", size=size)
    ends = {"near_m": 2.0, "far_m": 8.0} if output is DepthModelOutput.DISPARITY else {}
    plate = read_plate(picture, options(network, depth_model_output=output, **ends))
    depth = plate.depth_m
    assert depth.shape == SIZE
    assert depth[:, :24] == pytest.approx(left_m, rel=0.01)
    assert depth[:, 40:] == pytest.approx(right_m, rel=0.01)
    assert network.name in plate.depth.why and any("unknown" in note for note in plate.notes)


@pytest.mark.parametrize(
    ("name", "output"),
    [
        ("depth_anything_v2_vits.onnx", DepthModelOutput.DISPARITY),
        ("Depth-Anything-V2-Metric-Hypersim.onnx", DepthModelOutput.METRES),
        ("depth_pro.onnx", DepthModelOutput.METRES),
        ("dpt_hybrid_384.onnx", DepthModelOutput.DISPARITY),
        ("metric3d_vit_small.onnx", DepthModelOutput.METRES),
    ],
)
def test_a_known_family_is_told_by_its_name(tmp_path, name, output):
    network = network_at(str(write_network(tmp_path / name)), DepthModelOutput.AUTO)
    assert network.facts.output is output and not network.note
    height, width = network.seen(np.zeros((90, 160, 3), np.float32)).shape[2:]
    assert height % network.facts.multiple == width % network.facts.multiple == 0


def test_ends_that_nobody_gives_are_assumed_and_asked_for(tmp_path):
    picture = write_picture(tmp_path / "p.png", split(0.2, 0.8))
    network = write_network(tmp_path / "n.onnx")
    plate = read_plate(picture, options(network))
    assert plate.depth.convention is DepthConvention.DISPARITY and "--near" in plate.depth.question
    with pytest.raises(InputError, match="--near"):
        read_plate(picture, options(network, strict=True))


@pytest.mark.parametrize("output", list(DepthModelOutput))
def test_a_known_distance_is_that_of_its_pixel(tmp_path, output):
    picture = write_picture(tmp_path / "p.png", split(0.2, 0.8))
    known = parse_known_distance("60,20=2.4m")
    chosen = options(write_network(tmp_path / "n.onnx"), depth_known=known)
    depth = read_plate(picture, replace(chosen, depth_model_output=output)).depth_m
    assert depth[20, 60] == pytest.approx(2.4, rel=1e-3)


@pytest.mark.parametrize("text", ["", "960", "1,2", "1,2=", "a,b=2m", "1,2=-3m", "1,2=inf"])
def test_a_wrong_known_distance_is_refused(text):
    with pytest.raises(InputError):
        parse_known_distance(text)


def ramp_of(edge: int, ramp_px: int, width: int = 96) -> np.ndarray:
    """Return a step from 0.2 to 0.8 as a network blurs it."""
    step = np.where(np.arange(width) < edge, 0.2, 0.8)
    kernel = np.ones(ramp_px) / ramp_px
    row = np.convolve(np.pad(step, ramp_px, "edge"), kernel, "same")[ramp_px:-ramp_px]
    return np.tile(row, (40, 1)).astype(np.float32)


@given(edge=st.integers(30, 66), moved=st.integers(-2, 2), across=st.booleans())
@settings(max_examples=20, deadline=None)
def test_a_ramp_becomes_a_step_where_the_colour_has_one(edge, moved, across):
    """The estimate may be off by some pixels; the colour knows the place."""
    values = ramp_of(edge + moved, 7)
    color = np.where(np.arange(96) < edge, 0.1, 0.9)[None, :, None] * np.ones((40, 1, 3))
    if across:
        values, color = np.ascontiguousarray(values.T), np.ascontiguousarray(color.swapaxes(0, 1))
    sharp = with_sharp_edges(values, color.astype(np.float32), 9)
    row = sharp[:, 20] if across else sharp[20]
    assert np.array_equal(row > 0.5, np.arange(96) >= edge)
    assert set(np.round(row, 3)) == {np.float32(0.2), np.float32(0.8)}


@given(slope=st.floats(-0.008, 0.008), seed=st.integers(0, 9))
@settings(max_examples=20, deadline=None)
def test_slopes_stay_as_they_are_under_any_texture(slope, seed):
    values = (0.5 + slope * (np.arange(80) - 40) * np.ones((40, 1))).astype(np.float32)
    color = np.random.default_rng(seed).random((40, 80, 3), np.float32)
    assert np.array_equal(with_sharp_edges(values, color, 9), values)


@given(
    scale=st.floats(0.3, 3.0),
    shift=st.floats(-2.0, 2.0),
    seed=st.integers(0, 20),
    moving=st.floats(0.0, 0.4),
)
@settings(max_examples=30, deadline=None)
def test_drift_of_scale_and_shift_is_taken_out(scale, shift, seed, moving):
    """Something that moves through the picture, and so has other values, does not count."""
    random = np.random.default_rng(seed)
    before = Estimated(random.random(SIZE, np.float32), random.random((*SIZE, 3), np.float32))
    values, seen = (before.values - np.float32(shift)) / np.float32(scale), before.seen.copy()
    end = int(moving * SIZE[1])
    values[:, :end], seen[:, :end] = 9.0, 1.0 - seen[:, :end]
    fit = fitted(Estimated(values, seen), before, Fit(), keeps_zero=False)
    assert fit.scale == pytest.approx(scale, rel=0.01)
    assert fit.shift == pytest.approx(shift, abs=0.01 * max(1.0, scale))


def drifting(tmp_path, count: int = 12):
    """Write frames of one room whose red, which the network takes for depth, drifts."""
    random = np.random.default_rng(3)
    room = 0.25 + 0.4 * np.kron(random.random((6, 8)), np.ones((8, 8)))
    for number in range(count):
        drift = 1.0 + 0.02 * math.sin(number)
        write_picture(tmp_path / f"f.{1001 + number}.png", room * drift)
    return str(tmp_path / "f.####.png")


def test_frames_are_calm_and_each_is_the_same_alone(tmp_path):
    drifting(tmp_path)
    chosen = options(write_network(tmp_path / "n.onnx"), near_m=1.0, far_m=10.0)
    frames = [read_plate(tmp_path / f"f.{1001 + n}.png", chosen).depth_m for n in range(12)]
    changes = [np.abs(1 / a - 1 / frames[0]).mean() for a in frames[1:]]
    assert max(changes) < 0.01  # without the fit .03: the drift is 2 % of about .5 dioptres
    forget()
    assert np.array_equal(read_plate(tmp_path / "f.1011.png", chosen).depth_m, frames[10])


def test_a_network_runs_once_for_a_picture(tmp_path, monkeypatch):
    picture = write_picture(tmp_path / "p.png", split(0.2, 0.8))
    chosen = options(write_network(tmp_path / "n.onnx"), near_m=1.0, far_m=10.0)
    first = read_plate(picture, chosen).depth_m
    monkeypatch.setattr("heatlens.media.plate.estimate.network.Network.estimate", None)
    assert np.array_equal(read_plate(picture, chosen).depth_m, first)


def test_another_network_is_another_input_of_a_frame(tmp_path):
    """So frames are made again when the file of the network changes."""
    picture, network = write_picture(tmp_path / "p.png", split(0.2, 0.8)), tmp_path / "n.onnx"
    write_network(network)
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0), source=str(picture), plate_options=options(network))
    origin = source_of(shot).origin(shot, 1, "stop")
    assert network in {file.path for file in origin.files}


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda path: path.write_bytes(b"no network"), "not a network"),
        (lambda path: None, "not there"),
        (lambda path: write_network(path, channels=1), "3 channels"),
        (lambda path: write_network(path, bias=math.nan), "no map"),
    ],
    ids=["another file", "missing", "channels", "not a number"],
)
def test_a_wrong_network_is_refused_by_name(tmp_path, make, told):
    network = tmp_path / "n.onnx"
    make(network)
    picture = write_picture(tmp_path / "p.png", split(0.2, 0.8))
    with pytest.raises(InputError, match=told) as refusal:
        read_plate(picture, options(network))
    assert str(network) in str(refusal.value)


def test_a_depth_is_either_read_or_estimated(tmp_path):
    picture = write_picture(tmp_path / "p.png", split(0.2, 0.8))
    network = write_network(tmp_path / "n.onnx")
    with pytest.raises(InputError, match="--depth-model"):
        read_plate(picture, options(network, depth_source=str(picture)))
    with pytest.raises(InputError, match="outside"):
        read_plate(picture, options(network, depth_known=KnownDistance(900.0, 2.0, 2.0)))


def test_the_command_line_renders_a_photo(tmp_path, capsys):
    picture = write_picture(tmp_path / "p.png", split(0.2, 0.8))
    network, out = write_network(tmp_path / "n.onnx"), tmp_path / "out.png"
    words = [
        "--depth-model",
        str(network),
        "--depth-known",
        "60,20=2m",
        "--far",
        "9",
        "--near",
        "1",
    ]
    lens = [
        "--focal-length",
        "50",
        "--sensor-width",
        "36",
        "--f-stop",
        "2",
        "--focus-distance",
        "2",
    ]
    assert main(["render", str(picture), "-o", str(out), *words, *lens]) == 0
    assert out.exists() and "Estimated by n.onnx" in capsys.readouterr().err
    assert main(["info", str(picture), *words]) == 0
    assert "estimate, disparity" in capsys.readouterr().out


@pytest.mark.parametrize("size", [(40, 1), (1, 40), (1, 1)])
def test_a_picture_of_one_row_or_column_is_estimated(tmp_path, size):
    picture = write_picture(tmp_path / "p.png", np.full(size, 0.5))
    network = write_network(tmp_path / "n.onnx")
    plate = read_plate(picture, options(network, near_m=1.0, far_m=10.0))
    assert plate.depth_m.shape == size and np.isfinite(plate.depth_m).all()


@pytest.mark.parametrize("size", [(0, 64), (32, 0), (9000, 64)])
def test_impossible_sides_of_a_network_are_refused(tmp_path, size):
    network = write_network(tmp_path / "n.onnx", size=size)
    with pytest.raises(InputError, match="sides are 1 to"):
        read_plate(write_picture(tmp_path / "p.png", split(0.2, 0.8)), options(network))
