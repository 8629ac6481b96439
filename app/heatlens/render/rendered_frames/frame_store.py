"""Keep pictures in memory and on disk; the disk is read and written on threads."""

import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager

from heatlens.core.base.background import Threads
from heatlens.core.base.errors import HeatlensError
from heatlens.core.base.faults import report_faults
from heatlens.render.rendered_frames.cached_pictures import (
    CachedPicture,
    DiskStore,
    MemoryStore,
    RenderedPicture,
    default_memory_bytes,
)

MEGABYTE = 10**6
_WAITING_MAX = 3  # pictures that wait to be stored, whose memory is not counted
_FILE_EXTRA_BYTES = 4096  # the most bytes of a file besides its pixels


def memory_bytes_of(megabytes: int) -> int:
    """Return the memory limit that the user set; 0 means a quarter of the free memory."""
    return megabytes * MEGABYTE or default_memory_bytes()


class FrameStore:
    """Keeps pictures by key in memory and on disk; queries are answered at once.

    `version` increases whenever the content may have changed.
    """

    def __init__(
        self,
        memory: MemoryStore,
        disk: DiskStore | None = None,
        wake: Callable[[], None] = lambda: None,
    ) -> None:
        """Keep frames in memory and on `disk`, unless that is None; `wake` is called on threads."""
        self.memory = memory
        self.disk = disk
        self.problem = ""  # message about a picture that could not be stored or read; "" for none
        self.version = 0
        self._wake = wake
        self._lock = threading.Lock()
        self._writing: set[str] = set()
        self._loading: set[str] = set()
        self._unreadable: set[str] = set()
        self._is_disk_refused = False
        self._is_disk_listed = disk is None
        self._generation = 0  # increased by `clear`, which invalidates pending work
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="frames-write")
        self._loader = Threads("frames-read")
        if disk is not None:
            self._loader.submit(self._list_disk, disk)

    def known_keys(self) -> frozenset[str]:
        """Return the keys of all pictures, in memory and on disk."""
        on_disk = frozenset() if self.disk is None else self.disk.keys()
        with self._lock:
            return self.memory.keys() | on_disk | self._writing

    @property
    def can_take_picture(self) -> bool:
        """True if few pictures wait to be stored, and the disk has been listed."""
        with self._lock:
            return self._is_disk_listed and len(self._writing) < _WAITING_MAX

    @property
    def is_busy(self) -> bool:
        """True while something is being read or written."""
        with self._lock:
            return bool(self._writing or self._loading)

    def capacity(self, picture_bytes: int) -> int:
        """Return how many pictures of this size can be kept, in memory or on disk."""
        limits = [self.memory.limit_bytes // max(picture_bytes, 1)]
        if self.disk is not None:
            limits.append(self.disk.limit_bytes // (picture_bytes + _FILE_EXTRA_BYTES))
        return max(limits)

    def put(self, key: str, picture: RenderedPicture | CachedPicture) -> None:
        """Store a picture on a thread, first in memory, then on disk."""
        with self._lock:
            self._writing.add(key)
        self._writer.submit(self._store, key, picture, self._generation)
        self._notify_change()

    def fetch(self, keys: Iterable[str]) -> None:
        """Read those of `keys` that are only on disk into memory, in this order, on a thread."""
        if self.disk is None:
            return
        in_memory, on_disk = self.memory.keys(), self.disk.keys()
        for key in keys:
            with self._lock:
                is_available = key in in_memory or key in self._loading
                if is_available or key not in on_disk or key in self._unreadable:
                    continue
                self._loading.add(key)
            self._loader.submit(self._load, self.disk, key, self._generation)

    def clear(self) -> None:
        """Remove all pictures from memory and disk."""
        self._generation += 1
        self._unreadable.clear()
        self.memory.clear()
        if self.disk is not None:
            self._writer.submit(self._clear, self.disk)
        self._notify_change()

    def resize(self, memory_bytes: int, disk_bytes: int) -> None:
        """Set other limits."""
        self.memory.resize(memory_bytes)
        if self.disk is not None:
            self._writer.submit(self._resize, self.disk, disk_bytes)
        self._notify_change()

    def wait(self) -> None:
        """Wait until everything requested so far has been read and written."""
        self._writer.submit(lambda: None).result()
        self._loader.submit(lambda: None).result()

    def close(self) -> None:
        """Wait until waiting pictures are written; reading stops without being waited for."""
        self._loader.close()
        self._writer.shutdown(wait=True)

    def _store(self, key: str, picture: RenderedPicture | CachedPicture, generation: int) -> None:
        """Convert a picture to half floats and store it, unless the store was cleared meanwhile."""
        try:
            if generation == self._generation:
                with self._report_problem("A rendered frame could not be kept"):
                    half_picture = picture.as_kept()
                    self.memory.put(key, half_picture)
                    self._notify_change()
                    self._save(key, half_picture)
        finally:
            with self._lock:
                self._writing.discard(key)
            self._notify_change()

    def _save(self, key: str, picture: CachedPicture) -> None:
        """Save a picture to the disk too, unless that has failed before."""
        if self.disk is None or self._is_disk_refused:
            return
        try:
            with report_faults("A frame could not be written"):
                self.disk.save(key, picture)
        except HeatlensError as error:
            self._is_disk_refused = True
            self.problem = f"Rendered frames are kept only in memory: {error}"

    def _load(self, disk: DiskStore, key: str, generation: int) -> None:
        """Read a picture from the disk into memory; runs on a thread.

        The picture is dropped if the store was cleared meanwhile, so that `generation` has changed.
        """
        self._unreadable.add(key)  # until it was read, because a file is tried only once
        try:
            with self._report_problem("A rendered frame could not be read from the disk"):
                picture = disk.load(key)
                if picture is not None and generation == self._generation:
                    self.memory.put(key, picture)
                self._unreadable.discard(key)
        finally:
            with self._lock:
                self._loading.discard(key)
            self._notify_change()

    def _list_disk(self, disk: DiskStore) -> None:
        """List the pictures on the disk."""
        try:
            with self._report_problem("The folder of rendered frames could not be listed"):
                disk.list_folder()
        finally:
            self._is_disk_listed = True
            self._notify_change()

    def _clear(self, disk: DiskStore) -> None:
        """Delete the pictures on the disk; a problem is reported, not raised."""
        with self._report_problem("Rendered frames could not be deleted"):
            disk.clear()
        self._notify_change()

    def _resize(self, disk: DiskStore, limit_bytes: int) -> None:
        """Set the limit of the disk and delete beyond it; a problem is reported, not raised."""
        with self._report_problem("Rendered frames could not be deleted"):
            disk.resize(limit_bytes)
        self._notify_change()

    @contextmanager
    def _report_problem(self, summary: str) -> Iterator[None]:
        """Write an error of the block to `problem`, because errors of threads are not shown."""
        try:
            with report_faults(summary):
                yield
        except HeatlensError as error:
            self.problem = str(error)

    def _notify_change(self) -> None:
        """Increase `version`, and wake the loop of the window."""
        with self._lock:
            self.version += 1
        self._wake()
