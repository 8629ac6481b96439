"""Test depth estimated by a network: kinds of output, sharp edges, and stability over frames."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

import heatlens
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
from heatlens.media.plate.estimate.chain import clear_memory
from heatlens.media.plate.estimate.estimated_depth import sharpen_edges
from heatlens.media.plate.estimate.network import network_at
from heatlens.media.plate.estimate.scale import Fit, FrameEstimate, fit_to_frame
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


def two_halves(left: float, right: float) -> np.ndarray:
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
def test_read_plate_converts_each_network_output_to_meters(tmp_path, size, output, left_m, right_m):
    """The ends of a disparity are --near and --far; the two other outputs are in meters already."""
    picture = write_picture(tmp_path / "p.png", two_halves(51 / 255, 204 / 255))
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
def test_network_at_recognizes_known_family_by_file_name(tmp_path, name, output):
    network = network_at(str(write_network(tmp_path / name)), DepthModelOutput.AUTO)
    assert network.facts.output is output and not network.note
    height, width = network.prepare_input(np.zeros((90, 160, 3), np.float32)).shape[2:]
    assert height % network.facts.multiple == width % network.facts.multiple == 0


def test_read_plate_assumes_missing_ends_of_disparity_and_asks(tmp_path):
    picture = write_picture(tmp_path / "p.png", two_halves(0.2, 0.8))
    network = write_network(tmp_path / "n.onnx")
    plate = read_plate(picture, options(network))
    assert plate.depth.convention is DepthConvention.DISPARITY and "--near" in plate.depth.question
    with pytest.raises(InputError, match="--near"):
        read_plate(picture, options(network, strict=True))


@pytest.mark.parametrize("output", list(DepthModelOutput))
def test_read_plate_scales_estimate_to_known_distance(tmp_path, output):
    picture = write_picture(tmp_path / "p.png", two_halves(0.2, 0.8))
    known_distance = parse_known_distance("60,20=2.4m")
    plate_options = options(write_network(tmp_path / "n.onnx"), depth_known=known_distance)
    depth = read_plate(picture, replace(plate_options, depth_model_output=output)).depth_m
    assert depth[20, 60] == pytest.approx(2.4, rel=1e-3)


@pytest.mark.parametrize("text", ["", "960", "1,2", "1,2=", "a,b=2m", "1,2=-3m", "1,2=inf"])
def test_parse_known_distance_rejects_malformed_text(text):
    with pytest.raises(InputError):
        parse_known_distance(text)


def blurred_step(edge: int, ramp_px: int, width: int = 96) -> np.ndarray:
    """Return a step from 0.2 to 0.8 at `edge`, blurred over `ramp_px` as by a network."""
    step = np.where(np.arange(width) < edge, 0.2, 0.8)
    kernel = np.ones(ramp_px) / ramp_px
    row = np.convolve(np.pad(step, ramp_px, "edge"), kernel, "same")[ramp_px:-ramp_px]
    return np.tile(row, (40, 1)).astype(np.float32)


@given(edge=st.integers(30, 66), moved=st.integers(-2, 2), across=st.booleans())
@settings(max_examples=20, deadline=None)
def test_sharpen_edges_moves_ramp_to_step_of_color(edge, moved, across):
    """The estimate may be some pixels off; the color has the exact position."""
    values = blurred_step(edge + moved, 7)
    color = np.where(np.arange(96) < edge, 0.1, 0.9)[None, :, None] * np.ones((40, 1, 3))
    if across:
        values, color = np.ascontiguousarray(values.T), np.ascontiguousarray(color.swapaxes(0, 1))
    sharp = sharpen_edges(values, color.astype(np.float32), 9)
    sharp_row = sharp[:, 20] if across else sharp[20]
    assert np.array_equal(sharp_row > 0.5, np.arange(96) >= edge)
    assert set(np.round(sharp_row, 3)) == {np.float32(0.2), np.float32(0.8)}


@given(slope=st.floats(-0.008, 0.008), seed=st.integers(0, 9))
@settings(max_examples=20, deadline=None)
def test_sharpen_edges_keeps_slopes_under_any_texture(slope, seed):
    values = (0.5 + slope * (np.arange(80) - 40) * np.ones((40, 1))).astype(np.float32)
    color = np.random.default_rng(seed).random((40, 80, 3), np.float32)
    assert np.array_equal(sharpen_edges(values, color, 9), values)


@given(
    scale=st.floats(0.3, 3.0),
    shift=st.floats(-2.0, 2.0),
    seed=st.integers(0, 20),
    moving=st.floats(0.0, 0.4),
)
@settings(max_examples=30, deadline=None)
def test_fit_to_frame_recovers_scale_and_shift_between_frames(scale, shift, seed, moving):
    """An object that moves through the image has other values and must not count."""
    random = np.random.default_rng(seed)
    previous = FrameEstimate(random.random(SIZE, np.float32), random.random((*SIZE, 3), np.float32))
    values = (previous.values - np.float32(shift)) / np.float32(scale)
    current_color = previous.color.copy()
    end = int(moving * SIZE[1])
    values[:, :end], current_color[:, :end] = 9.0, 1.0 - current_color[:, :end]
    fit = fit_to_frame(FrameEstimate(values, current_color), previous, Fit(), keeps_zero=False)
    assert fit.scale == pytest.approx(scale, rel=0.01)
    assert fit.shift == pytest.approx(shift, abs=0.01 * max(1.0, scale))


def write_drifting_frames(tmp_path, count: int = 12):
    """Write frames of one room whose red channel drifts; the network takes red for depth."""
    random = np.random.default_rng(3)
    room = 0.25 + 0.4 * np.kron(random.random((6, 8)), np.ones((8, 8)))
    for number in range(count):
        drift = 1.0 + 0.02 * math.sin(number)
        write_picture(tmp_path / f"f.{1001 + number}.png", room * drift)
    return str(tmp_path / "f.####.png")


def test_read_plate_removes_drift_and_does_not_depend_on_earlier_reads(tmp_path):
    write_drifting_frames(tmp_path)
    plate_options = options(write_network(tmp_path / "n.onnx"), near_m=1.0, far_m=10.0)
    frames = [read_plate(tmp_path / f"f.{1001 + n}.png", plate_options).depth_m for n in range(12)]
    changes = [np.abs(1 / a - 1 / frames[0]).mean() for a in frames[1:]]
    assert max(changes) < 0.01  # without the fit .03: the drift is 2 % of about .5 dioptres
    clear_memory()
    assert np.array_equal(read_plate(tmp_path / "f.1011.png", plate_options).depth_m, frames[10])


def test_read_plate_runs_network_once_per_picture(tmp_path, monkeypatch):
    picture = write_picture(tmp_path / "p.png", two_halves(0.2, 0.8))
    plate_options = options(write_network(tmp_path / "n.onnx"), near_m=1.0, far_m=10.0)
    first_depth = read_plate(picture, plate_options).depth_m
    monkeypatch.setattr("heatlens.media.plate.estimate.network.Network.estimate", None)
    assert np.array_equal(read_plate(picture, plate_options).depth_m, first_depth)


def test_network_file_is_an_input_of_its_frames(tmp_path):
    """Frames are rendered again when the network's file changes."""
    picture, network = write_picture(tmp_path / "p.png", two_halves(0.2, 0.8)), tmp_path / "n.onnx"
    write_network(network)
    shot = Shot(Lens(50.0, 2.0, 2.0, 36.0), source=str(picture), plate_options=options(network))
    origin = source_of(shot).origin(shot, 1, "stop")
    assert network in {file.path for file in origin.files}


