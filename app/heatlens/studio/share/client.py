"""Serve one connected page or program: send it state and pictures, and follow its messages."""

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
from heatlens.studio.share.picture import ConnectionSpeed, Picture
from heatlens.studio.share.shared import REST_S, SharedSession

PROTOCOL_VERSION = 1
_HELLO_S = 5.0  # time limit for the client's hello
_MESSAGES_PER_SECOND, _MESSAGE_BURST = 200.0, 400.0  # messages that a client may send
_CLOSE_S = 1.0
_STALLED_S = 20.0  # a client that accepts nothing for this long is gone
_SEND_INTERVAL_S = 1 / 60  # shortest time between two messages of state to a client
_MOST_WIDTH = 16384
_MOST_NAME_LETTERS = 40
_MOST_PROBLEMS = 8


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
        self.is_greeted = False
        self._socket = socket
        self._transport = transport
        self._shared = shared
        self._loop = asyncio.get_running_loop()
        self._has_news = asyncio.Event()
        self._connection_speed = ConnectionSpeed()
        self._width = 1920
        self._sent_state: dict[str, object] = {}  # the state that the client has
        self._sent_picture: Picture | None = None  # the latest picture that was sent
        self._is_resized = False  # True if the client needs that picture again at another width
        self._sent_at = 0.0
        self._problems: deque[str] = deque(maxlen=_MOST_PROBLEMS)  # messages still to be sent
        self.is_ready = False  # True while no picture is on its way
        self._message_allowance, self._last_message_s = _MESSAGE_BURST, time.monotonic()

    def wake(self) -> None:
        """Note that there is something new to send."""
        self._has_news.set()

    async def serve(self, report_change: Callable[[], None], log: Callable[[str], None]) -> None:
        """Greet the client, and serve it until it goes.

        `report_change` is called when the client has come, and when it can take another picture.
        """
        if not await self._greet():
            return
        peer = self._transport.get_extra_info("peername") if self._transport else None
        log(f"{self.name} has come, from {peer[0] if peer else 'nowhere'}.")
        self.is_ready = self.is_greeted = True
        report_change()
        self.wake()
        sending = asyncio.create_task(self._send_news())
        try:
            await self._listen(report_change)
        finally:
            sending.cancel()

    async def _greet(self) -> bool:
        """Receive the client's hello; disconnect and return False if it has another version."""
        try:
            first_message = await asyncio.wait_for(self._socket.receive(), _HELLO_S)
        except TimeoutError:
            await self.disconnect("Nothing was said.")
            return False
        try:
            hello = parsed(first_message.data) if first_message.type is WSMsgType.TEXT else {}
        except InputError:
            hello = {}
        if hello.get("hello") != PROTOCOL_VERSION:
            await self.disconnect(f'A client begins with {{"hello": {PROTOCOL_VERSION}}}.')
            return False
        self._set_width(hello.get("width_px"))
        name = hello.get("name")
        if isinstance(name, str) and name.isprintable() and 0 < len(name) <= _MOST_NAME_LETTERS:
            self.name = f"{name} ({self.name.split()[-1]})"
        await self._send_json({"hello": PROTOCOL_VERSION, "role": self.role, "you": self.name})
        return True

    async def disconnect(self, reason: str, code: int = 1008) -> None:
        """End the connection, and say why."""
        with suppress(TimeoutError, ConnectionError):
            await asyncio.wait_for(self._socket.close(code=code, message=reason.encode()), _CLOSE_S)

    # Messages of the client

    async def _listen(self, report_change: Callable[[], None]) -> None:
        """Follow the messages of the client until it goes or sends too many."""
        async for message in self._socket:
            if message.type is not WSMsgType.TEXT:
                self._send_problem("Messages to this server are text.")
                continue
            if not self._is_within_rate():
                await self.disconnect(
                    f"No more than {_MESSAGES_PER_SECOND:.0f} messages a second, please."
                )
                return
            try:
                self._follow_message(parsed(message.data), report_change)
            except InputError as error:
                self._send_problem(str(error))

    def _is_within_rate(self) -> bool:
        """Count a message; return False if the client sends too many (a token bucket)."""
        now = time.monotonic()
        self._message_allowance = (
            min(
                self._message_allowance + (now - self._last_message_s) * _MESSAGES_PER_SECOND,
                _MESSAGE_BURST,
            )
            - 1.0
        )
        self._last_message_s = now
        return self._message_allowance > 0

    def _follow_message(
        self, message: dict[str, object], report_change: Callable[[], None]
    ) -> None:
        """Follow one message. Raises InputError if the client may not send it."""
        if "got" in message:
            self._note_acknowledged(message["got"])
            report_change()
        elif "width_px" in message:
            self._set_width(message["width_px"])
            self._is_resized = self._sent_picture is not None and self._sent_picture.is_whole
            self._has_news.set()
        elif self.role is not Role.HAND:
            raise InputError("This link is only for watching: it cannot change the lens.")
        else:
            self._shared.queue_message(self.name, message, self._reply)

    def _note_acknowledged(self, number: object) -> None:
        """Note that the client has received the picture of this number."""
        if self._sent_picture is None or self.is_ready or number != self._sent_picture.number:
            return
        self.is_ready = True
        if not self._sent_picture.is_whole:
            self._connection_speed.note_round_trip(time.monotonic() - self._sent_at)
        self._has_news.set()

    def _set_width(self, width: object) -> None:
        """Set the width in pixels at which the client shows pictures; ignore invalid values."""
        if isinstance(width, int) and not isinstance(width, bool):
            self._width = min(max(width, 16), _MOST_WIDTH)

    def _reply(self, message: str) -> None:
        """Queue a problem message; the session's loop calls this from its own thread."""
        self._loop.call_soon_threadsafe(self._send_problem, message)

    def _send_problem(self, message: str) -> None:
        """Queue a problem message for the client."""
        self._problems.append(message)
        self._has_news.set()

    # Messages to the client

    # No state or picture queues on the way to a client. The event is one bit, state is sent as its
    # difference from the state that the client has, and a picture is sent only once the one before
    # is acknowledged. Pictures in between are skipped: a slow connection shows fewer pictures, each
    # as new as it can be.
    async def _send_news(self) -> None:
        """Send new problems, state and pictures as soon as the connection takes them."""
        try:
            while True:
                await self._has_news.wait()
                self._has_news.clear()
                await asyncio.wait_for(self._send_newest(), _STALLED_S)
                await asyncio.sleep(_SEND_INTERVAL_S)
        except (TimeoutError, ConnectionError):
            if self._transport is not None:
                self._transport.abort()  # a stalled connection takes no last message

    # The picture is read before the state. The loop may publish both while the state is being sent,
    # and the client would get a picture of a lens that it has not been told.
    async def _send_newest(self) -> None:
        """Send all problems, the changes of the state, and the newest picture if it is due."""
        while self._problems:
            await self._send_json({"problem": self._problems.popleft()})
        picture = self._shared.picture
        await self._send_state({**self._shared.state, "hand": self._shared.hands.holder})
        is_due = self._is_resized or picture is not self._sent_picture
        if picture is not None and is_due and self.is_ready:
            await self._send_picture(picture)

    async def _send_state(self, state: dict[str, object]) -> None:
        """Send the entries of the state that differ from those that the client has."""
        changes = {
            name: value
            for name, value in state.items()
            if name not in self._sent_state or self._sent_state[name] != value
        }
        changes |= {name: None for name in self._sent_state if name not in state}
        if not changes:
            return
        self._sent_state = state
        await self._send_json({"state": changes})
        if state["hand"]:
            self._loop.call_later(REST_S, self.wake)  # the picture at rest is news too

    async def _send_picture(self, picture: Picture) -> None:
        """Send a picture: a line of JSON, then the bytes of a PNG or JPEG file."""
        coding = self._connection_speed.coding(self._width, picture.is_whole)
        self.is_ready, self._is_resized, self._sent_picture = False, False, picture
        file = await self._loop.run_in_executor(None, picture.encode, coding)
        kind = "image/png" if coding.quality is None else "image/jpeg"
        header = {"picture": picture.number, "frame": picture.frame, "type": kind}
        header |= {"whole": picture.is_whole, "lens_number": picture.lens_number}
        self._sent_at = time.monotonic()
        await self._socket.send_bytes(json.dumps(header).encode() + b"\n" + file)

    async def _send_json(self, message: Mapping[str, object]) -> None:
        await self._socket.send_str(json.dumps(message))
