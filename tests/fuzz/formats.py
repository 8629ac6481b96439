"""Formats for the fuzzers: how to write undamaged files, and how to read a damaged one.

Each reader raises HeatlensError or returns arrays that must all be finite.
"""

import struct
from collections.abc import Callable, Iterable
from dataclasses import astuple, dataclass
from functools import partial
from pathlib import Path

import charset_normalizer
import disguised_formats
import footage_formats
import numpy as np
import OpenEXR
import osc_packets
import packed_formats
import photo_formats
import ring_packets
from tevclient import packet as client_packet

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.camera_file import read_camera, write_camera
from heatlens.media.camera.rows import read_csv_camera, read_json_camera
from heatlens.media.camera.usd_read import usd_camera
from heatlens.media.color.color_config import load_color_config
from heatlens.media.documents import edit_file
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.files.usd_library import usd_module
from heatlens.media.live.stream.chosen_image import choose_image
from heatlens.media.live.stream.images import TevImages
from heatlens.media.live.stream.protocol import (
    PacketStream,
    TevPacketError,
    TevStreamError,
    parse_message,
)
from heatlens.media.live.stream.received_plate import LENS_IMAGE, lens_header, plate_of_image
from heatlens.media.plate.header.camera_header import lens_attributes
from heatlens.media.plate.picture import picture_open
from heatlens.media.plate.plate import Plate
from heatlens.media.plate.read import read_plate
from heatlens.media.scene.gltf import compressed
from heatlens.media.scene.scene import Scene
from heatlens.media.scene.scene_read import read_scene
from heatlens.media.scene.usd.read import usd_scene
from support.cameras import moving_camera
from support.exr_files import distances, rgb, tiled_header, write_file, write_parts
from support.gltf_files import encoded, figure_scene, square_scene
from support.mesh_files import MTL, OBJ, PIXELS, PLY, STL
from support.shoot_tables import SHOOT_TABLES
from support.shots_of_tests import with_keys_and_marks
from support.tev_packets import GOOD

Arrays = Iterable[np.ndarray]


@dataclass(frozen=True)
class Format:
    """One fuzzed format: a writer of undamaged files into a folder, and a reader of one file.

    `seal` corrects the checksums of a damaged file; it is applied to half of the mutants.
    """

    write: Callable[[Path], list[Path]]
    read: Callable[[Path], Arrays]
    seal: Callable[[bytes], bytes] | None = None


def _exr(folder: Path) -> list[Path]:
    channels = {n: v / 7 for n, v in rgb(12, 16).items()} | {"Z": distances(12, 16)}
    header = lens_attributes(50.0, 2.0, 2.24, 36.0, 24.0)
    paths = []
    for name in (n for n in dir(OpenEXR) if n.endswith("_COMPRESSION")):
        path, kind = folder / f"{name.split('_')[0].lower()}.exr", getattr(OpenEXR, name)
        paths.append(write_file(path, channels, compression=kind, **header))
    paths.append(write_file(folder / "tiled.exr", channels, **tiled_header(), **header))
    color, depth = ({"name": "rgb"}, rgb(12, 16)), ({"name": "depth"}, {"Z": distances(12, 16)})
    return [*paths, write_parts(folder / "parts.exr", color, depth)]


