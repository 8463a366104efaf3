"""Writes the pages of environments and worlds from the registry, the docstrings and the world files.

``python -m docs.site.generate`` writes them; the tests fail when a committed page differs from what this module would write.
"""

from __future__ import annotations

import inspect
import json
import re
from pathlib import Path
from typing import Any

import gymnasium as gym

import swarm_envs
from discovery.clustering.engine_agreement import STARTS
from docs.site import atlas_data
from swarm_envs.envs.registration import ENVIRONMENTS
from swarm_envs.envs.swarm import SwarmEnv
from swarm_envs.envs.tasks import TASKS
from swarm_envs.worlds import WorldSpec

DOCS = Path(__file__).parents[1]
PRESETS: list[dict[str, Any]] = json.loads(Path(__file__).with_name("presets.json").read_text())
"""Named behaviours: behaviour, world, controller [v0, omega0, v1, omega1] in m/s and rad/s, seed."""


def pages() -> dict[str, str]:
    """Return every generated page's text by its path under docs."""
    written = {f"environments/{slug(name)}.md": environment_page(name, task) for name, task in ENVIRONMENTS.items()}
    written["environments/index.md"] = environment_index()
    written |= {f"worlds/{name}.md": world_page(swarm_envs.load_world(name)) for name in swarm_envs.world_names()}
    written["worlds/index.md"] = world_index()
    written["atlas.md"] = atlas_page(atlas_data.read())
    return written


def words(camel: str) -> str:
    """Return a behaviour's name from a task's: CyclicPursuit is cyclic pursuit."""
    return re.sub(r"(?<!^)(?=[A-Z])", " ", camel).lower()


def slug(name: str) -> str:
    """Return the page's name of an environment id."""
    return words(name.removeprefix("HeRo/").removesuffix("-v0")).replace(" ", "_")


def clip_name(preset: dict[str, Any]) -> str:
    """Return the file name, without ending, of a preset's clip."""
    return f"{preset['behaviour']}-{preset['world']}".replace(" ", "-")


def clips_of(task: str | None) -> list[dict[str, Any]]:
    """Return the presets whose behaviour a task rewards; one of each behaviour for none."""
    if task is not None:
        return [preset for preset in PRESETS if preset["behaviour"] == words(task)]
    return [next(preset for preset in PRESETS if preset["behaviour"] == words(name)) for name in TASKS]


def numbers(values: list[float]) -> str:
    """Return a controller as it is typed."""
    return "[" + ", ".join(f"{value:g}" for value in values) + "]"


def clip(preset: dict[str, Any], up: str = "../") -> str:
    """Return a clip as HTML: it loads when it is scrolled to, and stands still for readers who prefer that."""
    file = f"{up}_static/clips/{clip_name(preset)}"
    text = f"Eight robots from above, {preset['behaviour']} in the world {preset['world']}"
    return (
        f'<picture><source media="(prefers-reduced-motion: reduce)" srcset="{file}-still.webp">'
        f'<img class="clip" loading="lazy" width="240" height="200" src="{file}.webp" alt="{text}"></picture>'
    )


def open_in_playground(preset: dict[str, Any], up: str = "../") -> str:
    """Return the address of the front page with a preset running; ``index`` is its world in rollouts with the seed, 0 unless given."""
    numbers, index = ",".join(repr(value) for value in preset["controller"]), preset.get("index", 0)
    return f"{up}index.html#w={preset['world']}&c={numbers}&n=8&s={preset['seed']}" + (f"&i={index}" if index else "")


def clip_gallery(presets: list[dict[str, Any]]) -> str:
    """Return cards with a clip each, its controller and its seed."""
    cards = []
    for preset in presets:
        world, controller = preset["world"], numbers(preset["controller"])
        cards.append(
            f":::{{grid-item-card}} {preset['behaviour'].capitalize()}, `{world}`\n{clip(preset)}\n\n"
            f'`rollouts("{world}", [{controller}], seed={preset["seed"]})`\n\n'
            f'<a href="{open_in_playground(preset)}">Open in the playground</a>\n:::\n'
        )
    return "::::{grid} 1 2 2 3\n:gutter: 3\n\n" + "\n".join(cards) + "::::\n"


