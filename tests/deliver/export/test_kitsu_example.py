"""Run the manual's Kitsu example after an export, against a server that answers like Kitsu."""

import json
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from threading import Thread

from heatlens.fronts.commands.main import main
from support.exports import write_plates
from support.manual import page


class KitsuHandler(BaseHTTPRequestHandler):
    """Answer requests like Kitsu with one project, shot and task; store the posted comments."""

    comments: list[dict[str, object]] = []  # noqa: RUF012 - of a class that a test makes

    def answer(self, value: object) -> None:
        body = json.dumps(value).encode()
        self.send_response(200)
        self.send_header("Content-Type", "application/json")
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def do_GET(self) -> None:
        thing = {"id": "1", "name": "main", "project_id": "1", "type": "Shot"}
        is_list = "?" in self.path or self.path.endswith(("tasks", "shots", "sequences"))
        self.answer([thing] if is_list else thing)

    def do_POST(self) -> None:
        body = self.rfile.read(int(self.headers["Content-Length"])).decode(errors="replace")
        if "login" in self.path:
            self.answer({"login": True, "access_token": "t", "refresh_token": "r", "user": {}})
            return
        self.comments.append({"path": self.path, "body": body})
        self.answer({"id": "2"})

    def log_message(self, *args: object) -> None:
        """Print no log messages."""


@contextmanager
def kitsu_server() -> Iterator[tuple[str, list[dict[str, object]]]]:
    handler = type("OneKitsu", (KitsuHandler,), {"comments": []})
    server = ThreadingHTTPServer(("127.0.0.1", 0), handler)
    thread = Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/api", handler.comments
    finally:
        server.shutdown()
        server.server_close()
        thread.join()


def test_kitsu_example_of_manual_posts_comment_with_frames(tmp_path):
    (example,) = re.findall(r"```python\n(import json, sys\n.*?)```", page("edit"), re.DOTALL)
    source, out = write_plates(tmp_path / "p"), tmp_path / "sh010.####.exr"
    with kitsu_server() as (address, comments):
        script = tmp_path / "publish.py"
        script.write_text(example.replace("https://kitsu.example.com/api", address))
        words = ("--f-stop", "2", "--focus-distance", "2", "--quality", "draft", "--frames", "1001")
        after = f"'{sys.executable}' '{script}'"
        code = main(["export", source, "-o", str(out), *words, "--after-export", after])
    assert code == 0
    assert len(comments) == 1 and "comment" in str(comments[0]["path"])
    assert f"1 frames: {tmp_path}/sh010.1001.exr" in str(comments[0]["body"])