def _deep(folder: Path) -> list[Path]:
    """Write deep files with 0 to 3 samples per pixel, also thick ones, in each compression."""
    names = (*"RGBAZ", "ZBack")
    channels = {name: np.empty((6, 8), dtype=object) for name in names}
    for y, x in np.ndindex(6, 8):
        count = (x + y) % 4
        for k, name in enumerate(names):
            values = np.linspace(1.0, 2.0 + k, count) if k > 3 else np.full(count, 0.5)
            channels[name][y, x] = values.astype(np.float16 if k < 4 else np.float32)
    paths = []
    for kind in ("NO", "RLE", "ZIPS"):
        header = {"type": OpenEXR.deepscanline}
        header["compression"] = getattr(OpenEXR, f"{kind}_COMPRESSION")
        paths.append(write_file(folder / f"deep_{kind.lower()}.exr", channels, **header))
    tiled = tiled_header() | {"type": OpenEXR.deeptile, "compression": OpenEXR.ZIPS_COMPRESSION}
    paths.append(write_file(folder / "deep_tiled.exr", channels, **tiled))
    flat = ({"name": "flat", "type": OpenEXR.scanlineimage}, rgb(6, 8))
    deep = ({"name": "deep"} | header, channels)
    return [*paths, write_parts(folder / "deep_parts.exr", flat, deep)]


def _plate(path: Path, read: Callable[[Path], Plate] = read_plate) -> Arrays:
    return _plate_values(read(path))


def _plate_values(plate: Plate) -> Arrays:
    depth = plate.coc_px if plate.depth_m is None else plate.depth_m
    assert depth is not None
    yield from (plate.color, depth[~np.isinf(depth)])
    if (lists := plate.fragments) is not None:
        yield from (lists.color, lists.coverage, lists.dioptres)
        assert lists.begins[-1] == lists.count


def _meshes(scene: Scene) -> Arrays:
    for mesh in scene.meshes:
        yield from (mesh.positions_m, mesh.normals, mesh.uvs)
        assert mesh.triangles.size == 0 or mesh.triangles.max() < len(mesh.positions_m)
    for mesh in scene.shapes_at(7.5).values():
        yield from (mesh.positions_m, mesh.normals)
    yield scene.transforms_at(1)


def _beside(name: str, data: bytes) -> Callable[[Path], list[Path]]:
    def write(folder: Path) -> list[Path]:
        (folder / "a.mtl").write_text(MTL)
        (folder / "pic.png").write_bytes(encoded(PIXELS))
        (folder / name).write_bytes(data)
        return [folder / name]

    return write


def _materials(folder: Path) -> list[Path]:
    """Write an OBJ and return its MTL file, which is damaged in its place."""
    return [_beside("a.obj", OBJ.encode())(folder)[0].with_name("a.mtl")]


def _gltf(folder: Path) -> list[Path]:
    (folder / "a.glb").write_bytes(square_scene().glb())
    (folder / "a.gltf").write_bytes(square_scene().gltf())
    (folder / "b.glb").write_bytes(figure_scene().glb())
    (folder / "b.gltf").write_bytes(figure_scene().gltf())
    return [folder / name for name in ("a.glb", "a.gltf", "b.glb", "b.gltf")]


def _stage(folder: Path) -> list[Path]:
    """Write USD stages as text (.usda), in binary (.usdc) and as a package (.usdz)."""
    text, binary, package = (folder / f"a.{kind}" for kind in ("usda", "usdc", "usdz"))
    text.write_bytes((Path(__file__).parent / "stage.usda").read_bytes())
    shapes, binary_shapes = folder / "d.usda", folder / "e.usdc"
    shapes.write_bytes((Path(__file__).parent / "shapes.usda").read_bytes())
    usd_module("Sdf").Layer.FindOrOpen(str(shapes)).Export(str(binary_shapes))
    usd_module("Sdf").Layer.FindOrOpen(str(text)).Export(str(binary))
    assert usd_module("UsdUtils").CreateNewUsdzPackage(str(binary), str(package))
    return [text, binary, package, shapes, binary_shapes]


def _usd_cameras(folder: Path) -> list[Path]:
    cameras = [folder / "b.usda", folder / "c.usdc"]
    for path in cameras:
        write_camera(path, moving_camera())
    return [*cameras, *_stage(folder)[:2]]


