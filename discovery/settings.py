"""What a run may be told: one dataclass a config group, each number with its bounds.

Values live in ``configs/``; these classes give them types, refuse unknown keys and numbers out of bounds.

A setting that is added later takes a neutral value, with which everything is as it was before. A config that lacks it is read with that
value, and written without it: folders of earlier runs stay readable and keep their identity.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from omegaconf import MISSING, DictConfig, OmegaConf
from omegaconf.errors import OmegaConfBaseException

from discovery.errors import DiscoveryError


def number(low: float, high: float = float("inf"), neutral: Any = MISSING) -> Any:
    """Declare a number, or a list of numbers, from ``low`` to ``high``."""
    return dataclasses.field(default=neutral, metadata={"low": low, "high": high})


def choice(*options: str | int, neutral: str | int = MISSING) -> Any:
    """Declare a word or a number out of ``options``."""
    return dataclasses.field(default=neutral, metadata={"options": options})


@dataclass
class DatasetSettings:
    """Videos of random controllers."""

    videos: int = number(2)
    """How many, over all controllers and their starts."""
    frames: int = number(1, 64)
    """Frames of a video, evenly spaced over the last half of the rollout."""
    trail: bool = False
    """Whether each picture shows, fading into the past, the robots' paths since the picture before it."""
    size: int = number(8, 512)
    """Pixels a side."""
    chunk: int = number(1)
    """Rollouts simulated, and saved, at a time."""
    starts: int = number(1, 100, neutral=1)
    """Videos of each controller, from starts of their own; with more than one, SimCLR's pairs are two videos of one controller."""


@dataclass
class NetworkSettings:
    """What is made of a network's 512 numbers, in this order; then comes ``normalise``."""

    symmetries: int = choice(1, 4, 8, neutral=1)
    """Embeddings are means over the video turned and mirrored in so many ways: 4 leave a rectangle in place, 8 a square."""
    whiten: str = choice("none", "standardise", "pca", neutral="none")
    """Whether numbers, or principal components, have mean 0 and standard deviation 1 over the dataset."""
    whiten_variance: float = number(0.01, 1.0, neutral=0.95)
    """Share of the variance that the principal components hold which ``pca`` keeps."""
    metrics: float = number(0.0, neutral=0.0)
    """Weight of the five hand-crafted metrics beside the embedding: with 1 both vary as much over the dataset, 0 leaves them out."""
    metrics_roots: bool = False
    """Whether radial variance and scatter, squared lengths, stand there by their roots."""


@dataclass
class SimCLRSettings(NetworkSettings):
    """Contrastive learning on a ResNet18."""

    method: str = choice("simclr")
    weights: str = choice("imagenet", "random")
    """Where training starts."""
    epochs: int = number(0)
    batch: int = number(2)
    """Videos a step; each gives two views."""
    learning_rate: float = number(0.0)
    """For each 256 videos of the batch."""
    weight_decay: float = number(0.0)
    momentum: float = number(0.0, 1.0)
    warmup_epochs: int = number(0)
    temperature: float = number(1e-6)
    crop_scale: list[float] = number(0.01, 1.0)
    """Smallest and largest area of the random crop, as a share of the picture."""
    flip: float = number(0.0, 1.0)
    """Probability of a horizontal flip."""
    normalise: bool = MISSING
    """Whether embeddings have length one, so that distances compare directions, as the loss does."""
    checkpoint_seconds: float = number(0.0, 60.0)
    """Longest training time in s lost to a stop."""
    device: str = choice("auto", "cpu", "cuda")
    precision: str = choice("auto", "float32", "bfloat16")


@dataclass
class TripletSettings(NetworkSettings):
    """A ResNet18 trained on judgements of which of two rollouts is more like a third."""

    method: str = choice("triplet")
    judgements: str | None = MISSING
    """A person's answers, a file; None takes those of a simulated annotator, who goes by the rules' labels."""
    answers: int = number(1)
    """Answers that the simulated annotator gives."""
    error_rate: float = number(0.0, 1.0)
    """Share of its answers that are wrong."""
    weights: str = choice("imagenet", "random")
    """Where training starts."""
    epochs: int = number(0)
    batch: int = number(1)
    """Judged triples a step."""
    learning_rate: float = number(0.0)
    weight_decay: float = number(0.0)
    margin: float = number(0.0)
    """By how much the similar one is to be nearer."""
    crop_scale: list[float] = number(0.01, 1.0)
    """Smallest and largest area of the random crop, as a share of the picture."""
    flip: float = number(0.0, 1.0)
    """Probability of a horizontal flip."""
    normalise: bool = MISSING
    """Whether embeddings have length one."""
    checkpoint_seconds: float = number(0.0, 60.0)
    """Longest training time in s lost to a stop."""
    device: str = choice("auto", "cpu", "cuda")
    precision: str = choice("auto", "float32", "bfloat16")


