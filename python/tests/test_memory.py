"""The memory that a detection needs beyond its results."""

import subprocess
import sys

import pytest

MEMORY = """
import resource, warnings
import numpy as np
import trocar

samples = 2_000_000
time_s = np.arange(samples) * 1e-3
position_m = 0.01 * (1.0 - np.cos(2.0 * np.pi * time_s / 5.0))
force_n = 300.0 * position_m + 0.02 * np.random.default_rng(1).standard_normal(samples)
velocity_m_per_s = np.gradient(position_m, 1e-3)
warnings.simplefilter("ignore")
# The first call loads modules, whose memory must not count.
trocar.detect(time_s[:100], position_m[:100], velocity_m_per_s[:100], force_n[:100])
peak = lambda: 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
resident = lambda: 4096 * int(open("/proc/self/statm").read().split()[1])
# Occupy memory up to the peak so far. Only the detection can then raise the peak.
held = np.ones(max(peak() - resident(), 0) // 8)
before = peak()
found = trocar.detect(time_s, position_m, velocity_m_per_s, force_n)
results = sum(column.nbytes for column in found.values())
print((peak() - before - results) / samples, results / samples)
"""


@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads /proc")
def test_a_detection_needs_little_memory_beyond_its_results(capsys):
    """At most 250 MB above the columns for 1e7 samples."""
    done = subprocess.run([sys.executable, "-c", MEMORY], capture_output=True, text=True, check=True)
    above, results = map(float, done.stdout.split())
    with capsys.disabled():
        print(f"\ndetect: {results:.0f} bytes of results per sample, and {above:.1f} bytes besides while it runs")
    assert results == 72.0 and above < 25.0
