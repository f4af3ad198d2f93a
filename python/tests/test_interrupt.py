"""Ctrl-C ends every long call and its background work."""

import os
import signal
import threading
import time

import numpy as np
import pytest

import trocar


def recording(samples):
    time_s = np.arange(samples) * 1e-3
    position = 0.01 * (1.0 - np.cos(2.0 * np.pi * time_s / 5.0))
    force = 300.0 * position + 0.02 * np.random.default_rng(1).standard_normal(samples)
    return time_s, position, np.gradient(position, 1e-3), force


def stability():
    trocar.stability("paper/augmented", x="scaling.force=0.1:10:2000", y="tissue.stiffness_n_per_m=10:2000:2000")


def compare():
    trocar.compare("paper/augmented", seeds=10_000)


def sweep():
    trocar.sweep("paper/augmented", {"detector.threshold": trocar.Range(1e-3, 1e-1, 1000)}, seeds=1000)


def calibrate():
    trocar.calibrate(*LONG, first_s=8000.0)


def detect():
    trocar.detect(*LONG)


def roc():
    trocar.roc(seeds=100_000)


def roc_of_a_user_defined_detector():
    trocar.roc(detectors={"mine": lambda *evidence: False}, seeds=100_000)


def steps():
    for _ in range(20):
        trocar.Detector(1e-3).steps(*LONG[1:])


def step_response():
    trocar.state_space("paper/classical", "slave").step_response(samples=20_000_000)


LONG = recording(8_000_000)


@pytest.fixture(autouse=True)
def interruptible():
    """Restores Ctrl-C, because a shell that runs its tests in the background ignores it and the tests inherit
    that."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize("call", [stability, compare, sweep, calibrate, detect, roc, roc_of_a_user_defined_detector, steps, step_response])
def test_ctrl_c_ends_a_long_call_and_its_work(call):
    timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
    timer.start()
    was_long = True
    with pytest.raises(KeyboardInterrupt):
        call()
        was_long = False
        timer.join()
        time.sleep(1.0)
    assert was_long
    # The work has half a second to end. Work that continued would use one or two seconds of processor time per
    # second.
    time.sleep(0.5)
    before = time.process_time()
    time.sleep(1.0)
    assert time.process_time() - before < 0.1
    timer.join()
