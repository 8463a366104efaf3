"""Command line of a fleet: ``python -m hero_robot.fleet COMMAND FLEET_FILE ...``."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import os
import signal
import sys
import urllib.error
import urllib.request
from pathlib import Path
from typing import Any

from hero_robot.fleet.controller_file import read_controller
from hero_robot.fleet.errors import FleetError
from hero_robot.fleet.fleet_file import Fleet, link_constants, read_fleet, secrets_header, write_new_fleet

TOKEN_HEADER = "X-Fleet-Token"


def session_path(fleet_file: Path) -> Path:
    """Where a running server leaves its address and token, for its owner alone."""
    return fleet_file.with_suffix(".session")


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; 0 when it was done, 1 when a robot refused, 2 for a mistake."""
    given = _parser().parse_args(arguments)
    try:
        return int(given.function(given))
    except FleetError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
    except BrokenPipeError:  # the reader of our output has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # Python flushes it as it ends
        return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="swarm-fleet", description="A fleet of HeRo+ robots on the lab's network.")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")

    def add(name: str, function: Any, what: str) -> argparse.ArgumentParser:
        command = commands.add_parser(name, help=what, description=what)
        command.add_argument("fleet", type=Path, help="fleet file")
        command.set_defaults(function=function)
        return command

    keys = add("keys", _keys, "write a new fleet file with fresh keys")
    keys.add_argument("robots", type=int, help="number of robots")
    keys.add_argument("--hosts", default="", help="their addresses, with commas; default: simulated on this machine")
    port = link_constants()["port"]
    keys.add_argument("--port", type=int, default=port, help=f"UDP port of the robots, {port}; simulated ones count up from it")
    keys.add_argument("--page-port", type=int, default=8080)
    secret = add("secrets", _secrets, "print the secrets.h of a robot's board")
    secret.add_argument("robot")
    secret.add_argument("--wifi", required=True, help="name of the lab's network; its password is read from standard input")
    serve = add("serve", _serve, "run the server and the live page")
    serve.add_argument("--log", type=Path, help="folder for the runs, in the format that calibration reads")
    serve.add_argument("--page-port", type=int, help="TCP port of the page instead of the fleet file's")
    serve.add_argument("--host", default="127.0.0.1", help="address of the page")
    serve.add_argument("--simulate", action="store_true", help="run the fleet's robots on this machine as well")
    simulate = add("simulate", _simulate, "run the fleet's robots on this machine, each the firmware itself")
    simulate.add_argument("--sees", type=float, default=0.0, help="something stands before each robot half of this period, s")
    add("status", _status, "print the state of each robot")
    for name, what in [
        ("estop", "stop every robot now, and latch"),
        ("rearm", "release the emergency stop; robots are in HOLD afterwards"),
        ("hold", "take every robot to HOLD"),
    ]:
        add(name, _post, what).set_defaults(path=name)
    start = add("start", _start, "start every robot at the same time")
    start.add_argument("--delay", type=float, default=0.6, help="s from now")
    update = add("update", _update, "load a controller on every robot, or on one")
    update.add_argument("genes", type=float, nargs=4, metavar=("V0", "W0", "V1", "W1"), help="m/s and rad/s")
    load = add("load", _load, "load the controller of a file on every robot, or on one")
    load.add_argument("file", type=Path, help="a controller update file, from python -m discovery.export")
    for one in (update, load):
        one.add_argument("--robot", help="this one alone")
    return parser


# --- commands that need no server -------------------------------------------------------------------------------------


def _keys(given: argparse.Namespace) -> int:
    if not 1 <= given.robots <= 1000:
        raise FleetError(f"{given.robots} robots; expected 1 to 1000")
    hosts = given.hosts.split(",") if given.hosts else ["127.0.0.1"] * given.robots
    if len(hosts) != given.robots:
        raise FleetError(f"{len(hosts)} addresses for {given.robots} robots; give one for each")
    ports = [given.port] * given.robots if given.hosts else list(range(given.port, given.port + given.robots))
    write_new_fleet(given.fleet, hosts, ports, given.page_port)
    print(f"wrote {given.fleet}: keep it secret, it moves robots")
    return 0


def _secrets(given: argparse.Namespace) -> int:
    for robot in read_fleet(given.fleet).robots:
        if robot.name == given.robot:
            print(secrets_header(robot, given.wifi, sys.stdin.readline().rstrip("\n")), end="")
            return 0
    raise FleetError(f"{given.robot} is not in {given.fleet}")


