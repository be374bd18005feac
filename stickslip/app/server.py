"""The server of the workbench: for the browser of this machine, and for whom has the token."""

import secrets
import socket
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from http.cookies import SimpleCookie
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs

import uvicorn
from fastapi import FastAPI
from fastapi.responses import FileResponse, PlainTextResponse
from nicegui import app as pages
from nicegui import ui
from nicegui.translations import translations

from stickslip.app.pages import page
from stickslip.app.workbench import Workbench

RECONNECTS = 60.0  # time [s] without an answer after which a tab loses what was entered


class Guard:
    """Lets a request through that brings the token, in its address or as the cookie of it."""

    def __init__(self, app: Any, token: str, port: int) -> None:
        self.app, self._token, self._cookie = app, token, f"stickslip-{port}"
        self._origin = f"http://127.0.0.1:{port}"

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Answer 403 to any other request."""
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
            return
        headers = {name.decode(): text.decode("latin-1") for name, text in scope["headers"]}
        (given,) = parse_qs(scope["query_string"].decode()).get("token", [""])[:1]
        held = SimpleCookie(headers.get("cookie", "")).get(self._cookie)
        ours = headers.get("origin", self._origin) == self._origin
        tokens = filter(None, (given, held and held.value))
        if not (ours and any(secrets.compare_digest(one, self._token) for one in tokens)):
            refusal = PlainTextResponse("open the address that 'stickslip app' has printed", 403)
            if scope["type"] == "http":
                await refusal(scope, receive, send)
            else:
                await send({"type": "websocket.close", "code": 1008})
            return

        async def with_cookie(message: Any) -> None:
            if message["type"] == "http.response.start" and given:
                text = f"{self._cookie}={self._token}; Path=/; HttpOnly; SameSite=Lax"
                message["headers"] = [*message["headers"], (b"set-cookie", text.encode())]
            await send(message)

        await self.app(scope, receive, with_cookie)


def serve(folder: Path, port: int, announce: Callable[[str], object]) -> None:
    """Serve a folder's workbench until interrupted, at the address that is announced."""
    listener = socket.create_server(("127.0.0.1", port))
    port, token = listener.getsockname()[1], secrets.token_urlsafe(24)
    workbench, web = Workbench(folder), FastAPI(docs_url=None, redoc_url=None, openapi_url=None)

    @web.get("/files/{path:path}")
    def file(path: str) -> Any:
        """Return a file of the results."""
        found = (workbench.runs / path).resolve()
        if not found.is_relative_to(workbench.runs) or not found.is_file():
            return PlainTextResponse(f"{path}: there is no such file", 404)
        return FileResponse(found, headers={"Cache-Control": "no-cache"})

    for words in translations.values():
        words["connection_lost"] = "The server has gone."
        words["trying_to_reconnect"] = "Start 'stickslip app' again and open what it prints."
    ui.run_with(
        web,
        root=partial(page, workbench),
        title="stickslip",
        dark=None,
        show_welcome_message=False,
        reconnect_timeout=RECONNECTS,
    )
    pages.on_shutdown(workbench.close)
    announce(f"http://127.0.0.1:{port}/?token={token}")
    guarded = Guard(web, token, port)
    settings = uvicorn.Config(guarded, log_level="error", timeout_graceful_shutdown=1)
    with suppress(KeyboardInterrupt):
        uvicorn.Server(settings).run(sockets=[listener])
