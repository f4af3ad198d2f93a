# %% [markdown]
# # Figures 13, 15 and 16 of the paper
# Barbé, Bayle, de Mathelin and Gangi, *In Vivo Model Estimation and Haptic Characterization of Needle Insertions*, on the
# in-vivo-like recording: the paper's own was never published. Forces are positive when they resist insertion; the paper plots
# the opposite sign. Run it cell by cell, or as a script: `python paper_figures.py [FOLDER]` leaves the figures in a folder.

# %%
import sys
from pathlib import Path

import matplotlib.pyplot as plt

import trocar

FOLDER = Path(sys.argv[1]) if len(sys.argv) == 2 and not sys.argv[1].startswith("-") else Path()
RUPTURES_S = [5.52, 8.85]
# Around the first rupture, as the paper's figures 15 and 16.
WINDOW_S = (4.5, 8.0)

# %% [markdown]
# ## Figure 13: the decision function, the insertion's force, and what is detected

# %%
recording = trocar.record()
found = trocar.detect(
    recording["time_s"],
    recording["position_m"],
    recording["velocity_m_per_s"],
    recording["force_n"],
    contact_m=0.012,
    ruptures_s=RUPTURES_S,
)
figure, (top, bottom) = plt.subplots(2, 1, sharex=True, layout="constrained", figsize=(8, 6))
top.plot(found["time_s"], found["decision"])
top.axhline(found.report["settings"]["detector"]["threshold"], color="0.4", linestyle="--", label="threshold γ")
top.set_ylabel("Decision function (N²)")
top.legend()
bottom.plot(found["time_s"], found["measured_force_n"])
for alarm_s in found.alarms_s:
    bottom.axvline(alarm_s, color="tab:red", label=f"rupture detected at {alarm_s:.3f} s")
bottom.set_ylabel("Force (N)")
bottom.set_xlabel("Time (s)")
bottom.legend()
figure.savefig(FOLDER / "figure_13.png", dpi=120)
found

# %% [markdown]
# ## Figures 15 and 16: the same insertion by classical and by augmented teleoperation


# %%
def forces_and_positions(run: trocar.Run, title: str) -> plt.Figure:
    """Forces (left) and positions (right) of master and slave around the first rupture."""
    time_s = run["time_s"]
    shown = (time_s >= WINDOW_S[0]) & (time_s <= WINDOW_S[1])
    figure, (left, right) = plt.subplots(1, 2, layout="constrained", figsize=(11, 4))
    left.plot(time_s[shown], run["feedback_force_n"][shown], label="master: fed back")
    left.plot(time_s[shown], run["operator_force_n"][shown], label="master: hand")
    left.plot(time_s[shown], run["tissue_force_n"][shown], label="slave: tissue")
    right.plot(time_s[shown], 1e3 * run["master_position_m"][shown], label="master")
    right.plot(time_s[shown], 1e3 * run["slave_position_m"][shown], label="slave")
    for event in run.events:
        if WINDOW_S[0] <= event["start_s"] <= WINDOW_S[1]:
            for axis in (left, right):
                axis.axvspan(event["start_s"], event["start_s"] + event["augmented_s"], color="0.85", label="slave frozen")
    left.set_ylabel("Force (N)")
    right.set_ylabel("Position (mm)")
    for axis in (left, right):
        axis.set_xlabel("Time (s)")
        axis.legend()
    figure.suptitle(title)
    return figure


comparison = trocar.compare()
classical, augmented = comparison.runs
forces_and_positions(classical, "Classical force-position teleoperation").savefig(FOLDER / "figure_15.png", dpi=120)
forces_and_positions(augmented, "Event-based haptic augmentation").savefig(FOLDER / "figure_16.png", dpi=120)

# %% [markdown]
# ## The paper's facts beside ours

# %%
for fact in comparison.facts or []:
    print(f"{'yes' if fact['holds'] else 'NO '}  {fact['what']}: {fact['ours']} (paper: {fact['paper']})")
comparison
