"""A shared session and the clients that talk to it, all on loopback."""

import asyncio
import json
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from io import BytesIO
from threading import Event

import aiohttp
import numpy as np
from PIL import Image

from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.studio.share.address import Address, Role, new_links
from heatlens.studio.share.client import PROTOCOL_VERSION
from heatlens.studio.share.headless import HeadlessLoop
from heatlens.studio.share.server import ShareServer
from heatlens.studio.share.shared import SharedSession
from support.patience import PATIENCE_S


def start_server(
    shared: SharedSession, log: Callable[[str], None] = lambda line: None
) -> ShareServer:
    """Start a share server on a free port and return it."""
    server = ShareServer(address=Address(port=0), links=new_links(), shared=shared, log=log)
    server.start()
    return server


class Peer:
    """A client that stores the newest state, the pictures and the messages that it receives."""

    def __init__(self, socket: aiohttp.ClientWebSocketResponse) -> None:
        self.socket = socket
        self.state: dict[str, object] = {}
        self.hello: dict[str, object] = {}
        self.problems: list[str] = []
        self.heads: list[dict] = []
        self.files: list[bytes] = []
        self.acknowledges = True
        self.end: int | None = None

    async def listen(self) -> None:
        """Read until the connection closes."""
        async for message in self.socket:
            if message.type is aiohttp.WSMsgType.TEXT:
                self._hear(json.loads(message.data))
            else:
                head, _, file = message.data.partition(b"\n")
                self.heads.append(json.loads(head))
                self.files.append(file)
                if self.acknowledges:
                    await self.socket.send_json({"got": self.heads[-1]["picture"]})
        self.end = self.socket.close_code

    def _hear(self, message: dict) -> None:
        self.hello = message if "hello" in message else self.hello
        self.state |= message.get("state", {})
        self.problems += [message["problem"]] if "problem" in message else []

    @property
    def pixels(self) -> np.ndarray:
        """The newest picture, (H, W, 3)."""
        return np.asarray(Image.open(BytesIO(self.files[-1])).convert("RGB"))

    async def send(self, **message: object) -> None:
        await self.socket.send_json(message)


@asynccontextmanager
async def connected_peer(
    server: ShareServer, role: Role = Role.HAND, **hello: object
) -> AsyncIterator[Peer]:
    """Connect a client to the server and send its hello message."""
    async with aiohttp.ClientSession() as web:
        async with web.ws_connect(f"{server.link(role)}socket", max_msg_size=0) as socket:
            it = Peer(socket)
            listening = asyncio.create_task(it.listen())
            await socket.send_json({"hello": PROTOCOL_VERSION} | hello)
            try:
                yield it
            finally:
                listening.cancel()


async def wait_for_condition(
    condition: Callable[[], object], label: str, turn: Callable[[], None] = lambda: None
):
    """Wait until `condition()` is true; call `turn` again and again meanwhile."""
    end = asyncio.get_running_loop().time() + PATIENCE_S
    while not condition():
        assert asyncio.get_running_loop().time() < end, f"{label} never came"
        turn()
        await asyncio.sleep(0.002)


def with_session(
    session, screen: ScreenPictures, play: Callable[[HeadlessLoop, ShareServer], Awaitable[None]]
) -> None:
    """Share a session, run `play` with its loop and server, and end the sharing."""
    shared = SharedSession()
    loop, server = HeadlessLoop(session, screen, shared, Event()), start_server(shared)
    try:
        asyncio.run(play(loop, server))
    finally:
        server.close()