def _ply(folder: Path) -> list[Path]:
    """Write PLY files of polygons, triangle strips, points, and polygons of mixed sizes."""
    vertices = b"0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n1 1 0 0 0 1\n"
    head = b"ply\nformat ascii 1.0\nelement vertex 4\n" + b"".join(
        f"property float {name}\n".encode() for name in ("x", "y", "z", "nx", "ny", "nz")
    )
    strips = b"element tristrips 1\nproperty list int int vertex_indices\nend_header\n"
    (folder / "a.ply").write_bytes(PLY)
    (folder / "b.ply").write_bytes(head + strips + vertices + b"8 0 1 2 3 -1 2 1 0\n")
    (folder / "c.ply").write_bytes(head + b"end_header\n" + vertices)
    polygons = b"element face 2\nproperty list uchar uint vertex_indices\nend_header\n"
    data = np.zeros((4, 6), "<f4").tobytes() + struct.pack("<B4IB3I", 4, 0, 1, 2, 3, 3, 0, 1, 2)
    binary = head.replace(b"ascii", b"binary_little_endian") + polygons + data
    (folder / "d.ply").write_bytes(binary)
    return [folder / f"{name}.ply" for name in "abcd"]


def _camera(suffix: str) -> Callable[[Path], list[Path]]:
    def write(folder: Path) -> list[Path]:
        write_camera(folder / f"cam{suffix}", moving_camera())
        return [folder / f"cam{suffix}"]

    return write


def _shot(folder: Path) -> list[Path]:
    write_shot(folder / "s.heatlens.json", with_keys_and_marks(Shot(Lens(50.0, 2.0, 2.0, 36.0))))
    return [folder / "s.heatlens.json"]


def _shoot(folder: Path) -> list[Path]:
    """Write the lens tables that cameras of three makers export."""
    for name, text in SHOOT_TABLES.items():
        (folder / f"{name}.csv").write_text(text)
    return [folder / f"{name}.csv" for name in SHOOT_TABLES]


def _numbers(values: Iterable[object]) -> Arrays:
    numbers = [value for value in values if isinstance(value, float)]
    return [np.array([value for value in numbers if value != np.inf])]


def _lens_numbers(path: Path) -> Arrays:
    return _numbers(astuple(read_shot(path).lens))


def _ocio(folder: Path) -> list[Path]:
    (folder / "c.ocio").write_bytes((Path(__file__).parent / "config.ocio").read_bytes())
    return [folder / "c.ocio"]


def _config(path: Path) -> Arrays:
    config = load_color_config(str(path))
    for display in config.displays():
        config.views(display)
    config.input_spaces()
    return ()


def _tev(folder: Path) -> list[Path]:
    """Write all kinds of tev packets, with a closed and recreated image, and a lens image."""
    create, update, close, *others = GOOD
    names = ["focal_length_mm", "sensor_width_mm", "f_stop", "focus_distance_m"]
    values = np.array([[[50, 36, 2.8, 4.2]]], np.float32)
    lens = (
        bytes(client_packet.create_image(LENS_IMAGE, 1, 1, names)),
        bytes(client_packet.update_image(LENS_IMAGE, values, names)),
    )
    packets = (create, update, *others, close, create, update, *lens)
    (folder / "stream").write_bytes(b"".join(packets))
    return [folder / "stream"]


def _stream(path: Path) -> Arrays:
    """Read packets as the tev server does, and make a plate of the received images."""
    images, stream, remaining = TevImages(max_values=1 << 16), PacketStream(), path.read_bytes()
    problems: list[Exception] = []
    while remaining:
        byte_count = max(stream.expected_bytes, 1)
        try:
            packet = stream.feed(remaining[:byte_count])
            if packet is not None:
                images.apply(parse_message(packet))
        except TevPacketError as error:  # the packet is dropped, the connection goes on
            problems.append(error)
        except TevStreamError as error:
            problems.append(error)
            break
        remaining = remaining[byte_count:]
    try:
        yield from _received(images)
    except InputError as error:
        problems.append(error)
    if problems:
        raise HeatlensError(str(problems[0])) from problems[0]