@dataclass
class UntrainedSettings(NetworkSettings):
    """A ResNet18 that is not trained."""

    method: str = choice("untrained")
    weights: str = choice("imagenet", "random")
    normalise: bool = MISSING
    """Whether embeddings have length one."""
    device: str = choice("auto", "cpu", "cuda")
    precision: str = choice("auto", "float32", "bfloat16")


@dataclass
class HandCraftedSettings:
    """Five metrics instead of a network."""

    method: str = choice("hand_crafted")
    standardise: bool = MISSING
    """Whether each has mean 0 and standard deviation 1 over the dataset."""
    roots: bool = False
    """Whether radial variance and scatter, squared lengths, enter by their roots."""


REPRESENTATIONS: dict[str, type] = {
    "hand_crafted": HandCraftedSettings, "simclr": SimCLRSettings, "triplet": TripletSettings, "untrained": UntrainedSettings,
}  # fmt: skip
"""Settings class of each representation.method."""


@dataclass
class SearchSettings:
    """Which controllers are tried, and which of them have children."""

    method: str = choice("novelty", "random", "isoline")
    """Who proposes controllers: a genetic algorithm that selects by novelty, chance, or isoline variation."""
    archive: str = choice("proximity", "cvt", neutral="proximity")
    """Where parents come from: everything evaluated, or the cells of a tessellation, which keep their latest; recorded is everything."""
    distance: str = choice("euclidean", "cosine", neutral="euclidean")
    """Between embeddings, for novelty and for the medoids."""
    population: int = number(2)
    generations: int = number(1)
    """How many, the random first one included."""
    neighbours: int = number(1)
    """Nearest archive members that novelty averages over."""
    tournament: int = number(1)
    """Contestants of a tournament."""
    crossover: float = number(0.0, 1.0)
    """Probability that a child has two parents."""
    mutation: float = number(0.0, 1.0)
    """Probability that a gene is changed."""
    mutation_step: float = number(0.0, 10.0)
    """Standard deviation of a change as a share of the gene's limit."""
    warmup: int = number(0, neutral=0)
    """Generations of random controllers before the method proposes; a tessellation's cells are made from them."""
    cells: int = number(2, neutral=250)
    """Cells of the tessellation."""
    iso_sigma: float = number(0.0, neutral=0.01)
    """Isoline variation: standard deviation in every direction, as a share of the gene's limit (Vassiliades and Mouret 2018)."""
    line_sigma: float = number(0.0, neutral=0.2)
    """Isoline variation: standard deviation along the line between two parents, as a share of their difference."""
    minimal_criterion: float = number(0.0, 1.0, neutral=0.0)
    """Parents' swarms move at least so fast on average, as a share of the world's top speed; 0 asks nothing."""
    min_speed: float = number(0.0, neutral=0.0)
    """Smallest magnitude in m/s of both speeds of a proposed controller."""
    min_turn_rate: float = number(0.0, neutral=0.0)
    """Smallest magnitude in rad/s of both turn rates of a proposed controller."""
    include: list[Any] = dataclasses.field(default_factory=list)  # omegaconf takes no whole numbers for nested floats
    """Controllers [v0, w0, v1, w1] in m/s and rad/s that join the first population."""


@dataclass
class ClusteringSettings:
    """From the archive to a few behaviours."""

    method: str = choice("kmedoids")
    medoids: int = number(1)
    of: str = choice("everything", "archive", neutral="everything")
    """Where medoids come from: everything evaluated, or what the search's archive holds in the end, with cvt one controller a cell."""
    standardise: bool = False
    """Whether every number of the embeddings has mean 0 and standard deviation 1 over the archive first."""
    whiten: bool = False
    """Whether the principal components that hold 99 % of the variance weigh the same first."""
    by_chance: bool = False
    """Whether distances are in units of what chance does: how embeddings of one controller differ over ``dataset.starts``."""
    stable: int = number(0, neutral=0)
    """Members nearest to each medoid that are tried from other starts, for the steadiest to stand for the cluster; 0 keeps the medoid."""
    sample: int = number(10, neutral=10_000)
    """Archive members that are clustered at once; larger archives by samples of that many (CLARA)."""