def sections(docstring: str) -> tuple[str, dict[str, str]]:
    """Return a docstring's first line and its sections by heading."""
    text = inspect.cleandoc(docstring)
    head, *rest = re.split(r"^## (.+)$", text, flags=re.MULTILINE)
    return head.strip(), {title.strip(): body.strip() for title, body in zip(rest[::2], rest[1::2], strict=True)}


def environment_page(name: str, task: str | None) -> str:
    """Return the page of one environment id."""
    head, body = sections(SwarmEnv.__doc__ or "")
    env = gym.make(name)
    if task is not None:
        head = inspect.cleandoc(TASKS[task].__doc__ or "").split("\n")[0]
        body["Description"] = body["Description"].replace("; this id has none", "").replace("this id has none", "")
        body["Description"] += f"\n\nThis id rewards the behaviour [{words(task)}](../guides/behaviours.md)."
        body["Rewards"] = inspect.cleandoc(TASKS[task].__doc__ or "") + "\n\nFrom 0 to 1, the same for every robot, after every tick."
        body["Arguments"] = body["Arguments"].replace("HeRo/Swarm-v0", name).replace("task=None", f'task="{task}"')
    head = head.splitlines()[0]
    spaces = [
        ("Action space", f"`{box_text(env.action_space)}`"),
        ("Observation space", f"`{env.observation_space}`"),
        ("Reward", "0.0" if task is None else "from 0 to 1 each tick"),
        ("Episode", f"{env.spec.max_episode_steps if env.spec else 600} ticks of {env.unwrapped.world.tick:g} s"),  # type: ignore[attr-defined]
        ("Import", f'`import gymnasium as gym, swarm_envs; env = gym.make("{name}")`'),
        ("One agent per robot", f'`pettingzoo.make("parallel", "{name}")`'),
        ("Many swarms", f'`gym.make_vec("{name}", num_envs=256, vectorization_mode="vector_entry_point")`'),
    ]
    env.close()
    table = "| what | value |\n|---|---|\n" + "\n".join(f"| {key} | {value} |" for key, value in spaces)
    parts = [f"# {name}", head, table, "## Behaviours", clip_gallery(clips_of(task))]
    parts += [f"## {title}\n{text}" for title, text in body.items()]
    made = "```{code-block} python\nimport gymnasium as gym\nimport swarm_envs\n\nenv = gym.make("
    return (
        "\n\n".join(parts)
        .replace("```python\ngym.make(", made)
        .replace("         robot_software", "               robot_software")
        .rstrip()
        + "\n"
    )


def box_text(space: gym.Space[Any]) -> str:
    """Return an action space as one line: all robots have the same bounds."""
    assert isinstance(space, gym.spaces.Box)
    (low_v, low_omega), (high_v, high_omega) = space.low[0], space.high[0]
    return f"Box([{low_v:g}, {low_omega:g}] to [{high_v:g}, {high_omega:g}] for each robot, {space.shape}, {space.dtype})"


def environment_index() -> str:
    """Return the index of environment cards."""
    cards = []
    for name, task in ENVIRONMENTS.items():
        text = "Any world, no reward: the bare swarm." if task is None else inspect.cleandoc(TASKS[task].__doc__ or "").split("\n")[0]
        film = clips_of(task)[0] if task else clips_of("CyclicPursuit")[1]  # one that no other card shows
        cards.append(f":::{{grid-item-card}} {name}\n:link: {slug(name)}\n:link-type: doc\n\n{clip(film)}\n\n{text}\n:::\n")
    tree = "\n".join(f"{name} <{slug(name)}>" for name in ENVIRONMENTS)
    return (
        "# Environments\n\nOne swarm, six ids, each in Gymnasium and in PettingZoo, scalar and vectorised. The clips run at ten times "
        "the robots' speed; lines show the sensors' beams and trails of 12 s.\n\n::::{grid} 1 2 2 3\n:gutter: 3\n\n"
        + "\n".join(cards)
        + f"::::\n\n```{{toctree}}\n:hidden:\n\n{tree}\n```\n"
    )


