"""Sweeps over given points, in shards, with a folder, and by any executor give the same rows."""

import concurrent.futures
import multiprocessing
import os
import re
import signal
import subprocess
import sys
import threading
import time
import types

import numpy as np
import pandas as pd
import pytest

import trocar

AXES = {"scaling.force": trocar.Range(0.5, 2.0, 10), "augmentation.reengage": ["ramp", "snap"]}
METRICS = ["detected_ruptures", "false_alarms", "rupture_1_detection_delay_s", "tissue_energy_j"]


def sweep(seeds=4, **how):
    return trocar.sweep("layers/skin-augmented", AXES, seeds=seeds, metrics=METRICS, **how)


def same(one, other):
    assert one.hash == other.hash and one.cases == other.cases and list(one) == list(other)
    for name, column in one.items():
        assert column.dtype == other[name].dtype and column.tobytes() == other[name].tobytes(), name


POINTS = {"scaling.force": [0.5, 1.0, 1.0], "detector.threshold": [0.02, 0.02, 0.05], "augmentation.reengage": ["ramp", "snap", "ramp"]}


@pytest.mark.parametrize(
    "points",
    [POINTS, pd.DataFrame(POINTS), [dict(zip(POINTS, row)) for row in zip(*POINTS.values())]],
    ids=["dictionary", "DataFrame", "list"],
)
def test_points_are_given_in_three_ways(points):
    rows = trocar.sweep("layers/skin-augmented", points=points, seeds=[9, 4], metrics=METRICS)
    assert len(rows) == 6 and rows["seed"].tolist() == [9, 4] * 3
    for key, column in POINTS.items():
        assert rows[key].tolist() == np.repeat(column, 2).tolist()
    # Each case equals the run of its scenario.
    for case in range(6):
        point = {key: rows[key][case].item() for key in POINTS}
        run = trocar.run(trocar.Scenario.load("layers/skin-augmented", **point, **{"simulation.seed": int(rows["seed"][case])}))
        assert run.metrics["tissue_energy_j"] == rows["tissue_energy_j"][case]


@pytest.mark.parametrize(
    ("arguments", "exception", "text"),
    [
        ({"points": {"scaling.force": [1.0, 2.0], "scaling.position": [1.0]}}, ValueError, "scaling.force: 2, scaling.position: 1"),
        ({"points": [{"scaling.force": 1.0}, {"scaling.position": 1.0}]}, ValueError, r"points\[1\] has the keys scaling.position"),
        ({"points": []}, ValueError, "no key"),
        ({"points": [1.0]}, TypeError, "a list of dictionaries"),
        ({"points": {"scaling.force": [1.0, -1.0]}}, trocar.ScenarioError, "scaling.force has -1.0"),
        ({"points": {"scaling.force": [1.0]}, "design": "sobol"}, ValueError, "neither axes nor another design"),
        ({"axes": AXES, "seeds": [1, 1]}, trocar.ScenarioError, "a list of different whole numbers"),
        ({"axes": AXES, "seeds": [1, 2], "first_seed": 3}, trocar.ScenarioError, "first_seed is given, and the seeds are a list"),
        ({"axes": AXES, "executor": 3}, TypeError, "an executor of concurrent.futures"),
        ({"axes": AXES, "shards": 0}, ValueError, "shards is 0"),
    ],
)
def test_invalid_sweeps_are_reported(arguments, exception, text):
    with pytest.raises(exception, match=text):
        trocar.sweep("layers/skin-augmented", **arguments)


def test_shards_join_in_any_order():
    parts = [trocar.sweep("layers/skin-augmented", AXES, seeds=4, metrics=METRICS, shard=f"{part}/3") for part in (2, 3, 1)]
    same(trocar.Sweep.merge(parts), sweep())
    with pytest.raises(ValueError, match="have .* of 80 cases, and 0 of them more than once; give each part once"):
        trocar.Sweep.merge(parts[:2])
    other = trocar.sweep("layers/skin-augmented", AXES, seeds=5, metrics=METRICS, shard="1/3")
    with pytest.raises(ValueError, match="not of the same sweep"):
        trocar.Sweep.merge([*parts[:2], other])
    with pytest.raises(ValueError, match="no part to merge"):
        trocar.Sweep.merge([])


