"""Read the container of a glTF 2.0 file: its JSON and its buffers.

`.glb` holds both in one file; `.gltf` holds its buffers as base64, or names files beside it. No
library is used: trimesh leaves out lights, animations and all cameras but one, and pygltflib leaves
the accessors, and all checks for damaged files, to the caller.

Sources: Khronos, glTF 2.0 specification, sections 3.6 (buffers) and 4 (GLB).
"""

import base64
import binascii
import json
import struct
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn
from urllib.parse import unquote

from heatlens.core.base.errors import InputError
from heatlens.core.base.paths import open_regular_file, read_file_bytes, unreadable_error
from heatlens.media.files.json_record import JsonEntry
from heatlens.media.scene.gltf.compressed import unpack_meshopt
from heatlens.media.scene.gltf.json_values import Record

READ_EXTENSIONS = frozenset(
    {
        *("KHR_lights_punctual", "KHR_materials_emissive_strength", "KHR_mesh_quantization"),
        *("KHR_texture_transform", "EXT_texture_webp", "EXT_mesh_gpu_instancing"),
        *("KHR_materials_unlit", "KHR_materials_pbrSpecularGlossiness"),
        *("KHR_materials_transmission", "KHR_draco_mesh_compression", "KHR_texture_basisu"),
        *("EXT_meshopt_compression", "KHR_meshopt_compression"),
        *("KHR_animation_pointer", "KHR_node_visibility"),
    }
)
# A file may require these: they affect only gloss, or nothing visible.
_HARMLESS = ("KHR_materials_", "KHR_xmp")


def check_required_extensions(root: Record) -> None:
    """Raise InputError that names an extension which the file requires but is not read."""
    required = root.entry_at("extensionsRequired").items() if root.has("extensionsRequired") else []
    for name in (item.text() for item in required):
        if name not in READ_EXTENSIONS and not name.startswith(_HARMLESS):
            root.refuse(
                f"it needs {name[:60]}, which heatlens does not support; export it without that"
            )


_MAGIC = b"glTF"
_JSON, _BIN = 0x4E4F534A, 0x004E4942
_HEAD_BYTES = 20  # header of a .glb and of its first chunk, which is the JSON
# Limits for one file: meshes may share their bytes, but each takes its own memory.
_BUFFERS_MOST = 4_000_000_000
_NUMBERS_MOST = 200_000_000
_EMPTY_NUMBERS_MOST = 4_000_000
_MESHOPT_EXTENSIONS = ("KHR_meshopt_compression", "EXT_meshopt_compression")


