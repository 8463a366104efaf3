"""The live page and the commands behind it, over HTTP on this machine.

``POST /estop`` is open to whoever reaches the port: a stop must never be refused. Everything that can lead to motion needs the
session's token and a Host header that names this machine, so that no other page in the operator's browser can send it.
"""

from __future__ import annotations

import asyncio
import json
import secrets
from collections.abc import Awaitable, Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from aiohttp import web

from hero_robot.fleet.coordinator import START_DELAY
from hero_robot.fleet.delivery import Outcome
from hero_robot.fleet.errors import FleetError
from hero_robot.fleet.server import FleetServer

REFRESH = 0.1
"""Time between two pictures of the fleet, s."""

PRESS_LENGTH = 64
"""Characters of a press's name that count."""

TOKEN_HEADER = "X-Fleet-Token"
PAGE = Path(__file__).with_name("page.html")

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class FleetPage:
    """Serves a fleet's page.

    Args:
        server: The fleet.
        host: Address to listen on; 127.0.0.1 unless the operator knows why not.
        port: TCP port; 0 takes a free one.
    """

    def __init__(self, server: FleetServer, host: str = "127.0.0.1", port: int = 8080) -> None:
        self.server, self.host, self.port = server, host, port
        self.token = secrets.token_urlsafe(24)
        self._runner: web.AppRunner | None = None

    async def open(self) -> None:
        """Begin to serve.

        Raises:
            FleetError: When the port is taken.
        """
        app = web.Application(middlewares=[self._guard], client_max_size=65536)
        app.router.add_get("/", self._page)
        app.router.add_get("/status", self._status)
        app.router.add_get("/events", self._events)
        app.router.add_post("/estop", self._estop)
        for name, command in {
            "rearm": self._rearm,
            "hold": self._hold,
            "start": self._start,
            "update": self._update,
            "poses": self._poses,
        }.items():
            app.router.add_post(f"/{name}", command)
        self._runner = web.AppRunner(app, access_log=None, shutdown_timeout=0.2)
        await self._runner.setup()
        site = web.TCPSite(self._runner, self.host, self.port)
        try:
            await site.start()
        except OSError as error:
            raise FleetError(f"the page cannot listen on {self.host}:{self.port} ({error.strerror}); give another --page-port") from None
        self.port = self._runner.addresses[0][1]

    async def close(self) -> None:
        """Stop serving."""
        if self._runner is not None:
            await self._runner.cleanup()

    @property
    def url(self) -> str:
        """Where the page is."""
        return f"http://{self.host}:{self.port}"

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Check Host and token, and turn mistakes into one line of JSON."""
        stop = request.method == "POST" and request.path == "/estop"
        if not stop and request.host.rsplit(":", 1)[0] not in {"127.0.0.1", "localhost", self.host}:
            return _refuse(403, f"host {request.host!r} is not this server; open {self.url}")
        token = request.headers.get(TOKEN_HEADER, "").encode()
        if request.method == "POST" and not stop and not secrets.compare_digest(token, self.token.encode()):
            return _refuse(403, "this page belongs to an earlier server; reload it (the stop button works all the same)")
        try:
            return await handler(request)
        except FleetError as error:
            return _refuse(409, str(error))

    async def _page(self, request: web.Request) -> web.Response:
        text = PAGE.read_text(encoding="utf-8").replace("@TOKEN@", self.token)
        return web.Response(text=text, content_type="text/html", headers={"X-Frame-Options": "DENY", "Cache-Control": "no-store"})

    async def _status(self, request: web.Request) -> web.Response:
        return web.json_response(self.server.snapshot())

    async def _events(self, request: web.Request) -> web.StreamResponse:
        response = web.StreamResponse(headers={"Content-Type": "text/event-stream", "Cache-Control": "no-store"})
        await response.prepare(request)
        try:
            while True:
                await response.write(f"data: {json.dumps(self.server.snapshot())}\n\n".encode())
                await asyncio.sleep(REFRESH)
        except ConnectionError:
            return response

    async def _estop(self, request: web.Request) -> web.Response:
        self.server.estop(request.query.get("press", "")[:PRESS_LENGTH] or None)
        return web.json_response({"outcomes": []})

    async def _rearm(self, request: web.Request) -> web.Response:
        return _answer(await self.server.rearm())

    async def _hold(self, request: web.Request) -> web.Response:
        return _answer(await self.server.hold())

    async def _start(self, request: web.Request) -> web.Response:
        body = await _body(request)
        return _answer(await self.server.start(_number(body.get("delay", START_DELAY), "delay")))

    async def _update(self, request: web.Request) -> web.Response:
        body = await _body(request)
        given = body.get("controllers")
        if not isinstance(given, dict) or not all(isinstance(genes, list) and len(genes) == 4 for genes in given.values()):
            raise FleetError("update: expected {'controllers': {robot: [v0, w0, v1, w1]}}")
        controllers = {}
        for name, genes in given.items():
            v0, w0, v1, w1 = (_number(gene, f"controller of {name}") for gene in genes)
            controllers[str(name)] = (v0, w0, v1, w1)
        return _answer(await self.server.update(controllers))

    async def _poses(self, request: web.Request) -> web.Response:
        body = await _body(request)
        poses = body.get("poses")
        if not isinstance(poses, list) or not all(isinstance(pose, dict) and isinstance(pose.get("robot"), str) for pose in poses):
            raise FleetError("poses: expected {'poses': [{robot, x, y, theta, age}]}")
        for pose in poses:
            x, y, theta = (_number(pose.get(name), name) for name in ("x", "y", "theta"))
            self.server.pose(pose["robot"], x, y, theta, _number(pose.get("age", 0.0), "age"))
        return web.json_response({"taken": len(poses)})


async def _body(request: web.Request) -> dict[str, Any]:
    text = await request.text()
    try:
        body = json.loads(text) if text else {}
    except json.JSONDecodeError as error:
        raise FleetError(f"{request.path}: not valid JSON ({error.msg})") from None
    if not isinstance(body, dict):
        raise FleetError(f"{request.path}: given a {type(body).__name__}, expected an object")
    return body


def _number(value: Any, what: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise FleetError(f"{what}: given {value!r}, expected a number")
    return float(value)


def _answer(outcomes: list[Outcome]) -> web.Response:
    return web.json_response({"outcomes": [asdict(outcome) for outcome in outcomes]})


def _refuse(status: int, reason: str) -> web.Response:
    return web.json_response({"error": reason}, status=status)
