"""A bad network on the loopback: between server and robots, losing, delaying, reordering, holding back, recording."""

from __future__ import annotations

import asyncio
import random
import socket
import threading
from dataclasses import dataclass, field
from typing import cast


def free_ports(count: int) -> list[int]:
    """UDP ports of 127.0.0.1 that nobody has."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    try:
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]
    finally:
        for one in sockets:
            one.close()


@dataclass
class Weather:
    """What the network does to each datagram, in both directions."""

    loss: float = 0.0
    """Probability that it is lost."""
    delay: float = 0.0
    """Time on the way, s."""
    jitter: float = 0.0
    """Uniform time on top, s: more than the time between datagrams reorders them."""
    cut: bool = False
    holding: bool = False
    """Held back, to be let go later."""


@dataclass
class _Way(asyncio.DatagramProtocol):
    """One robot's port: what comes in goes to the robot, what the robot answers goes back to whoever spoke last."""

    network: BadNetwork
    robot: tuple[str, int]
    server: tuple[str, int] | None = None
    transport: asyncio.DatagramTransport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self.transport = cast(asyncio.DatagramTransport, transport)

    def datagram_received(self, data: bytes, addr: tuple[str, int]) -> None:
        if addr == self.robot:
            if self.server is not None:
                self.network.carry(self, data, self.server)
            return
        self.server = addr
        self.network.recorded.append((self.robot, data))
        self.network.carry(self, data, self.robot)


@dataclass
class BadNetwork:
    """Forwards from proxy ports to robots' ports in a thread of its own; a context manager."""

    ways: dict[int, int]
    """Robot's port by proxy port."""
    weather: Weather = field(default_factory=Weather)
    recorded: list[tuple[tuple[str, int], bytes]] = field(default_factory=list)
    """All that servers have sent: where to, and what."""

    def __enter__(self) -> BadNetwork:
        self._random = random.Random(6)
        self._held: list[tuple[_Way, bytes, tuple[str, int]]] = []
        self._loop = asyncio.new_event_loop()
        ready = threading.Event()

        async def listen() -> None:
            for port, robot in self.ways.items():
                way = _Way(self, ("127.0.0.1", robot))
                await self._loop.create_datagram_endpoint(lambda way=way: way, local_addr=("127.0.0.1", port))
            ready.set()

        def work() -> None:
            self._loop.create_task(listen())
            self._loop.run_forever()

        self._thread = threading.Thread(target=work, daemon=True)
        self._thread.start()
        assert ready.wait(5)
        return self

    def __exit__(self, *_: object) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(5)

    def carry(self, way: _Way, data: bytes, to: tuple[str, int]) -> None:
        weather = self.weather
        if weather.cut or self._random.random() < weather.loss:
            return
        if weather.holding:
            self._held.append((way, data, to))
            return
        self._loop.call_later(weather.delay + self._random.uniform(0, weather.jitter), self._deliver, way, data, to)

    def _deliver(self, way: _Way, data: bytes, to: tuple[str, int]) -> None:
        if way.transport is not None and not self.weather.cut:
            way.transport.sendto(data, to)

    def let_go(self) -> int:
        """Deliver all that was held back, in order; how many there were."""
        held, self._held = self._held, []
        for item in held:
            self._loop.call_soon_threadsafe(self._deliver, *item)
        return len(held)