@pytest.mark.parametrize(
    ("make", "message_part"),
    [
        (lambda path: path.write_bytes(b"no network"), "not a network"),
        (lambda path: None, "not there"),
        (lambda path: write_network(path, channels=1), "3 channels"),
        (lambda path: write_network(path, bias=math.nan), "no map"),
    ],
    ids=["another file", "missing", "channels", "not a number"],
)
def test_read_plate_rejects_wrong_network_by_name(tmp_path, make, message_part):
    network = tmp_path / "n.onnx"
    make(network)
    picture = write_picture(tmp_path / "p.png", two_halves(0.2, 0.8))
    with pytest.raises(InputError, match=message_part) as refusal:
        read_plate(picture, options(network))
    assert str(network) in str(refusal.value)


def test_read_plate_rejects_depth_source_with_depth_model(tmp_path):
    picture = write_picture(tmp_path / "p.png", two_halves(0.2, 0.8))
    network = write_network(tmp_path / "n.onnx")
    with pytest.raises(InputError, match="--depth-model"):
        read_plate(picture, options(network, depth_source=str(picture)))
    with pytest.raises(InputError, match="outside"):
        read_plate(picture, options(network, depth_known=KnownDistance(900.0, 2.0, 2.0)))


def test_render_and_info_estimate_depth_of_photo(tmp_path, capsys):
    picture = write_picture(tmp_path / "p.png", two_halves(0.2, 0.8))
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
    assert (
        out.exists() and "depth: estimate, disparity, 1 near, 2 to 9 m" in capsys.readouterr().err
    )
    assert main(["info", str(picture), *words]) == 0
    assert "estimate, disparity" in capsys.readouterr().out


@pytest.mark.parametrize("size", [(40, 1), (1, 40), (1, 1)])
def test_read_plate_estimates_depth_of_single_row_or_column(tmp_path, size):
    picture = write_picture(tmp_path / "p.png", np.full(size, 0.5))
    network = write_network(tmp_path / "n.onnx")
    plate = read_plate(picture, options(network, near_m=1.0, far_m=10.0))
    assert plate.depth_m.shape == size and np.isfinite(plate.depth_m).all()


@pytest.mark.parametrize("size", [(0, 64), (32, 0), (9000, 64)])
def test_read_plate_rejects_network_with_impossible_input_size(tmp_path, size):
    network = write_network(tmp_path / "n.onnx", size=size)
    with pytest.raises(InputError, match="sides of 1 to"):
        read_plate(write_picture(tmp_path / "p.png", two_halves(0.2, 0.8)), options(network))


@pytest.mark.parametrize(
    "option", [{"depth_known": KnownDistance(2.0, 2.0, 2.0)}, {"depth_model_output": "metres"}]
)
def test_open_refuses_options_of_network_without_network(tmp_path, option):
    picture = write_picture(tmp_path / "p.png", two_halves(0.2, 0.8))
    (name,) = option
    with pytest.raises(InputError, match=f"{name} is for .* name the network with depth_model"):
        heatlens.open(picture, **option)


def test_info_refuses_known_distance_without_network(tmp_path, capsys):
    picture = write_picture(tmp_path / "p.png", two_halves(0.2, 0.8))
    assert main(["info", str(picture), "--depth-known", "2,2=2m"]) == 2
    assert "--depth-known is for a depth that a network estimates" in capsys.readouterr().err
