"""The annotation page over HTTP, on this machine."""

from __future__ import annotations

import asyncio
import json
import secrets
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

from aiohttp import web

from discovery.annotation.answers import KINDS, Answers, question
from discovery.annotation.clips import Clips
from discovery.errors import DiscoveryError
from discovery.report.animation import describe_scene, pack_rollout

EVERY = 2
"""Ticks between the frames that are shown."""
HERE = Path(__file__).parent
TOKEN_HEADER = "X-Annotation-Token"


class AnnotationPage:
    """Asks, and writes down what is answered.

    Args:
        clips: What is asked about.
        answers: Where answers go.
        wanted: How many.
        seed: Of the questions.
    """

    def __init__(self, clips: Clips, answers: Answers, wanted: int, seed: int) -> None:
        self.clips, self.answers, self.wanted, self.seed = clips, answers, wanted, seed
        self.token = secrets.token_urlsafe(24)
        self.ended = asyncio.Event()
        """Set when everything is answered; whoever wants to stop sets it, too."""
        self._runner: web.AppRunner | None = None
        self._prepared: dict[int, asyncio.Future[dict[str, Any]]] = {}
        """Clips of the question asked and of the next one, by number, simulated while the person looks."""

    async def open(self, port: int) -> str:
        """Begin to serve; returns the address.

        Raises:
            DiscoveryError: When the port is taken.
        """
        app = web.Application(middlewares=[self._guard], client_max_size=4096)
        app.router.add_get("/", self._page)
        app.router.add_get("/question", self._question)
        app.router.add_post("/answer", self._answer)
        app.router.add_post("/undo", self._undo)
        self._runner = web.AppRunner(app, access_log=None, shutdown_timeout=0.5)
        await self._runner.setup()
        try:
            await web.TCPSite(self._runner, "127.0.0.1", port).start()
        except OSError as error:
            raise DiscoveryError(f"the page cannot listen on port {port} ({error.strerror}); give another --port") from None
        return f"http://127.0.0.1:{self._runner.addresses[0][1]}"

    async def close(self) -> None:
        """Stop serving."""
        if self._runner is not None:
            await self._runner.cleanup()

    @web.middleware
    async def _guard(self, request: web.Request, handler: Callable[[web.Request], Awaitable[web.StreamResponse]]) -> web.StreamResponse:
        """Keep other pages in the browser from answering, and turn mistakes into one line of JSON."""
        if request.host.rsplit(":", 1)[0] not in {"127.0.0.1", "localhost"}:
            return web.json_response({"error": f"host {request.host!r} is not this server"}, status=403)
        if request.method == "POST" and not secrets.compare_digest(request.headers.get(TOKEN_HEADER, "").encode(), self.token.encode()):
            return web.json_response({"error": "this page belongs to an earlier server; reload it"}, status=403)
        try:
            return await handler(request)
        except DiscoveryError as error:
            return web.json_response({"error": str(error)}, status=409)

    async def _page(self, request: web.Request) -> web.Response:
        drawing = (HERE.parent / "report" / "rollout.js").read_text(encoding="utf-8")
        style = (HERE.parent / "report" / "style.css").read_text(encoding="utf-8")
        page = (HERE / "page.html").read_text(encoding="utf-8")
        for mark, text in {"@STYLE@": style, "@DRAWING@": drawing, "@TOKEN@": self.token}.items():
            page = page.replace(mark, text)
        return web.Response(text=page, content_type="text/html", headers={"X-Frame-Options": "DENY", "Cache-Control": "no-store"})

    async def _question(self, request: web.Request) -> web.Response:
        number = len(self.answers.given)
        asked: dict[str, Any] = {
            "kind": self.answers.kind, "number": number, "wanted": self.wanted, "options": KINDS[self.answers.kind],
            "path": str(self.answers.path),
        }  # fmt: skip
        if number >= self.wanted:
            return web.json_response(asked | {"rollouts": []})
        return web.json_response(asked | await self._prepare(number))

    def _prepare(self, number: int) -> asyncio.Future[dict[str, Any]]:
        """Return the clips of a question that is asked now, and begin with those of the one after it; others are forgotten."""
        loop, wanted = asyncio.get_running_loop(), [each for each in (number, number + 1) if each < self.wanted]
        self._prepared = {each: self._prepared.get(each) or loop.run_in_executor(None, self._simulate, each) for each in wanted}
        return self._prepared[number]

    def _simulate(self, number: int) -> dict[str, Any]:
        """Simulate and pack the clips of a question."""
        rollouts = [self.clips.rollout(row) for row in question(self.answers.kind, len(self.clips), number, self.seed)]
        return {"scene": describe_scene(rollouts[0], EVERY), "rollouts": [pack_rollout(rollout, EVERY) for rollout in rollouts]}

    async def _answer(self, request: web.Request) -> web.Response:
        try:
            body = json.loads(await request.text())
            number, answer = body["number"], body["answer"]
        except (ValueError, KeyError, TypeError):
            raise DiscoveryError('answer: expected {"number": N, "answer": TEXT}') from None
        if number != len(self.answers.given) or number >= self.wanted:
            raise DiscoveryError(f"question {number} is not the one asked, which is {len(self.answers.given)}; reload the page")
        self.answers.add(question(self.answers.kind, len(self.clips), number, self.seed), answer)
        if len(self.answers.given) >= self.wanted:
            self.ended.set()
        return web.json_response({"number": len(self.answers.given)})

    async def _undo(self, request: web.Request) -> web.Response:
        self.answers.undo()
        return web.json_response({"number": len(self.answers.given)})