@dataclass
class ReportSettings:
    """The page at the end."""

    method: str = choice("html")
    map_points: int = number(1)
    """Archive members on the map."""
    map_iterations: int = number(250)
    """Iterations of t-SNE; its library takes no fewer."""
    frame_every: int = number(1)
    """Ticks between the animations' frames."""


@dataclass
class TrackerSettings:
    """Where progress can be watched."""

    method: str = choice("tensorboard", "none", "wandb", "mlflow", neutral="tensorboard")
    project: str = "swarm-envs"
    """Project of wandb, experiment of MLflow."""


@dataclass
class Settings:
    """A whole run."""

    name: str = MISSING
    world: str = MISSING
    engine: str = choice("chipmunk", "disc")
    steps: int = number(2)
    """Ticks of a rollout."""
    seed: int = number(0, 2**63 - 1)
    threads: int | None = number(1)
    """Cores to use; None takes all."""
    runs: str = MISSING
    folder: str | None = MISSING
    resume: str | None = MISSING
    dataset: DatasetSettings = dataclasses.field(default_factory=DatasetSettings)
    representation: Any = MISSING
    """One of :data:`REPRESENTATIONS`."""
    search: SearchSettings = dataclasses.field(default_factory=SearchSettings)
    clustering: ClusteringSettings = dataclasses.field(default_factory=ClusteringSettings)
    report: ReportSettings = dataclasses.field(default_factory=ReportSettings)
    tracker: TrackerSettings = dataclasses.field(default_factory=TrackerSettings)


PLACES = ("runs", "folder", "resume")
"""Settings that say where, not what: they may differ when a run is resumed."""


def read_settings(config: DictConfig) -> Settings:
    """Turn a composed config into typed settings.

    Raises:
        DiscoveryError: On an unknown or missing key, a wrong type, or a number out of bounds.
    """
    method = OmegaConf.select(config, "representation.method")
    if method not in REPRESENTATIONS:
        raise DiscoveryError(f"representation.method: given {method!r}, expected {' or '.join(REPRESENTATIONS)}")
    schema = OmegaConf.structured(Settings)
    schema.representation = OmegaConf.structured(REPRESENTATIONS[method])
    try:
        settings: Settings = OmegaConf.to_object(OmegaConf.merge(schema, config))  # type: ignore[assignment]
    except OmegaConfBaseException as error:
        key = error.full_key or "config"
        raise DiscoveryError(f"{key}: {str(error).splitlines()[0]}; see configs/ for the keys and their types") from None
    _check_bounds(settings, "")
    _check_together(settings)
    return settings


def _check_bounds(part: Any, prefix: str) -> None:
    for field in dataclasses.fields(part):
        key, value = prefix + field.name, getattr(part, field.name)
        if dataclasses.is_dataclass(value):
            _check_bounds(value, key + ".")
        options = field.metadata.get("options")
        if options and value not in options:
            raise DiscoveryError(f"{key}: given {value!r}, expected {' or '.join(map(str, options))}")
        if "low" in field.metadata and value is not None:
            low, high = field.metadata["low"], field.metadata["high"]
            for item in value if isinstance(value, list) else [value]:
                if not low <= item <= high:
                    bound = f"from {low:g} to {high:g}" if high < float("inf") else f"of at least {low:g}"
                    raise DiscoveryError(f"{key}: given {item!r}, expected a number {bound}")