def spawning(workers):
    return concurrent.futures.ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))


def test_every_executor_gives_the_same_bytes():
    joblib = pytest.importorskip("joblib")
    expected = sweep()
    with concurrent.futures.ThreadPoolExecutor(2) as executor:
        same(sweep(executor=executor, shards=3), expected)
    with spawning(2) as executor:
        same(sweep(executor=executor), expected)
    same(sweep(executor=joblib.Parallel(n_jobs=2), shards=5), expected)
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        same(sweep(executor=pool, shards=4), expected)


class LikeRay:
    """Imitates the module ray with threads."""

    def __init__(self):
        self.threads = concurrent.futures.ThreadPoolExecutor(2)
        self.cancelled = 0

    def cluster_resources(self):
        return {"CPU": 2.0, "memory": 1e9}

    def remote(self, num_cpus):
        assert num_cpus == 1
        return lambda function: types.SimpleNamespace(remote=lambda *given: self.threads.submit(function, *given))

    def put(self, value):
        return value

    def get(self, result):
        return result.result()

    def cancel(self, result):
        self.cancelled += 1


def test_ray_gives_the_same_bytes():
    like_ray = LikeRay()
    same(sweep(executor=like_ray, shards=3), sweep())
    assert like_ray.cancelled == 3, "what an interruption leaves is cancelled"
    ray = pytest.importorskip("ray", reason="Ray is large: it is tested where it is installed")
    ray.init(num_cpus=2, include_dashboard=False, log_to_driver=False)
    try:
        same(sweep(executor=ray, shards=3), sweep())
    finally:
        ray.shutdown()


def test_a_sweep_in_a_folder_continues_after_an_interruption(tmp_path):
    expected, folder = sweep(), tmp_path / "sweep"
    same(sweep(folder=folder, shards=4), expected)
    names = sorted(path.name for path in folder.iterdir())
    assert names == [f"shard-{index}-of-4.npz" for index in (1, 2, 3, 4)]
    (folder / "shard-2-of-4.npz").unlink()
    (folder / "shard-3-of-4.npz.partial").write_bytes(b"half of")
    kept = (folder / "shard-1-of-4.npz").stat().st_mtime_ns
    same(sweep(folder=folder), expected)
    assert sorted(path.name for path in folder.iterdir()) == names and (folder / "shard-1-of-4.npz").stat().st_mtime_ns == kept
    same(trocar.Sweep.merge(trocar.Sweep.load(path) for path in folder.iterdir()), expected)
    with pytest.raises(ValueError, match="shards of another sweep"):
        sweep(folder=folder, seeds=5)
    with pytest.raises(ValueError, match="has 4 shards, not 5"):
        sweep(folder=folder, shards=5)
    np.savez(tmp_path / "other.npz", x=np.zeros(2))
    with pytest.raises(ValueError, match="not a sweep that Sweep.save wrote"):
        trocar.Sweep.load(tmp_path / "other.npz")


def test_a_killed_worker_leaves_no_half_file_and_the_sweep_continues(tmp_path):
    """A killed worker breaks the pool of concurrent.futures; complete shards are kept, and the same call finishes the
    rest."""
    expected = sweep(seeds=40)
    with spawning(2) as executor:
        executor.submit(os.getpid).result()
        thread = threading.Thread(target=kill_once_kept, args=(executor, tmp_path))
        thread.start()
        with pytest.raises(concurrent.futures.process.BrokenProcessPool):
            sweep(seeds=40, executor=executor, folder=tmp_path, shards=40)
        thread.join()
    kept = sorted(tmp_path.iterdir())
    assert 0 < len(kept) < 40 and all(path.suffix == ".npz" for path in kept)
    with spawning(2) as executor:
        same(sweep(seeds=40, executor=executor, folder=tmp_path), expected)