@dataclass(frozen=True, eq=False)
class GltfFile:
    """A file whose JSON is valid; its buffers are read when they are first used."""

    path: Path
    root: Record
    binary: bytes | None  # the binary chunk of a .glb
    _buffers: dict[int, bytes] = field(default_factory=dict)
    _lists: dict[str, list[Record]] = field(default_factory=dict)
    _numbers_read: dict[str, int] = field(default_factory=dict)
    _views: dict[int, bytes] = field(default_factory=dict)  # unpacked buffer views
    losses: dict[str, set[str]] = field(
        default_factory=dict
    )  # sentence -> the places it applies to

    def note_loss(self, words: str, record: Record) -> None:
        """Record a feature that is not drawn as in the file, and one place where it occurs.

        `words` describe the feature. It is reported once, with the number of its places.
        """
        self.losses.setdefault(words, set()).add(record.entry.place)

    def top_level(self, name: str) -> list[Record]:
        """Return the objects of a top-level list of the file, such as its `nodes`."""
        if name not in self._lists:
            self._lists[name] = self.root.records(name)
        return self._lists[name]

    def index(self, record: Record, name: str, list_name: str) -> int | None:
        """Return the entry `name`, an index into a top-level list; None if there is no entry."""
        return record.index(name, len(self.top_level(list_name)))

    def required_index(self, record: Record, name: str, list_name: str) -> int:
        """Return the entry `name`, an index into a top-level list; the entry must be there."""
        return record.required_index(name, len(self.top_level(list_name)))

    def buffer(self, index: int) -> bytes:
        """Return the bytes of a buffer; raise InputError if some are missing."""
        if index not in self._buffers:
            self._buffers[index] = self._read_buffer(index)
        return self._buffers[index]

    def _read_buffer(self, index: int) -> bytes:
        """Read a buffer from its `uri` or from the binary chunk of a .glb."""
        record = self.top_level("buffers")[index]
        length = record.whole_number("byteLength")
        if record.has("uri"):
            data = self.uri_bytes(record)
        elif index == 0 and self.binary is not None:
            data = self.binary
        else:
            record.refuse("this buffer has no bytes: neither in the file nor beside it")
        if len(data) < length:
            record.refuse(f"only {len(data)} of {length} bytes are there; the file is cut short")
        bytes_before = sum(map(len, self._buffers.values()))
        if bytes_before + length > _BUFFERS_MOST:
            record.refuse(f"its buffers hold more than {_BUFFERS_MOST / 1e9:g} GB together")
        return data[:length]

    def count_numbers(self, record: Record, numbers: int, is_empty: bool) -> None:
        """Count the numbers that an accessor reads; raise InputError if the sum is too large.

        `is_empty` marks an accessor without bytes, with which a tiny file could claim any amount of
        memory.
        """
        kind, numbers_most = (
            ("empty", _EMPTY_NUMBERS_MOST) if is_empty else ("filled", _NUMBERS_MOST)
        )
        self._numbers_read[kind] = self._numbers_read.get(kind, 0) + numbers
        if self._numbers_read[kind] > numbers_most:
            reason = "and has no bytes for them; " if is_empty else "with all before it; "
            record.refuse(
                f"it claims {numbers:,} numbers {reason}{numbers_most:,} are the most in one file"
            )

    def view(self, index: int) -> memoryview:
        """Return the bytes of a buffer view; raise InputError if it exceeds its buffer."""
        record = self.top_level("bufferViews")[index]
        extension = next(
            (name for name in _MESHOPT_EXTENSIONS if record.object_at("extensions").has(name)), None
        )
        if extension is None:
            return self._slice_buffer(record)
        if index not in self._views:
            compressed = record.object_at("extensions", extension)
            self._views[index] = unpack_meshopt(compressed, self._slice_buffer(compressed))
        return memoryview(self._views[index])

    def _slice_buffer(self, record: Record) -> memoryview:
        """Return the bytes of the buffer that a view names, without unpacking them."""
        data = self.buffer(self.required_index(record, "buffer", "buffers"))
        start, length = record.whole_number("byteOffset", 0), record.whole_number("byteLength")
        if start + length > len(data):
            record.refuse(f"it ends at byte {start + length} of a buffer of {len(data)}")
        return memoryview(data)[start : start + length]

    def uri_bytes(self, record: Record) -> bytes:
        """Return the bytes of a `uri`: base64 data, or a file in the folder of this file."""
        path = self.uri_path(record)
        if path is None:
            return _decode_base64(record, record.text("uri"))
        try:
            return read_file_bytes(path)
        except OSError as error:
            _refuse_unreadable(record, error)

    def uri_path(self, record: Record) -> Path | None:
        """Return the file that a `uri` names, whether it exists or not; None for base64.

        Raises InputError if it is not in or below the folder of this file.
        """
        uri = record.text("uri")
        if uri.startswith("data:"):
            return None
        if "://" in uri or uri.startswith(("//", "http:", "https:", "file:")):
            record.refuse(f"{uri[:80]!r} is not a local file; put the file beside this one")
        folder = self.path.parent.resolve()
        try:
            path = (folder / unquote(uri)).resolve()
        except (OSError, RuntimeError, ValueError) as error:  # a loop of links is a RuntimeError
            _refuse_unreadable(record, error)
        if not path.is_relative_to(folder):
            record.refuse(f"{unquote(uri)[:80]!r} leads out of the folder of this file")
        return path


def _refuse_unreadable(record: Record, error: Exception) -> NoReturn:
    """Raise InputError for a file that the `uri` of a record names and that cannot be read."""
    reason = getattr(error, "strerror", None) or error
    record.refuse(f"{unquote(record.text('uri'))[:80]!r} cannot be read: {reason}")


