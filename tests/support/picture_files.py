"""Pictures as phones, cameras and depth networks write them, made for the tests."""

import base64
import math
from io import BytesIO
from pathlib import Path

import numpy as np
import OpenImageIO
from PIL import Image, ImageCms

HEIGHT, WIDTH = 24, 36
_XMP = b"http://ns.adobe.com/xap/1.0/\0"
_EXTENSION = b"http://ns.adobe.com/xmp/extension/\0"
_ALPHA_OF_HEIC, _DEPTH_OF_HEIC = (b"urn:mpeg:hevc:2015:auxid:%d" % kind for kind in (1, 2))


def colors(height=HEIGHT, width=WIDTH):
    """Return (H, W, 3) of 8 bits, every value from 0 to 255 somewhere."""
    ramp = np.arange(height * width) * 255 // (height * width - 1)
    return np.stack([ramp, 255 - ramp, ramp // 2], axis=1).reshape(height, width, 3).astype("u1")


def metres(height=HEIGHT, width=WIDTH):
    """Return distances (H, W) from 1 to 10 m, evenly over 1/z, with a step in the middle."""
    part = np.linspace(0, 0.4, height * width).reshape(height, width)
    part[:, width // 2 :] += 0.6
    return 1 / (0.1 + part * 0.9)


def disparity(distance_m, near_m, far_m):
    """Convert distances to disparity 0..1, from `far_m` to `near_m`."""
    return (1 / distance_m - 1 / far_m) / (1 / near_m - 1 / far_m)


LARGEST = {"u1": 255, "u2": 65535}  # of unsigned whole numbers, by their type


def whole(values, kind):
    """Convert 0..1 to unsigned whole numbers of a type, "u1" or "u2"."""
    return np.round(values * LARGEST[kind]).astype(kind)


def save(path: Path, values, **options) -> Path:
    Image.fromarray(values).save(path, **options)
    return path


def save_16_bits_of_color(path: Path, values) -> Path:
    """Save (H, W, C) of uint16 or float32, which Pillow cannot write."""
    kind = "uint16" if values.dtype == np.uint16 else "float"
    spec = OpenImageIO.ImageSpec(values.shape[1], values.shape[0], values.shape[2], kind)
    out = OpenImageIO.ImageOutput.create(str(path))
    assert out.open(str(path), spec) and out.write_image(values)
    out.close()
    return path


def save_dpx(path: Path, values, bits: int = 10, **attributes) -> Path:
    """Save 0..1 (H, W, C) as a DPX of so many bits a channel; 32 are floating point."""
    kind = {8: "uint8", 32: "float"}.get(bits, "uint16")
    spec = OpenImageIO.ImageSpec(values.shape[1], values.shape[0], values.shape[2], kind)
    spec.attribute("oiio:BitsPerSample", bits)
    for name, value in attributes.items():
        spec.attribute(f"dpx:{name}", value)
    out = OpenImageIO.ImageOutput.create("dpx")
    assert out.open(str(path), spec) and out.write_image(np.float32(values))
    out.close()
    return path


def display_p3() -> bytes:
    """Return an ICC profile named Display P3; its numbers are those of sRGB and are not read."""
    data = bytearray(ImageCms.ImageCmsProfile(ImageCms.createProfile("sRGB")).tobytes())
    name = "sRGB built-in".encode("utf-16-be")
    start = data.find(name)
    assert start > 0
    data[start : start + len(name)] = "Display P3   ".encode("utf-16-be")
    return bytes(data)


def encoded(values, kind="PNG") -> bytes:
    out = BytesIO()
    Image.fromarray(values).save(out, kind)
    return out.getvalue()


def jpeg_with_gdepth(path: Path, near_m, far_m, fraction, form="RangeInverse", turn=1) -> Path:
    """Write a photo whose XMP holds the depth, most of it in an extension of several pieces."""
    data = base64.b64encode(encoded((fraction * 255 + 0.5).astype("u1"))).decode()
    head = (
        '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:Description '
        f'GDepth:Format="{form}" GDepth:Near="{near_m}" GDepth:Far="{far_m}" '
        'GDepth:Mime="image/png" /></x:xmpmeta>'
    )
    body = f'<x:xmpmeta><rdf:Description GDepth:Data="{data}" /></x:xmpmeta>'.encode()
    pieces, size = [], math.ceil(len(body) / 3)
    for offset in range(0, len(body), size):
        pieces.append(
            _EXTENSION
            + b"0" * 32
            + len(body).to_bytes(4, "big")
            + offset.to_bytes(4, "big")
            + body[offset : offset + size]
        )
    exif = Image.Exif()
    exif[0x0112] = turn  # orientation
    plain = BytesIO()
    Image.fromarray(colors()).save(plain, "JPEG", quality=95, exif=exif)
    segments = b"".join(_segment(data) for data in [_XMP + head.encode(), *reversed(pieces)])
    jpeg = plain.getvalue()
    path.write_bytes(jpeg[:2] + segments + jpeg[2:])
    return path


def jpeg_with_dynamic_depth(path: Path, near_m, far_m, fraction) -> Path:
    """Write a photo with another picture and the depth behind it, as a container lists them."""
    depth, confidence = encoded((fraction * 255 + 0.5).astype("u1"), "JPEG"), encoded(colors())
    xmp = (
        "<x:xmpmeta><Container:Directory>"
        '<Container:Item Item:Mime="image/jpeg" Item:Length="0" Item:DataURI="primary"/>'
        f'<Container:Item Item:Mime="image/png" Item:Length="{len(confidence)}"/>'
        f'<Container:Item Item:Mime="image/jpeg" Item:Length="{len(depth)}"/>'
        f'</Container:Directory><Device:DepthMap DepthMap:Format="RangeInverse" '
        f'DepthMap:Near="{near_m}" DepthMap:Far="{far_m}" DepthMap:Units="Meters"/></x:xmpmeta>'
    )
    jpeg = encoded(colors(), "JPEG")
    path.write_bytes(jpeg[:2] + _segment(_XMP + xmp.encode()) + jpeg[2:] + confidence + depth)
    return path


def heic_with_depth(path: Path, near_m: float, far_m: float, fraction, **options) -> Path:
    """Write a photo with disparity between two distances, powers of 2, as an auxiliary picture.

    libheif writes no depth, but alpha is stored in the same way: what it is called is changed, and
    the message of its ends (ISO/IEC 23008-2, annex G) is added to it.
    """
    values = (fraction * 255 + 0.5).astype("u1")
    Image.fromarray(np.dstack([colors(*values.shape), values])).save(path, **options)
    data = bytearray(path.read_bytes().replace(_ALPHA_OF_HEIC, _DEPTH_OF_HEIC))
    message = _ends_of_depth(near_m, far_m)
    boxes = [data.index(kind) - 4 for kind in (b"meta", b"iprp", b"ipco", b"auxC")]
    end = boxes[-1] + int.from_bytes(data[boxes[-1] :][:4], "big")
    for box in boxes:
        _add_to_uint32(data, box, len(message))
    places = data.index(b"iloc") + 4 + 8  # behind its version and sizes: items of 18 bytes
    for item in range(int.from_bytes(data[places - 2 : places], "big")):
        _add_to_uint32(data, places + 18 * item + 4, len(message))
    path.write_bytes(data[:end] + message + data[end:])
    return path


def _add_to_uint32(data: bytearray, offset: int, count: int) -> None:
    data[offset : offset + 4] = (int.from_bytes(data[offset : offset + 4], "big") + count).to_bytes(
        4, "big"
    )


def _ends_of_depth(near_m: float, far_m: float) -> bytes:
    """Return the message of HEVC, with two lengths: near and far, powers of 2, evenly over 1/z."""
    numbers = (f"0{31 + round(math.log2(end_m)):07b}000000" for end_m in (near_m, far_m))
    bits = "11001" + "".join(numbers)
    payload = int(bits.ljust(40, "0"), 2).to_bytes(5, "big")
    unit = bytes([39 << 1, 1, 177, len(payload)]) + payload
    unit = len(unit).to_bytes(4, "big") + unit
    return len(unit).to_bytes(4, "big") + unit


def _segment(data: bytes) -> bytes:
    return b"\xff\xe1" + (len(data) + 2).to_bytes(2, "big") + data
