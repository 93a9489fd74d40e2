"""Evidence for the four requirements: sessions of simulated users, and the code of the tasks."""

from collections.abc import Callable, Mapping
from functools import partial

import msgspec

from sar_tui.loop.graph import Graph
from sar_tui.loop.session import Parts
from sar_tui.validation.bodies import Body, every_body
from sar_tui.validation.modularity import Code
from sar_tui.validation.report import Conditions
from sar_tui.validation.simulated_sessions import SessionRunner, Simulated, session_runner

USERS = ("poor", "average", "competent")
EVERY = 3
"""Number of attempts per feedback, where not each attempt is to have it."""


class Evidence(msgspec.Struct, frozen=True):
    """Evidence on one system.

    Attributes:
        sessions: of twenty attempts with feedback after each, by user and seed.
        rare: those of competent users with feedback after every three attempts, by seed.
        worded: sessions of an average user by the form of feedback that was asked for, and seed.
        bare: a session without other bodies than the screen; ``embodied``: the same one with
            ``bodies``.
        code: lines of each task's session; ``graphs``: the loops of the keyboard and the reaching
            task; ``nodes``: the classes of the nodes in them, by name.
    """

    sessions: Mapping[tuple[str, int], Simulated]
    rare: Mapping[int, Simulated]
    worded: Mapping[tuple[str, int], Simulated]
    bare: Simulated
    embodied: Simulated
    bodies: tuple[Body, ...]
    code: Mapping[str, Code]
    graphs: Mapping[str, Graph]
    nodes: Mapping[str, Mapping[str, str]]


class System(msgspec.Struct, frozen=True):
    """A system that evidence is collected on: the program as it is, or with one thing broken.

    Attributes:
        settings: of every session. ``rare``, ``worded``: more of them, for sessions in which
            feedback is to be rare, or has a form; they come last.
        bodies: returns the agent's bodies.
        parts: the classes of the framework's nodes.
    """

    settings: Mapping[str, object] = {}
    rare: Mapping[str, object] = {}
    worded: Mapping[str, object] = {}
    bodies: Callable[[], tuple[Body, ...]] = every_body
    parts: Parts = Parts()


def collect(
    conditions: Conditions,
    system: System,
    code: Mapping[str, Code],
    graphs: Mapping[str, Graph],
    nodes: Mapping[str, Mapping[str, str]],
    done: Callable[[], None] = lambda: None,
) -> Evidence:
    """Run the sessions of a system. ``done`` is called after each, `sessions` times."""
    seeds = conditions.seeds
    with session_runner(conditions.catalogue, conditions.known) as runner:
        run = partial(_run, runner, done, system.parts)
        bodies = system.bodies()
        return Evidence(
            sessions={
                (user, seed): run(user, seed, system.settings) for user in USERS for seed in seeds
            },
            rare={
                seed: run(
                    "competent", seed, {**system.settings, "feedback_every": EVERY, **system.rare}
                )
                for seed in seeds
            },
            worded={
                (form, seed): run(
                    "average", seed, {**system.settings, "feedback_form": form, **system.worded}
                )
                for form in ("qualitative", "quantitative")
                for seed in seeds[:2]
            },
            bare=run("average", seeds[0], system.settings),
            embodied=run("average", seeds[0], system.settings, bodies),
            bodies=bodies,
            code=code,
            graphs=graphs,
            nodes=nodes,
        )


def sessions(conditions: Conditions) -> int:
    """Return the number of sessions of one system."""
    return (len(USERS) + 1) * len(conditions.seeds) + 2 * len(conditions.seeds[:2]) + 2


def _run(
    runner: SessionRunner,
    done: Callable[[], None],
    parts: Parts,
    user: str,
    seed: int,
    settings: Mapping[str, object],
    bodies: tuple[Body, ...] = (),
) -> Simulated:
    found = runner.run(user, seed, bodies=bodies, parts=parts, **settings)
    done()
    return found
