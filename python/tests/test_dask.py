"""Sweeps on a cluster of processes on this machine."""

import os
import signal
import threading
import time

import numpy as np
import pytest

import trocar

distributed = pytest.importorskip("distributed")

AXES = {"scaling.force": trocar.Range(0.5, 2.0, 10), "augmentation.reengage": ["ramp", "snap"]}
METRICS = ["detected_ruptures", "false_alarms", "rupture_1_detection_delay_s", "tissue_energy_j"]


def sweep(**where):
    return trocar.sweep("layers/skin-augmented", AXES, seeds=40, metrics=METRICS, **where)


def same(one, other):
    assert one.hash == other.hash and list(one.columns) == list(other.columns)
    for name, column in one.columns.items():
        if column.dtype.kind == "f":
            np.testing.assert_array_equal(column.view(np.int64), other[name].view(np.int64), err_msg=name)
        else:
            np.testing.assert_array_equal(column, other[name], err_msg=name)


@pytest.fixture(scope="module")
def cluster():
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        with distributed.Client(cluster) as client:
            yield client


def test_a_killed_worker_loses_no_case(cluster, capsys):
    begun = time.monotonic()
    expected = sweep()
    alone_s = time.monotonic() - begun
    workers = cluster.run(os.getpid)
    assert len(workers) == 2
    killed = []

    def kill():
        # Kill midway, when some shards are complete and others are not.
        time.sleep(0.5 * alone_s)
        pid = next(iter(workers.values()))
        os.kill(pid, signal.SIGKILL)
        killed.append(time.monotonic())

    thread = threading.Thread(target=kill)
    thread.start()
    begun = time.monotonic()
    found = sweep(client=cluster, shards=16)
    ended = time.monotonic()
    lasted_s = ended - begun
    thread.join()
    assert begun < killed[0] < ended
    assert set(cluster.run(os.getpid).values()) != set(workers.values())
    with capsys.disabled():
        print(f"\n800 cases: {alone_s:.2f} s on one machine, {lasted_s:.2f} s over two workers of which one was killed")
    same(found, expected)


def test_the_result_does_not_depend_on_the_number_of_shards(cluster):
    expected = sweep()
    for shards in (1, 3, 150):
        same(sweep(client=cluster, shards=shards), expected)
    same(sweep(threads=1), expected)
    with pytest.raises(ValueError, match="shards is 0"):
        sweep(client=cluster, shards=0)


def test_errors_arrive_unchanged(cluster):
    with pytest.raises(trocar.ScenarioError, match="each must be a number"):
        trocar.sweep("paper/augmented", {"scaling.force": [-1.0]}, client=cluster, shards=2)