def value_at(world: WorldSpec, path: str) -> Any:
    """Return the number at a dotted path of a world file; robots of a world are of one kind."""
    if path == "num_robots":
        return world.num_robots
    at: Any = world
    if path.startswith("effects."):
        path = "robot." + path
    for part in path.split("."):
        name, _, index = part.partition("[")
        at = at.robots[0] if name == "robot" else getattr(at, name)
        if index:
            at = at[int(index.rstrip("]"))]
    return at


def shown(value: Any) -> str:
    """Return a constant as text."""
    if isinstance(value, tuple):
        return ", ".join(f"({shown(item)})" if isinstance(item, tuple) else shown(item) for item in value)
    return f"{value:g}" if isinstance(value, int | float) else str(value)


def constants_table(world: WorldSpec) -> str:
    """Return every sourced number of a world as a table."""
    rows = ["| constant | value | unit | source | note |", "|---|---|---|---|---|"]
    for path in sorted(world.provenance):
        origin = world.provenance[path]
        unit = "" if origin.unit == "1" else origin.unit
        cells = [f"`{path}`", shown(value_at(world, path)), unit, origin.source, origin.note]
        rows.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(rows)


def world_page(world: WorldSpec) -> str:
    """Return the page of one world."""
    use = f"""```{{code-block}} python
import gymnasium as gym
import swarm_envs

world = swarm_envs.load_world("{world.name}")
env = gym.make("HeRo/Swarm-v0", world="{world.name}")
```"""
    parts = [f"# {world.name}", world.description, use]
    presets = [preset for preset in PRESETS if preset["world"] == world.name]
    if presets:
        parts += ["## Behaviours", clip_gallery(presets)]
    parts += [
        "## Constants",
        "Each number of the world file and of its robot, with its unit and its source.",
        constants_table(world),
    ]
    parts += ["Numbers that the files omit keep the defaults of {class}`swarm_envs.WorldSpec`."]
    return "\n\n".join(parts).rstrip() + "\n"


def world_index() -> str:
    """Return the table of worlds."""
    rows = ["| world | what it is | speed limit | turn limit | contact radius | friction, robots and wall |", "|---|---|---|---|---|---|"]
    for name in swarm_envs.world_names():
        world = swarm_envs.load_world(name)
        contact, limits = world.contact, world.limits
        rows.append(
            f"| [{name}]({name}.md) | {world.description} | {limits.linear_speed:g} m/s | {limits.angular_speed:g} rad/s "
            f"| {1e3 * world.robots[0].body.contact_radius:g} mm | {contact.robot_friction:g}, {contact.wall_friction:g} |"
        )
    tree = "\n".join(swarm_envs.world_names())
    return (
        "# Worlds\n\nA world is a file of numbers, each with its unit and its source; "
        "[your own](../guides/own_world.md) is given by its path.\n\n" + "\n".join(rows) + f"\n\n```{{toctree}}\n:hidden:\n\n{tree}\n```\n"
    )


def playground_world(world: WorldSpec) -> dict[str, Any] | None:
    """Return what the playground needs of a world, in SI units; None where it has something that the playground lacks."""
    from swarm_envs.simulation.chipmunk.substeps import substeps_for
    from swarm_envs.worlds import Effects

    model, contact = world.robots[0], world.contact
    plain = model.effects == Effects() and model.body.wheel_stall_half_angle == 0.0 and len(model.sensors) == 1
    if not plain or world.objects or world.arena.obstacles or world.broadcast or contact.robot_restitution or contact.wall_restitution:
        return None
    return {
        "outline": world.arena.outline, "size": world.size, "tick": world.tick, "substeps": substeps_for(world),
        "contact_radius": model.body.contact_radius, "visible_radius": model.body.visible_radius,
        "mass": model.body.mass, "inertia_ratio": model.body.inertia_ratio,
        "robot_friction": contact.robot_friction, "wall_friction": contact.wall_friction,
        "sensor": {"half_angle": model.sensors[0].half_angle, "range": model.sensors[0].range, "bearing": model.sensors[0].bearing},
        "linear_speed": world.limits.linear_speed, "angular_speed": world.limits.angular_speed,
        "start": {key: getattr(world.start, key) for key in ("columns", "rows", "spacing_x", "spacing_y")},
        "num_robots": world.num_robots, "description": world.description,
    }  # fmt: skip


