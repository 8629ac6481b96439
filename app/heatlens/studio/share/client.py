"""One page or program that is connected: what it is sent, and what it says."""

import asyncio
import json
import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress

from aiohttp import WSMsgType, web

from heatlens.core.base.errors import InputError
from heatlens.studio.share.address import Role
from heatlens.studio.share.page_message import parsed
from heatlens.studio.share.picture import Line, Picture
from heatlens.studio.share.shared import REST_S, SharedSession

VERSION = 1
_HELLO_S = 5.0  # time limit for the client's hello
_A_SECOND, _BURST = 200.0, 400.0  # messages that a client may send
_PART_S = 1.0
_STALLED_S = 20.0  # a client that accepts nothing for this long is gone
_STEP_S = 1 / 60  # shortest time between two messages of state to a client
_WIDTH_MOST = 16384
_NAME_MOST = 40
_PROBLEMS_MOST = 8


class Client:
    """Sends the newest state and picture to one client, one picture at a time."""

    def __init__(
        self,
        socket: web.WebSocketResponse,
        transport: asyncio.Transport | None,
        role: Role,
        number: int,
        shared: SharedSession,
    ) -> None:
        self.name = f"tablet {number}"
        self.role = role
        self.greeted = False
        self._socket = socket
        self._transport = transport
        self._shared = shared
        self._loop = asyncio.get_running_loop()
        self._news = asyncio.Event()
        self._line = Line()
        self._width = 1920
        self._sent: dict[str, object] = {}  # the state that the client has
        self._picture: Picture | None = None  # the latest picture that was sent
        self._sent_at = 0.0
        self._problems: deque[str] = deque(
            maxlen=_PROBLEMS_MOST
        )  # sentences that are still to be sent
        self.is_ready = False  # no picture is on its way
        self._allowed, self._spoke_at = _BURST, time.monotonic()

    def announce(self) -> None:
        """Note that there is something new to send."""
        self._news.set()

    async def serve(self, changed: Callable[[], None], log: Callable[[str], None]) -> None:
        """Greet the client, and serve it until it goes; `changed` is told when it can take more."""
        if not await self._greet():
            return
        where = self._transport.get_extra_info("peername") if self._transport else None
        log(f"{self.name} has come, from {where[0] if where else 'nowhere'}.")
        self.is_ready = self.greeted = True
        changed()
        self.announce()
        sending = asyncio.create_task(self._send_news())
        try:
            await self._listen(changed)
        finally:
            sending.cancel()

    async def _greet(self) -> bool:
        """Take the client's hello; return False if it speaks another version."""
        try:
            first = await asyncio.wait_for(self._socket.receive(), _HELLO_S)
        except TimeoutError:
            await self.part("Nothing was said.")
            return False
        try:
            hello = parsed(first.data) if first.type is WSMsgType.TEXT else {}
        except InputError:
            hello = {}
        if hello.get("hello") != VERSION:
            await self.part(f'A client begins with {{"hello": {VERSION}}}.')
            return False
        self._resized(hello.get("width_px"))
        name = hello.get("name")
        if isinstance(name, str) and name.isprintable() and 0 < len(name) <= _NAME_MOST:
            self.name = f"{name} ({self.name.split()[-1]})"
        await self._say({"hello": VERSION, "role": self.role, "you": self.name})
        return True

    async def part(self, why: str, code: int = 1008) -> None:
        """End the connection, and say why."""
        with suppress(TimeoutError, ConnectionError):
            await asyncio.wait_for(self._socket.close(code=code, message=why.encode()), _PART_S)

    # What it says

    async def _listen(self, changed: Callable[[], None]) -> None:
        async for message in self._socket:
            if message.type is not WSMsgType.TEXT:
                self._refuse("Messages to this server are text.")
                continue
            if not self._may_speak():
                await self.part(f"No more than {_A_SECOND:.0f} messages a second, please.")
                return
            try:
                self._hear(parsed(message.data), changed)
            except InputError as error:
                self._refuse(str(error))

    def _may_speak(self) -> bool:
        now = time.monotonic()
        self._allowed = min(self._allowed + (now - self._spoke_at) * _A_SECOND, _BURST) - 1.0
        self._spoke_at = now
        return self._allowed > 0

    def _hear(self, message: dict[str, object], changed: Callable[[], None]) -> None:
        if "got" in message:
            self._arrived(message["got"])
            changed()
        elif "width_px" in message:
            self._resized(message["width_px"])
            self._picture = None if self._picture and self._picture.is_whole else self._picture
            self._news.set()
        elif self.role is not Role.HAND:
            raise InputError("This link is only for watching: it cannot change the lens.")
        else:
            self._shared.ask(self.name, message, self._reply)

    def _arrived(self, number: object) -> None:
        if self._picture is None or self.is_ready or number != self._picture.number:
            return
        self.is_ready = True
        if not self._picture.is_whole:
            self._line.arrived(time.monotonic() - self._sent_at)
        self._news.set()

    def _resized(self, width: object) -> None:
        if isinstance(width, int) and not isinstance(width, bool):
            self._width = min(max(width, 16), _WIDTH_MOST)

    def _reply(self, sentence: str) -> None:
        """Send a sentence; the session's loop calls this from its own thread."""
        self._loop.call_soon_threadsafe(self._refuse, sentence)

    def _refuse(self, sentence: str) -> None:
        self._problems.append(sentence)
        self._news.set()

    # What it is sent

    # Nothing queues on the way to a client. The event is one bit, state is sent as its difference
    # from what the client has, and a picture is sent only once the one before is acknowledged. What
    # came between is skipped, so a slow line shows fewer pictures, each as new as it can be.
    async def _send_news(self) -> None:
        """Send what is new, as soon as the line takes it; nothing ever queues."""
        try:
            while True:
                await self._news.wait()
                self._news.clear()
                await asyncio.wait_for(self._send_newest(), _STALLED_S)
                await asyncio.sleep(_STEP_S)
        except (TimeoutError, ConnectionError):
            if self._transport is not None:
                self._transport.abort()  # a stalled connection takes no last message

    async def _send_newest(self) -> None:
        while self._problems:
            await self._say({"problem": self._problems.popleft()})
        await self._send_state({**self._shared.state, "hand": self._shared.hands.holder})
        picture = self._shared.picture
        if picture is not None and picture is not self._picture and self.is_ready:
            await self._send_picture(picture)

    async def _send_state(self, state: dict[str, object]) -> None:
        changes = {n: v for n, v in state.items() if n not in self._sent or self._sent[n] != v}
        changes |= {name: None for name in self._sent if name not in state}
        if not changes:
            return
        self._sent = state
        await self._say({"state": changes})
        if state["hand"]:
            self._loop.call_later(REST_S, self.announce)  # the picture at rest is news too

    async def _send_picture(self, picture: Picture) -> None:
        coding = self._line.coding(self._width, picture.is_whole)
        self.is_ready, self._picture = False, picture
        file = await self._loop.run_in_executor(None, picture.coded, coding)
        kind = "image/png" if coding.quality is None else "image/jpeg"
        head = {"picture": picture.number, "frame": picture.frame, "type": kind}
        head |= {"whole": picture.is_whole}
        self._sent_at = time.monotonic()
        await self._socket.send_bytes(json.dumps(head).encode() + b"\n" + file)

    async def _say(self, message: Mapping[str, object]) -> None:
        await self._socket.send_str(json.dumps(message))