def kill_once_kept(executor, folder):
    while not any(folder.glob("shard-*.npz")):
        time.sleep(0.001)
    os.kill(next(iter(executor._processes)), signal.SIGKILL)


def test_a_killed_worker_of_joblib_leaves_no_half_file(tmp_path):
    joblib = pytest.importorskip("joblib")
    from joblib.externals.loky import get_reusable_executor

    expected = sweep(seeds=40)
    with joblib.Parallel(n_jobs=2, return_as="generator") as parallel:
        list(parallel([joblib.delayed(time.sleep)(0.1)] * 2))
        thread = threading.Thread(target=kill_once_kept, args=(get_reusable_executor(2), tmp_path))
        thread.start()
        with pytest.raises(Exception, match="process"):
            sweep(seeds=40, executor=parallel, folder=tmp_path, shards=40)
        thread.join()
    kept = sorted(tmp_path.iterdir())
    assert 0 < len(kept) < 40 and all(path.suffix == ".npz" for path in kept)
    same(sweep(seeds=40, executor=joblib.Parallel(n_jobs=2), folder=tmp_path), expected)


def test_progress_is_shown_with_tqdm_and_without(capsys, monkeypatch):
    pytest.importorskip("tqdm")
    expected = sweep()
    capsys.readouterr()
    same(sweep(progress=True, shards=4), expected)
    assert "80/80" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "tqdm.auto", None)
    same(sweep(progress=True), expected)
    assert capsys.readouterr().err.endswith("80 of 80 cases\n")
    sweep()
    assert capsys.readouterr().err == ""
    trocar.calibrate(trocar.record(), progress=True)
    assert capsys.readouterr().err.endswith("10 of 10 steps\n")


def test_executors_may_return_shards_in_any_order(tmp_path):
    joblib = pytest.importorskip("joblib")

    class Reversing:
        """Imitates joblib, but returns the last result first."""

        n_jobs = 2

        def __call__(self, calls):
            return reversed([function(*arguments, **named) for function, arguments, named in calls])

    expected = sweep()
    for executor in (Reversing(), joblib.Parallel(n_jobs=2, return_as="generator_unordered")):
        folder = tmp_path / type(executor).__name__
        same(sweep(executor=executor, folder=folder, shards=4), expected)
        (folder / "shard-2-of-4.npz").unlink()
        same(sweep(folder=folder), expected)


def test_a_sweep_that_is_too_large_is_refused_at_once():
    with pytest.raises(MemoryError, match="1000000000000 cases take .* GB of memory, more than this machine has"):
        trocar.sweep("paper/augmented", {"scaling.force": trocar.Range(0.5, 1.0, 10**12)})


def test_a_killed_sweep_leaves_nothing_behind(tmp_path):
    code = "import trocar; trocar.sweep('paper/augmented', {'scaling.force': trocar.Range(0.5, 1.0, 100_000)}, progress=True)"
    environment = {**os.environ, "TMPDIR": str(tmp_path)}
    with subprocess.Popen([sys.executable, "-c", code], env=environment, stderr=subprocess.PIPE) as process:
        # Wait for the first progress above 0, with or without tqdm.
        said = b""
        while not re.search(rb"[1-9]\d*(/| of )100000", said):
            letter = process.stderr.read(1)
            assert letter, said
            said += letter
        process.kill()
    assert not list(tmp_path.iterdir())


def test_a_saved_sweep_has_its_scenario(tmp_path):
    swept = trocar.sweep(trocar.Scenario.load("paper/augmented", **{"recording.file": trocar.record(2)}), {"scaling.force": [1.0]})
    swept.save(tmp_path / "sweep.npz")
    again = trocar.Sweep.load(tmp_path / "sweep.npz")
    assert again.scenario == swept.scenario and list(again) == list(swept)
    assert trocar.run(again.scenario).metrics["tracking_rmse_m"] == swept["tracking_rmse_m"][0]
