"""Small movies, encoded by PyAV, whose frames can be told apart."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import av
import numpy as np

WIDTH, HEIGHT, RATE = 64, 36, 24
# Suffix, encoder, pixel format and options: all frames whole, or with frames that need others,
# in pieces of twelve or all in one.
CODECS: dict[str, tuple[str, str, str, dict[str, str]]] = {
    "ProRes": (".mov", "prores_ks", "yuv422p10le", {"profile": "3"}),
    "H.264": (".mp4", "libx264", "yuv420p", {"bf": "3", "g": "12", "crf": "8"}),
    "H.264, one key frame": (".mp4", "libx264", "yuv420p", {"bf": "2", "g": "250", "crf": "8"}),
    "VP9": (".webm", "libvpx-vp9", "yuv420p", {"cpu-used": "8", "crf": "4", "b:v": "0"}),
    "MPEG-2 in MXF": (".mxf", "mpeg2video", "yuv420p", {"bf": "2", "q:v": "2"}),
    "FFV1": (".mkv", "ffv1", "yuv444p16le", {}),
}


def ramps(count: int, width: int = WIDTH, height: int = HEIGHT) -> list[np.ndarray]:
    """Return grey pictures (H, W, 3) of 16 bits, each brighter than the one before."""
    across = np.linspace(4000, 20000, width)[None, :, None]
    levels = [across + 40000 * index / max(count, 1) for index in range(count)]
    return [np.broadcast_to(level, (height, width, 3)).astype(np.uint16) for level in levels]


def write_movie(
    path: Path,
    pictures: Sequence[np.ndarray],
    codec: str = "ProRes",
    *,
    pixel_format: str = "",
    encoder: str = "",
    options: dict[str, str] | None = None,
    times: Sequence[int] | None = None,
    timecode: str = "",
    rate: int = RATE,
    sound: np.ndarray | None = None,
    **tags: Any,
) -> Path:
    """Write pictures of 16 bits, RGB or RGBA, tagged as Rec.709 unless `tags` say otherwise.

    `sound` is (N, 2) int16 at 48 kHz.
    """
    _, usual_encoder, usual_format, codec_options = CODECS[codec]
    fmt = pixel_format or usual_format
    tags = {"color_primaries": 1, "color_trc": 1, "colorspace": 1, "color_range": 1} | tags
    container_options = {"write_tmcd": "1"} if path.suffix in (".mov", ".mp4") else {}
    with av.open(str(path), "w", options=container_options) as container:
        stream = container.add_stream(
            encoder or usual_encoder, rate=rate, options={**codec_options, **(options or {})}
        )
        stream.height, stream.width = pictures[0].shape[:2]
        stream.pix_fmt = fmt
        for name, value in tags.items():
            setattr(stream.codec_context, name, value)
        if timecode:
            container.metadata["timecode"] = timecode
        tracks = (
            [] if sound is None else [container.add_stream("pcm_s16le", 48000, layout="stereo")]
        )
        for index, pixels in enumerate(pictures):
            frame = _frame(pixels, fmt)
            frame.pts = index if times is None else times[index]
            container.mux(stream.encode(frame))
        for track in tracks:
            frame = av.AudioFrame.from_ndarray(sound.reshape(1, -1), "s16", "stereo")
            frame.sample_rate, frame.pts = 48000, 0
            container.mux(track.encode(frame))
        container.mux(stream.encode(None))
    return path


def _frame(pixels: np.ndarray, pixel_format: str) -> av.VideoFrame:
    if pixels.ndim == 3 and pixel_format.startswith("yuv444p") and pixels.dtype == np.uint8:
        return av.VideoFrame.from_ndarray(pixels.transpose(2, 0, 1), format="yuv444p")
    kind = "rgba64le" if pixels.shape[2] == 4 else "rgb48le"
    if pixel_format.startswith(("yuv", "gray")):  # FFmpeg takes this for white, not 65535
        pixels = pixels.copy()
        pixels[..., :3] = np.round(pixels[..., :3] * (0xFF00 / 0xFFFF))
    frame = av.VideoFrame.from_ndarray(np.ascontiguousarray(pixels), format=kind)
    return frame.reformat(format=pixel_format, dst_colorspace="ITU709", dst_color_range="MPEG")


def write_sound(path: Path) -> Path:
    """Write a movie file that holds only sound."""
    with av.open(str(path), "w") as container:
        stream = container.add_stream("aac", rate=48000, layout="mono")
        frame = av.AudioFrame.from_ndarray(np.zeros((1, 1024), np.float32), "fltp", "mono")
        frame.sample_rate = 48000
        container.mux(stream.encode(frame))
        container.mux(stream.encode(None))
    return path


def mark_rotated_clockwise(path: Path) -> Path:
    """Mark a QuickTime file as rotated clockwise, as phones do. Return its path."""
    data = bytearray(path.read_bytes())
    start = data.index(b"tkhd") + 44
    matrix = (0, 1 << 16, 0, -(1 << 16), 0, 0, 0, 0, 1 << 30)
    data[start : start + 36] = b"".join(value.to_bytes(4, "big", signed=True) for value in matrix)
    path.write_bytes(data)
    return path
