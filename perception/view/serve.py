"""A small web server that shows the newest picture: `/` a page, `/stream.mjpg` moving pictures, `/newest.jpg`, `/newest.json`.

Every viewer gets the newest picture when it is ready for one: a slow one misses pictures and holds up nobody.
"""

from __future__ import annotations

import contextlib
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import cv2

from perception.errors import PerceptionInputError
from perception.view.lettering import Picture

VIEWERS_MAX = 8
_JPEG_QUALITY = 80
_VIEWER_TIMEOUT_S = 10.0
_BOUNDARY = "frame"
_PAGE = b"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>perception</title>
<style>body{margin:0;background:#1e1e1e;color:#ccc;font:14px sans-serif}img{max-width:100%;display:block}p{margin:8px}
a{color:#8cf}</style></head>
<body><img src="/stream.mjpg" alt="depth picture and top view">
<p><a href="/newest.jpg">newest picture</a>, <a href="/newest.json">newest discs as JSON</a></p></body></html>
"""


class LiveView:
    """Serves until closed. port 0: a free one. PerceptionInputError if it cannot listen there."""

    def __init__(self, host: str, port: int) -> None:
        self._newest = _Newest()
        try:
            self._server = _Server((host, port), self._newest)
        except (OSError, OverflowError) as error:
            raise PerceptionInputError(
                f"--serve = {port}: cannot listen on {host}:{port}: {error}; a free port of this computer is wanted"
            ) from None
        self.address = f"http://{host}:{self._server.server_address[1]}/"
        self._thread = threading.Thread(target=self._server.serve_forever, args=(0.1,), name="live-view", daemon=True)
        self._thread.start()

    def show(self, picture: Picture, row: str) -> None:
        """row: the same frame as JSON. Returns at once."""
        self._newest.put(picture, row)

    def close(self) -> None:
        self._newest.close()
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()


class _Newest:
    """The newest picture, encoded once however many look at it, and only if somebody does."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._encoding = threading.Lock()
        self._picture: Picture | None = None
        self._row = ""
        self._number = 0
        self._encoded = (0, b"")
        self.is_closed = False

    def put(self, picture: Picture, row: str) -> None:
        with self._changed:
            self._picture, self._row = picture, row
            self._number += 1
            self._changed.notify_all()

    def close(self) -> None:
        with self._changed:
            self.is_closed = True
            self._changed.notify_all()

    def row(self) -> bytes:
        return self._row.encode()

    def jpeg_after(self, number: int) -> tuple[int, bytes] | None:
        """Number and JPEG of the newest picture, waiting for one newer than `number`; None at the end."""
        with self._changed:
            self._changed.wait_for(lambda: self._number > number or self.is_closed)
            if self.is_closed:
                return None
        with self._encoding:
            with self._changed:
                newest, picture = self._number, self._picture
            if self._encoded[0] != newest and picture is not None:
                jpeg = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[1].tobytes()
                self._encoded = (newest, jpeg)
            return self._encoded


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def __init__(self, address: tuple[str, int], newest: _Newest) -> None:
        self.newest = newest
        self.places = threading.BoundedSemaphore(VIEWERS_MAX)
        super().__init__(address, _Handler)

    def handle_error(self, request: object, client_address: object) -> None:
        """A viewer that goes away in the middle of a picture is no news."""


class _Handler(BaseHTTPRequestHandler):
    server: _Server
    timeout = _VIEWER_TIMEOUT_S

    def do_GET(self) -> None:
        path = self.path.partition("?")[0]
        if path == "/":
            self._answer(_PAGE, "text/html; charset=utf-8")
        elif path in ("/stream.mjpg", "/newest.jpg"):
            if not self.server.places.acquire(blocking=False):
                self.send_error(HTTPStatus.SERVICE_UNAVAILABLE, f"{VIEWERS_MAX} viewers are watching already")
                return
            try:
                self._one_picture() if path == "/newest.jpg" else self._stream()
            finally:
                self.server.places.release()
        elif path == "/newest.json":
            self._answer(self.server.newest.row() or b"{}", "application/json")
        else:
            self.send_error(HTTPStatus.NOT_FOUND, "there are /, /stream.mjpg, /newest.jpg and /newest.json")

    def log_message(self, format: str, *args: object) -> None:
        """The terminal belongs to the view."""

    def _one_picture(self) -> None:
        newest = self.server.newest.jpeg_after(0)
        if newest is None:
            self.send_error(HTTPStatus.SERVICE_UNAVAILABLE, "the view has ended")
        else:
            self._answer(newest[1], "image/jpeg")

    def _stream(self) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", f"multipart/x-mixed-replace; boundary={_BOUNDARY}")
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        number = 0
        with contextlib.suppress(OSError):
            while (newest := self.server.newest.jpeg_after(number)) is not None:
                number, jpeg = newest
                head = f"--{_BOUNDARY}\r\nContent-Type: image/jpeg\r\nContent-Length: {len(jpeg)}\r\n\r\n"
                self.wfile.write(head.encode() + jpeg + b"\r\n")
            self.wfile.write(f"--{_BOUNDARY}--\r\n".encode())
        self.close_connection = True

    def _answer(self, body: bytes, kind: str) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)