def playground_data() -> str:
    """Return worlds and presets as the JavaScript module that the playground is built with."""
    worlds = {name: playground_world(swarm_envs.load_world(name)) for name in swarm_envs.world_names()}
    data = {"worlds": {name: world for name, world in worlds.items() if world}, "presets": PRESETS}
    return "// Written by docs/site/generate.py from the world files.\nexport default " + json.dumps(data, indent=1) + ";\n"


def medoid_table(data: dict[str, Any]) -> str:
    """Return the atlas's medoids as a table, for readers who cannot use the map."""
    rows = [
        "| no. | behaviour | share | no robot in view | a robot in view | label repeats | engines | play |",
        "|---|---|---|---|---|---|---|---|",
    ]
    world, genes, labels = data["run"]["world"], atlas_data.controllers(data), atlas_data.labels(data)
    for number, medoid in enumerate(data["medoids"], 1):
        row, (seed, index) = medoid["row"], atlas_data.start_of(data, medoid["row"])
        v0, w0, v1, w1 = genes[row]
        address = open_in_playground({"world": world, "controller": genes[row].tolist(), "seed": seed, "index": index}, "")
        cells = [
            str(number),
            labels[row].replace(" ", "&nbsp;"),
            f"{100 * medoid['share']:.0f}&nbsp;%",
            f"{100 * v0:.1f} cm/s, {w0:.2f} rad/s",
            f"{100 * v1:.1f} cm/s, {w1:.2f} rad/s",
            f"{medoid['label_repeated']} of {STARTS}",
            {True: "agree", False: "differ", None: "not asked"}[medoid["engines_agree"]],
            f'<a href="{address}" aria-label="Open medoid {number} in the playground">open</a>',
        ]
        rows.append("| " + " | ".join(cells) + " |")
    return "\n".join(rows)


def atlas_page(data: dict[str, Any]) -> str:
    """Return the atlas: the map's place, the medoids as a table, and where the data come from."""
    run = data["run"]
    commit = f", commit `{run['commit'][:10]}`" if run["commit"] else ""
    return f"""# Behaviour atlas

What can eight robots do with four numbers? Each point is one of the {run["evaluations"]:,} controllers that a discovery run
evaluated in [{run["world"]}](worlds/{run["world"]}.md). Points that are close on the map are similar to the run's encoder; colours are the
[labels by rules](guides/behaviours.md). Point at one to watch it, click to keep it. Numbered rings are the
{len(data["medoids"])} medoids, which represent all of them.

```{{raw}} html
:file: site/atlas_map.html
```

## The medoids

{medoid_table(data)}

*Share* is the part of the archive that a medoid represents. Each controller was run again from {STARTS} new starts with both engines:
*label repeats* counts the runs with `{run["engine"]}` that the rules call what they called the medoid; the *engines agree* when most runs
of both get the same name, be it the medoid's or another.

## Where the data come from

Experiment `{run["name"]}`, seed {run["seed"]}{commit}, finished on {run["finished"][:10]}:

```{{code-block}} text
{run["command"]}
```

World `{run["world"]}`, engine `{run["engine"]}`, {run["steps"]} ticks, {run["evaluations"]:,} evaluations. The encoder was trained
for {run["epochs"]} epochs on {run["videos"]:,} videos in batches of {run["batch"]:,}, starting from {run["origin"]}. The paper's
search made 5,000 evaluations, too; its encoder was trained for 100 epochs on 6,000 videos in batches of 1,000, starting from
ImageNet weights.
{_handed_over(run["handed_over"])}
The map is t-SNE of the {run["evaluations"]:,} embeddings: neighbourhoods are meaningful, long distances and the axes are not.
The picture shows the same controller from the same initial poses, simulated [in the browser](design.md#the-playground); the
command repeats Python's own run to the bit.
"""


def _handed_over(stages: dict[str, str]) -> str:
    """Return a paragraph that says which stages another run has made; nothing when there are none."""
    return "".join(f"\nThe {stage} is that of {source}.\n" for stage, source in stages.items())


def write() -> None:
    """Write every generated page."""
    for path, text in pages().items():
        (DOCS / path).parent.mkdir(parents=True, exist_ok=True)
        (DOCS / path).write_text(text)


if __name__ == "__main__":
    write()
