"""A simulation on a local Dask cluster finds what this machine finds, whoever is lost meanwhile."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from threading import Event
from typing import Any, NamedTuple

import pytest

from sar_tui.runs.plan import Failed
from sar_tui.study import cluster
from sar_tui.study.cluster import ClusterRefused, on_cluster
from sar_tui.study.outcome import Model
from sar_tui.study.power import estimate

MODEL = Model("groups, baseline", 0.5, 0.8, 0.6, 0.2)
_LONG_S = 120


class Cluster(NamedTuple):
    """A scheduler in this process, and its workers by address: processes of their own."""

    scheduler: Any
    address: str
    workers: dict[str, subprocess.Popen[bytes]]


@pytest.fixture
def two_workers() -> Iterator[Cluster]:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=0, processes=False, dashboard_address=None, protocol="tcp://", host="127.0.0.1"
    ) as local:
        address = local.scheduler_address
        options = "--no-nanny --nthreads 1 --no-dashboard --host 127.0.0.1 --name"
        command = [sys.executable, "-m", "distributed.cli.dask_worker", address, *options.split()]
        started = [
            subprocess.Popen([*command, name], stderr=subprocess.DEVNULL) for name in ("a", "b")
        ]
        try:
            with distributed.Client(address, set_as_default=False) as client:
                client.wait_for_workers(2, timeout=_LONG_S)
            by_name = {each.name: where for where, each in local.scheduler.workers.items()}
            workers = {by_name[name]: each for name, each in zip("ab", started, strict=True)}
            yield Cluster(local.scheduler, address, workers)
        finally:
            for each in started:
                each.kill()
                each.wait()


def when_a_chunk_runs_on(scheduler: Any, worker: str) -> Event:
    """Return what is set once the scheduler has given a chunk to a worker."""
    from distributed import SchedulerPlugin

    given = Event()

    class Watch(SchedulerPlugin):
        def transition(self, key: str, start: str, finish: str, *_: Any, **__: Any) -> None:
            task = scheduler.tasks.get(key)
            if finish == "processing" and task and task.processing_on.address == worker:
                given.set()

    scheduler.add_plugin(Watch())
    return given


@pytest.mark.slow
def test_two_workers_find_what_one_process_does(two_workers: Cluster) -> None:
    with on_cluster(two_workers.address) as compute:
        assert estimate(MODEL, 40, compute=compute) == estimate(MODEL, 40)


@pytest.mark.slow
def test_a_worker_that_is_killed_loses_nothing(two_workers: Cluster) -> None:
    victim = next(iter(two_workers.workers))
    running = when_a_chunk_runs_on(two_workers.scheduler, victim)
    with on_cluster(two_workers.address) as compute, ThreadPoolExecutor(1) as thread:
        # 40 chunks: one thread cannot have run its half before it is killed
        found = thread.submit(estimate, MODEL, 400, draws=40_000, compute=compute)
        assert running.wait(_LONG_S)
        os.kill(two_workers.workers[victim].pid, signal.SIGKILL)
        two_workers.workers[victim].wait()
        survived = found.result(_LONG_S)
    assert victim not in two_workers.scheduler.workers
    assert survived == estimate(MODEL, 400, draws=40_000)


@pytest.mark.slow
def test_a_cluster_with_another_version_is_refused(
    two_workers: Cluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster, "_versions", lambda: "sar-tui 9.9.9 and numpy 0.1")
    with (
        pytest.raises(Failed, match=r"this computer sar-tui 9\.9\.9 and numpy 0\.1: install the"),
        on_cluster(two_workers.address),
    ):
        pass


@pytest.mark.slow
def test_a_scheduler_without_workers_is_refused() -> None:
    distributed = pytest.importorskip("distributed")
    options = {"processes": False, "dashboard_address": None, "protocol": "tcp://"}
    with (
        distributed.LocalCluster(n_workers=0, host="127.0.0.1", **options) as local,
        pytest.raises(Failed, match=r"has no worker\. Start one: dask worker tcp://"),
        on_cluster(local.scheduler_address),
    ):
        pass


@pytest.mark.parametrize("address", ["", "localhost:8786", "tcp://host", "tcp://:1", "http://a:1"])
def test_an_address_that_is_none_is_refused(address: str) -> None:
    with pytest.raises(ClusterRefused, match="--on takes tcp://HOST:PORT"), on_cluster(address):
        pass


def test_without_the_extra_the_sentence_says_how_to_install_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with (
        pytest.raises(ClusterRefused, match=r"Install it with: .*cluster"),
        on_cluster("tcp://127.0.0.1:1"),
    ):
        pass