def _simulate(given: argparse.Namespace) -> int:
    from hero_robot.fleet.simulated import SimulatedFleet

    fleet = read_fleet(given.fleet)
    with SimulatedFleet(fleet, seen_period=given.sees):
        print(f"{len(fleet.robots)} simulated robots; end with Ctrl-C", flush=True)
        with contextlib.suppress(KeyboardInterrupt):
            signal.sigwait({signal.SIGINT, signal.SIGTERM})
    return 0


def _serve(given: argparse.Namespace) -> int:
    from hero_robot.fleet.simulated import SimulatedFleet

    fleet = read_fleet(given.fleet)
    robots: Any = SimulatedFleet(fleet, seen_period=2.0) if given.simulate else contextlib.nullcontext()
    with robots:
        asyncio.run(_serve_until_told(given, fleet))
    return 0


async def _serve_until_told(given: argparse.Namespace, fleet: Fleet) -> None:
    try:
        from hero_robot.fleet.page import FleetPage
    except ImportError:
        raise FleetError("aiohttp is not installed; the live page needs it: pip install 'swarm-envs[fleet]'") from None
    from hero_robot.fleet.run_log import RunLog
    from hero_robot.fleet.server import FleetServer

    server = FleetServer(fleet, RunLog(given.log, fleet.name) if given.log else None)
    local = all(robot.host == "127.0.0.1" for robot in fleet.robots)
    await server.open("127.0.0.1" if local else "0.0.0.0")
    page = FleetPage(server, given.host, fleet.page_port if given.page_port is None else given.page_port)
    session = session_path(given.fleet)
    told = asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        asyncio.get_running_loop().add_signal_handler(number, told.set)
    try:
        await page.open()
        _write_session(session, page.url, page.token)
        print(f"{len(fleet.robots)} robots, page at {page.url}; end with Ctrl-C", flush=True)
        await told.wait()
    finally:
        session.unlink(missing_ok=True)
        server.estop()
        await asyncio.sleep(0.1)
        await page.close()
        await server.close()


def _write_session(path: Path, url: str, token: str) -> None:
    path.unlink(missing_ok=True)
    with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w", encoding="utf-8") as stream:
        json.dump({"url": url, "token": token}, stream)


# --- commands to a running server -------------------------------------------------------------------------------------


def _call(fleet_file: Path, path: str, body: dict[str, Any] | None = None) -> dict[str, Any]:
    """Send a request to the fleet's running server; GET without a body."""
    try:
        session = json.loads(session_path(fleet_file).read_text(encoding="utf-8"))
    except OSError:
        raise FleetError(f"no server runs for {fleet_file}; start it: python -m hero_robot.fleet serve {fleet_file}") from None
    data = None if body is None else json.dumps(body).encode()
    request = urllib.request.Request(f"{session['url']}/{path}", data, {TOKEN_HEADER: session["token"]})
    opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))  # the server is on this machine
    try:
        with opener.open(request, timeout=15) as answer:
            return dict(json.load(answer))
    except urllib.error.HTTPError as error:
        raise FleetError(str(json.load(error).get("error", error))) from None
    except OSError as error:
        raise FleetError(f"the server at {session['url']} does not answer ({error}); robots stop by themselves within 0.5 s") from None


def _show(answer: dict[str, Any]) -> int:
    """Print what became of a command, one line per robot; 1 when one refused."""
    outcomes = answer["outcomes"]
    for outcome in outcomes:
        print(f"{outcome['robot']}: {outcome['reason']}")
    return int(any(not outcome["done"] for outcome in outcomes))


def _post(given: argparse.Namespace) -> int:
    return _show(_call(given.fleet, given.path, {}))


def _start(given: argparse.Namespace) -> int:
    return _show(_call(given.fleet, "start", {"delay": given.delay}))


def _update(given: argparse.Namespace) -> int:
    names = [given.robot] if given.robot else [robot.name for robot in read_fleet(given.fleet).robots]
    return _show(_call(given.fleet, "update", {"controllers": dict.fromkeys(names, given.genes)}))


def _load(given: argparse.Namespace) -> int:
    given.genes = list(read_controller(given.file))
    return _update(given)


def _status(given: argparse.Namespace) -> int:
    answer = _call(given.fleet, "status")
    for robot in answer["robots"]:
        if not robot["connected"]:
            print(f"{robot['name']}: not connected")
            continue
        seen = f"sees {robot['range']:.2f} m" if robot["detected"] else "sees nothing"
        print(
            f"{robot['name']}: {robot['state']} ({robot['reason']}), {seen}, {robot['v']:+.3f} m/s, {robot['omega']:+.2f} rad/s, "
            f"{robot['battery']:.2f} V, controller {robot['version']}, round trip {robot['round_trip'] * 1e3:.1f} ms"
        )
    return 0
