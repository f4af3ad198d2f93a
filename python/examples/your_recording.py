# %% [markdown]
# # A detector, evaluated on your recording
# `python your_recording.py FILE.csv`, or set `FILE`, the columns and their factors into SI in the first cell and go on cell by
# cell. Positions must grow into the tissue, forces must be positive when they resist insertion: a negative factor turns a sign.

# %%
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import trocar

# A real hand that presses a lever of 0.075 m through a virtual layer, which gives way 1.7790 s after the first sample.
SHIPPED = Path(__file__).resolve().parents[2] / "scenarios" / "recordings" / "own_ctrl_pop.csv"
FILE = Path(sys.argv[1]) if len(sys.argv) == 2 and sys.argv[1].endswith(".csv") else SHIPPED
TIME, POSITION, VELOCITY, FORCE = ("t_s", 1.0), ("xs_rad", 0.075), ("vs_rad_s", 0.075), ("env_out_Nm_derived", 1 / 0.075)
CONTACT_M = 0.0063
RUPTURES_S = [1.7790]  # in s after the first sample; empty if the recording has no label

# %%
table = np.genfromtxt(FILE, delimiter=",", names=True)
time, position, velocity, force = (factor * table[name] for name, factor in (TIME, POSITION, VELOCITY, FORCE))
print(f"{FILE.name}: {len(time)} samples over {time[-1] - time[0]:.3f} s, forces from {force.min():.2f} to {force.max():.2f} N")

# %% [markdown]
# ## With the paper's settings

# %%
found = trocar.detect(time, position, velocity, force, contact_m=CONTACT_M, ruptures_s=RUPTURES_S, name=FILE.stem)
print(found)
found.plot()

# %% [markdown]
# ## How much the threshold matters
# Alarms that announce no rupture against ruptures that are found, over two decades of thresholds.

# %%
thresholds = np.geomspace(2e-3, 2e-1, 21)
reports = [
    trocar.detect(
        time, position, velocity, force, contact_m=CONTACT_M, ruptures_s=RUPTURES_S, **{"detector.threshold": threshold}
    ).report
    for threshold in thresholds
]
alarms = [len(report["alarms"]) for report in reports]
figure, axis = plt.subplots(layout="constrained")
axis.semilogx(thresholds, alarms, drawstyle="steps-mid", label="alarms")
axis.semilogx(thresholds, [report["false_alarms"] or 0 for report in reports], drawstyle="steps-mid", label="of them false")
axis.set_xlabel("Threshold (N²)")
axis.set_ylabel("Count")
axis.legend()

# %% [markdown]
# ## Settings from the recording's own beginning
# For an hour between false alarms. What is found in the rest of the recording says whether they are any good.

# %%
calibration = trocar.calibrate(time, position, velocity, force, first_s=1.6, contact_m=CONTACT_M)
calibrated = trocar.detect(time, position, velocity, force, ruptures_s=RUPTURES_S, **calibration.settings)
print(calibration.toml)
for alarm in calibrated.report["alarms"]:
    delay = "announces none" if alarm["delay_s"] is None else f"{1e3 * alarm['delay_s']:.1f} ms after the rupture"
    print(f"alarm at {alarm['time_s']:.4f} s: {delay}")
calibrated
