"""The genetic algorithm, operator by operator, and as pyribs' scheduler drives it."""

import numpy as np
import numpy.typing as npt
import pytest
from ribs.schedulers import Scheduler

from discovery.search.gene_box import GeneBox
from discovery.search.genetic_emitter import GeneticEmitter, cross, mutate, reflect, tournament
from discovery.search.unstructured_archive import UnstructuredArchive
from discovery.settings import SearchSettings
from tests.discovery.tiny_run import tiny

LIMITS = np.array([0.09, 1.6, 0.09, 1.6])
BOX = GeneBox(LIMITS, np.zeros(4))
Array = npt.NDArray[np.float64]


def search_settings(*overrides: str) -> SearchSettings:
    return tiny("search.population=50", *overrides).search


def make_search(
    settings: SearchSettings, include: Array | None = None, seed: int = 0
) -> tuple[UnstructuredArchive, GeneticEmitter, Scheduler]:
    archive = UnstructuredArchive(solution_dim=4, measure_dim=2, k_neighbors=settings.neighbours)
    emitter = GeneticEmitter(archive, BOX, settings, seed, np.empty((0, 4)) if include is None else include)
    return archive, emitter, Scheduler(archive, [emitter])


def test_a_tournament_picks_the_most_novel_of_its_contestants() -> None:
    novelty = np.random.default_rng(0).random(10)
    winners = tournament(novelty, 1000, 10, np.random.default_rng(1))
    assert set(winners) == {int(novelty.argmax())}, "when all contend, the best always wins"


@pytest.mark.parametrize("contestants", [1, 2, 5])
def test_the_best_wins_as_often_as_it_is_drawn(contestants: int) -> None:
    winners = tournament(np.arange(20.0), 50_000, contestants, np.random.default_rng(2))
    assert np.mean(winners == 19) == pytest.approx(contestants / 20, abs=0.01)
    assert not np.any(winners < contestants - 1), "the worst cannot win against distinct rivals"


def test_crossover_happens_at_its_rate_and_keeps_genes_in_place() -> None:
    first, second = np.zeros((40_000, 4)), np.ones((40_000, 4))
    children = cross(first, second, 0.7, np.random.default_rng(3))
    assert np.mean(children.any(axis=1)) == pytest.approx(0.7, abs=0.01)
    assert set(map(tuple, children)) == {(0, 0, 0, 0), (0, 0, 0, 1), (0, 0, 1, 1), (0, 1, 1, 1)}
    assert not cross(first, second, 0.0, np.random.default_rng(3)).any()


def test_mutation_changes_genes_at_its_rate_by_its_step() -> None:
    population = np.zeros((40_000, 4))
    changed = mutate(population, BOX, 0.15, 0.1, np.random.default_rng(4))
    assert np.mean(changed != 0) == pytest.approx(0.15, abs=0.005)
    for gene, limit in enumerate(LIMITS):
        assert changed[changed[:, gene] != 0, gene].std() == pytest.approx(0.1 * limit, rel=0.03)


def test_mutation_never_leaves_the_limits_and_does_not_pile_up_there() -> None:
    population = np.tile(LIMITS, (20_000, 1))
    changed = mutate(population, BOX, 1.0, 3.0, np.random.default_rng(5))
    assert np.all(np.abs(changed) <= LIMITS)
    assert np.mean(np.abs(changed) == LIMITS) < 0.001


def test_mutation_keeps_its_rate_where_slow_controllers_may_not_be_proposed() -> None:
    box = GeneBox(LIMITS, np.array([0.05, 0.4, 0.05, 0.4]))
    population = box.draw(10_000, np.random.default_rng(6))
    changed = mutate(population, box, 0.15, 1.0, np.random.default_rng(7))
    assert box.accepts(changed).all()
    assert np.mean(changed != population) == pytest.approx(0.15, abs=0.005)
    assert np.mean(np.sign(changed) != np.sign(population)) > 0.03, "a sign can change across what is cut out"


def test_reflection_is_a_mirror_at_each_end() -> None:
    limit = np.array([1.0])
    given = np.array([[0.3], [-0.7], [1.2], [-1.2], [3.1], [-5.0]])
    assert np.allclose(reflect(given, limit), [[0.3], [-0.7], [0.8], [-0.8], [-0.9], [-1.0]])


def test_the_first_population_is_uniform_in_the_limits_and_starts_with_the_given_controllers() -> None:
    given = np.array([[0.05, -1.0, 0.0, 1.0]])
    _, emitter, _ = make_search(search_settings("search.population=4000"), given)
    population = emitter.ask()
    assert population.shape == (4000, 4)
    assert np.array_equal(population[0], given[0])
    assert np.all(np.abs(population) <= LIMITS)
    assert np.allclose((population / LIMITS).std(axis=0), 1 / np.sqrt(3), atol=0.02)


def test_selection_moves_the_population_towards_what_is_novel() -> None:
    """Novelty that grows with gene 0: children of the second generation have more of it."""
    _, emitter, scheduler = make_search(search_settings("search.mutation=0"))
    population = scheduler.ask()
    scheduler.tell(None, np.stack([np.exp(40 * population[:, 0]), np.zeros(len(population))], axis=1))
    assert scheduler.ask()[:, 0].mean() > population[:, 0].mean() + 0.01
    assert emitter.generation == 1


def test_the_archive_keeps_everything_twins_too() -> None:
    settings = search_settings()
    archive, _, scheduler = make_search(settings)
    for _ in range(5):
        scheduler.tell(None, np.zeros((len(scheduler.ask()), 2)))
    assert len(archive) == 250


def test_telling_the_same_again_leads_to_the_same_next_population() -> None:
    populations = []
    for _ in range(2):
        _, _, scheduler = make_search(search_settings(), seed=9)
        for _ in range(3):
            population = scheduler.ask()
            scheduler.tell(None, population[:, :2])
        populations.append(population)
    assert np.array_equal(*populations)
    _, _, other = make_search(search_settings(), seed=10)
    assert not np.array_equal(other.ask(), make_search(search_settings(), seed=9)[2].ask())
