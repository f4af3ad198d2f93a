"""Runs the shards of a sweep on executors of other libraries."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

# Runs a named shard with a number of threads.
_Run = Callable[[str, int], Any]


@dataclass(frozen=True)
class Workers:
    """The number of workers, and a function that yields the results of shards, each with its name, in any order."""

    count: int
    run: Callable[[_Run, list[str], int], Iterator[tuple[str, Any]]]


def workers_of(executor: Any) -> Workers | None:
    """Returns the workers of an executor, which its attributes identify; ``None`` without an executor."""
    if executor is None:
        return None
    for attribute, run in (("submit", _submitted), ("n_jobs", _called), ("imap", _mapped), ("remote", _remote)):
        if hasattr(executor, attribute):
            return Workers(_count(executor), functools.partial(run, executor))
    what = "an executor of concurrent.futures, a Dask client, a joblib.Parallel, a multiprocessing.Pool or the module ray"
    raise TypeError(f"executor is {executor!r}, must be {what}")


def _count(executor: Any) -> int:
    if hasattr(executor, "nthreads"):
        return max(1, int(sum(executor.nthreads().values())))
    if hasattr(executor, "cluster_resources"):
        return max(1, int(executor.cluster_resources().get("CPU", 1)))
    for name in ("_max_workers", "_processes", "n_jobs"):
        count = getattr(executor, name, None)
        if isinstance(count, int) and count > 0:
            return count
    return os.cpu_count() or 1


def _submitted(executor: Any, run: _Run, names: list[str], threads: int) -> Iterator[tuple[str, Any]]:
    """Runs shards on ``concurrent.futures`` or Dask."""
    # For Dask: a lost worker counts as an attempt; `retries` is for errors that the shard did not cause.
    options = {"pure": False, "retries": 2} if hasattr(executor, "scheduler_info") else {}
    futures = [executor.submit(_run, run, threads, name, **options) for name in names]
    try:
        for future in futures:
            yield future.result()
    finally:
        for future in futures:
            future.cancel()


def _called(executor: Any, run: _Run, names: list[str], threads: int) -> Iterator[tuple[str, Any]]:
    """Runs shards on joblib, whose calls are tuples of a function and its arguments."""
    return iter(executor((_run, (run, threads, name), {}) for name in names))


def _mapped(executor: Any, run: _Run, names: list[str], threads: int) -> Iterator[tuple[str, Any]]:
    """Runs shards on a pool of ``multiprocessing``."""
    results: Iterator[tuple[str, Any]] = executor.imap(functools.partial(_run, run, threads), names)
    return results


def _remote(ray: Any, run: _Run, names: list[str], threads: int) -> Iterator[tuple[str, Any]]:
    """Runs shards on Ray. A task uses as many processors as it has threads."""
    # A task is a function, so store the method, which holds the sweep, once.
    task, stored = ray.remote(num_cpus=threads)(_run), ray.put(run)
    results = [task.remote(stored, threads, name) for name in names]
    try:
        for result in results:
            yield ray.get(result)
    finally:
        for result in results:
            ray.cancel(result)


def _run(run: _Run, threads: int, name: str) -> tuple[str, Any]:
    return name, run(name, threads)