def _check_together(settings: Settings) -> None:
    evaluations = settings.search.population * settings.search.generations
    representation = settings.representation
    if settings.clustering.medoids > evaluations:
        raise DiscoveryError(
            f"clustering.medoids: given {settings.clustering.medoids}, but the search makes only {evaluations} evaluations"
        )
    _check_dataset(settings.dataset)
    controllers = settings.dataset.videos // settings.dataset.starts
    if isinstance(representation, SimCLRSettings) and representation.batch > controllers:
        of = "dataset.videos" if settings.dataset.starts == 1 else "the controllers of the dataset, dataset.videos / dataset.starts"
        raise DiscoveryError(f"representation.batch: given {representation.batch}, expected at most {of}, {controllers}")
    if isinstance(representation, NetworkSettings) and representation.metrics_roots and representation.metrics == 0.0:
        raise DiscoveryError("representation.metrics_roots: given true, but representation.metrics=0 puts none beside the embedding")
    if isinstance(representation, SimCLRSettings | TripletSettings):
        crop = representation.crop_scale
        if len(crop) != 2 or crop[0] > crop[1]:
            raise DiscoveryError(f"representation.crop_scale: given {crop}, expected [smallest, largest]")
    _check_clustering(settings)
    _check_search(settings.search)
    if len(settings.search.include) > settings.search.population:
        raise DiscoveryError(f"search.include: given {len(settings.search.include)} controllers, expected at most search.population")


def _check_dataset(dataset: DatasetSettings) -> None:
    for name in ("videos", "chunk"):
        if (given := getattr(dataset, name)) % dataset.starts:
            raise DiscoveryError(f"dataset.{name}: given {given}, expected a multiple of dataset.starts, {dataset.starts}")


def _check_clustering(settings: Settings) -> None:
    clustering, starts = settings.clustering, settings.dataset.starts
    if clustering.by_chance and starts < 2:
        raise DiscoveryError(f"clustering.by_chance: needs dataset.starts of 2 or more, given {starts}")
    if clustering.by_chance and (clustering.standardise or clustering.whiten):
        other = "standardise" if clustering.standardise else "whiten"
        raise DiscoveryError(f"clustering.by_chance: given together with clustering.{other}, expected one of them")


def _check_search(search: SearchSettings) -> None:
    drawn = search.warmup * search.population
    if search.archive == "cvt" and search.method == "novelty":
        raise DiscoveryError("search.archive: given 'cvt', but search.method=novelty measures against everything; take random or isoline")
    if search.archive == "cvt" and drawn < search.cells:
        raise DiscoveryError(f"search.cells: given {search.cells}, expected at most the {drawn} evaluations of search.warmup")
    if search.archive == "cvt" and search.distance == "cosine":
        raise DiscoveryError(
            "search.distance: given 'cosine', but search.archive=cvt has Euclidean cells; take representation.normalise=true"
        )
    if search.method == "isoline" and search.warmup < 1:
        raise DiscoveryError("search.warmup: given 0, expected 1 or more: isoline variation needs parents")
    if search.warmup >= search.generations:
        raise DiscoveryError(f"search.warmup: given {search.warmup}, expected fewer than search.generations, {search.generations}")
    if search.minimal_criterion > 0 and search.method != "novelty":
        raise DiscoveryError(f"search.minimal_criterion: works with search.method=novelty only, given {search.method}")


def flat(settings: Settings) -> dict[str, Any]:
    """Return every setting under its dotted key."""

    def walk(part: Any, prefix: str) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for field in dataclasses.fields(part):
            value = getattr(part, field.name)
            found |= walk(value, f"{prefix}{field.name}.") if dataclasses.is_dataclass(value) else {prefix + field.name: value}
        return found

    return walk(settings, "")


def setting_names(part: Any = Settings, prefix: str = "") -> list[str]:
    """Return the dotted key of every setting."""
    names: list[str] = []
    for field in dataclasses.fields(part):
        if field.name == "representation":
            names += sorted({name for kind in REPRESENTATIONS.values() for name in setting_names(kind, "representation.")})
            continue
        default = field.default_factory() if field.default_factory is not dataclasses.MISSING else None
        names += setting_names(default, f"{prefix}{field.name}.") if dataclasses.is_dataclass(default) else [prefix + field.name]
    return names


def to_yaml(settings: Settings) -> str:
    """Return the settings as YAML, without those that say only where and those that have their neutral value."""

    def walk(part: Any) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for field in dataclasses.fields(part):
            value, neutral = getattr(part, field.name), field.default
            if dataclasses.is_dataclass(value):
                if inside := walk(value):
                    found[field.name] = inside
            elif neutral in (dataclasses.MISSING, MISSING) or value != neutral:
                found[field.name] = value
        return found

    plain = {key: value for key, value in walk(settings).items() if key not in PLACES}
    return OmegaConf.to_yaml(OmegaConf.create(plain))
