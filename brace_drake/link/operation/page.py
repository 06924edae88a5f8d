"""A page in the browser that follows along."""

from __future__ import annotations

import http.server
import json
import threading
from pathlib import Path

from brace_drake.core.errors import OutputError

_PAGE = Path(__file__).with_name("page.html")


class Page:
    """A server of one page and its events.

    Attributes:
        url: Where it is.
    """

    def __init__(self, host: str = "127.0.0.1", port: int = 0):
        """Begins to serve.

        Args:
            host: Address to listen on; the loopback one lets nobody else in.
            port: 0 for any free one.

        Raises:
            OutputError: The address or port cannot be used.
        """
        self._news, self._text = threading.Condition(), "{}"
        self._number, self._closed = 0, False
        try:
            self._server = http.server.ThreadingHTTPServer(
                (host, port), self._MakeHandler()
            )
        except OSError as error:
            raise OutputError(f"{host}:{port}: {error.strerror}") from error
        self._server.daemon_threads = True
        self.url = "http://{}:{}/".format(*self._server.server_address[:2])
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    def Show(self, content: dict) -> None:
        """Sends new content to whoever looks."""
        with self._news:
            self._text = json.dumps(content)
            self._number += 1
            self._news.notify_all()

    def __enter__(self) -> Page:
        return self

    def __exit__(self, *_) -> None:
        self.Close()

    def Close(self) -> None:
        """Ends the server."""
        with self._news:
            self._closed = True
            self._news.notify_all()
        self._server.shutdown()
        self._server.server_close()

    def _Next(self, seen: int) -> tuple[int, str] | None:
        with self._news:
            self._news.wait_for(
                lambda: self._closed or self._number > seen, 5.0
            )
            return None if self._closed else (self._number, self._text)

    def _MakeHandler(page):
        class Handler(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                if self.path == "/":
                    self._Answer("text/html; charset=utf-8")
                elif self.path == "/events":
                    self._Stream()
                else:
                    self.send_error(404)

            def _Answer(self, kind):
                data = _PAGE.read_bytes()
                self.send_response(200)
                self.send_header("Content-Type", kind)
                self.send_header("Content-Length", str(len(data)))
                self.end_headers()
                self.wfile.write(data)

            def _Stream(self):
                self.send_response(200)
                self.send_header("Content-Type", "text/event-stream")
                self.end_headers()
                seen = 0
                try:
                    while (found := page._Next(seen)) is not None:
                        seen, text = found
                        self.wfile.write(f"data: {text}\n\n".encode())
                except OSError:
                    return

            def log_message(self, *_):
                pass

        return Handler