def _received(images: TevImages) -> Arrays:
    names, options = [name for name in images.names if name != LENS_IMAGE], PlateOptions()
    received_images = [image for image in map(images.get, names) if image is not None]
    lens = lens_header(images.get(LENS_IMAGE))
    plate = plate_of_image(choose_image(received_images, options), options, lens)
    return (*_plate_values(plate), *_numbers(vars(plate.camera).values()))


def without_slow_guesses() -> None:
    """Replace the guess of text encodings in trimesh, which takes ten times as long as reading."""
    encodings = ("latin-1", "utf-8", "shift_jis", "utf_16", None)
    charset_normalizer.detect = lambda data: {
        "encoding": encodings[sum(data) % len(encodings)],
        "confidence": 0.5,
    }


def without_own_processes() -> None:
    """Read formats in this process that the program reads in a process of its own."""
    compressed.is_bounded = picture_open.is_bounded = edit_file.is_bounded = lambda: True


FORMATS = {
    "exr": Format(_exr, _plate),
    "deep": Format(_deep, _plate),
    **{
        name: Format(write, partial(_plate, read=photo_formats.read_with_map(suffix)), seal)
        for name, suffix, write, seal in (
            ("png", ".png", photo_formats.png, photo_formats.with_checksums),
            ("jpeg", ".jpg", photo_formats.jpeg, None),
            ("tiff", ".tif", photo_formats.tiff, None),
            ("heic", ".heic", photo_formats.heic, None),
            ("webp", ".webp", photo_formats.webp, None),
            ("dpx", ".dpx", photo_formats.dpx, None),
        )
    },
    "movie": Format(footage_formats.movies, footage_formats.frames_and_sound),
    "edit": Format(footage_formats.edits, footage_formats.frames_of_edit),
    "capture": Format(footage_formats.captures, footage_formats.lens_of_capture),
    "depth-inside": Format(photo_formats.with_depth_inside, _plate),
    "disguised": Format(disguised_formats.under_other_endings, disguised_formats.values),
    "pfm": Format(disguised_formats.pfm, disguised_formats.finite_values),
    "manifest": Format(disguised_formats.manifests, disguised_formats.matte_by_manifest),
    "gltf": Format(_gltf, lambda path: _meshes(read_scene(path))),
    "gltf-packed": Format(
        packed_formats.write_parts_alone,
        lambda path: _meshes(read_scene(packed_formats.as_gltf(path))),
    ),
    "obj": Format(_beside("a.obj", OBJ.encode()), lambda path: _meshes(read_scene(path))),
    "mtl": Format(_materials, lambda path: _meshes(read_scene(path.with_name("a.obj")))),
    "ply": Format(_ply, lambda path: _meshes(read_scene(path))),
    "stl": Format(_beside("a.stl", STL), lambda path: _meshes(read_scene(path))),
    "usd": Format(_stage, lambda path: _meshes(usd_scene(str(path)))),
    "usd-camera": Format(
        _usd_cameras, lambda path: _numbers(usd_camera(str(path)).focal_length_mm or ())
    ),
    "camera-json": Format(
        _camera(".json"), lambda path: _numbers(read_json_camera(path).focal_length_mm or ())
    ),
    "camera-csv": Format(
        _camera(".csv"), lambda path: _numbers(read_csv_camera(path).focal_length_mm or ())
    ),
    "shoot-csv": Format(
        _shoot, lambda path: _numbers(read_camera(str(path)).focus_distance_m or ())
    ),
    "shot": Format(_shot, _lens_numbers),
    "ocio": Format(_ocio, _config),
    "tev": Format(_tev, _stream),
    "osc": Format(osc_packets.datagrams, osc_packets.received_values),
    "opentrackio": Format(
        write=ring_packets.packets,
        read=ring_packets.received_values,
        seal=ring_packets.with_checksums,
    ),
}