def named_files(path: Path) -> tuple[Path, ...]:
    """Return the files of buffers and pictures that a .gltf or .glb names.

    They are in the order of the file and need not exist. Invalid names are left out. Only the JSON
    is read. Raises InputError if that is not possible.
    """
    file = GltfFile(path, _parse_json(path, _read_json_text(path)), binary=None)
    files: dict[Path, None] = {}
    for record in (*file.top_level("buffers"), *file.top_level("images")):
        with suppress(InputError):
            named_file = file.uri_path(record) if record.has("uri") else None
            files |= {} if named_file is None else {named_file: None}
    return tuple(files)


def _read_json_text(path: Path) -> bytes:
    """Return the JSON of a .gltf or .glb without its buffers."""
    try:
        with open_regular_file(path) as file:
            header_bytes = file.read(_HEAD_BYTES)
            if not header_bytes.startswith(_MAGIC):
                return header_bytes + file.read()
            if len(header_bytes) < _HEAD_BYTES:
                _raise_cut_short(path)
            return file.read(struct.unpack_from("<I", header_bytes, 12)[0])
    except OSError as error:
        raise unreadable_error(path, error) from error


def open_gltf(path: Path) -> GltfFile:
    """Open a file.

    Raises InputError if it is not glTF 2.0, damaged, or requires an unsupported extension.
    """
    try:
        data = read_file_bytes(path)
    except OSError as error:
        raise unreadable_error(path, error) from error
    if not data:
        raise InputError(f"{path} is empty: it holds no scene.")
    text, binary = _split_chunks(path, data) if data.startswith(_MAGIC) else (data, None)
    file = GltfFile(path, _parse_json(path, text), binary)
    _check_version(file.root)
    check_required_extensions(file.root)
    return file


def _split_chunks(path: Path, data: bytes) -> tuple[bytes, bytes | None]:
    """Return the JSON of a .glb, and its binary chunk if it has one. Raises InputError."""
    if len(data) < _HEAD_BYTES:
        _raise_cut_short(path)
    version, length = struct.unpack_from("<II", data, 4)
    if version != 2:
        raise InputError(f"{path} is glTF of version {version}; heatlens reads version 2.")
    if length > len(data):
        _raise_cut_short(path)
    chunks: dict[int, bytes] = {}
    start = 12
    while start + 8 <= length:
        size, kind = struct.unpack_from("<II", data, start)
        if start + 8 + size > length:
            _raise_cut_short(path)
        chunks.setdefault(kind, data[start + 8 : start + 8 + size])
        start += 8 + size
    if _JSON not in chunks:
        raise InputError(f"{path} is damaged: it has no description of a scene. Export it again.")
    return chunks[_JSON], chunks.get(_BIN)


def _raise_cut_short(path: Path) -> NoReturn:
    raise InputError(f"{path} is damaged or cut short: bytes are missing. Export it again.")


def _parse_json(path: Path, text: bytes) -> Record:
    """Return the root object of the JSON. Raises InputError if it is damaged."""
    try:
        value = json.loads(text.decode("utf-8-sig"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path} is damaged or not glTF: {error}. Export it again.") from error
    return Record(JsonEntry(path, "", value))


def _check_version(root: Record) -> None:
    """Raise InputError for a file that is not glTF 2.0, or needs a newer version."""
    version = root.object_at("asset").text("version")
    if not version.startswith("2."):
        root.refuse(f"this is not glTF version 2 but {version[:20] or 'none'!r}")
    least = root.object_at("asset").text("minVersion", "2.0")
    if least != "2.0":
        root.refuse(f"it needs glTF of version {least[:20]!r}; heatlens reads 2.0")


def _decode_base64(record: Record, uri: str) -> bytes:
    """Return the bytes of a `uri` with base64 data."""
    head, _, text = uri.partition(",")
    if not head.endswith(";base64"):
        record.refuse("its data should be in base64")
    try:
        return base64.b64decode(unquote(text), validate=True)
    except (binascii.Error, ValueError) as error:
        record.refuse(f"its base64 is damaged ({error})")
