"""Verifies the proof for a kept gap in certificate.json again: python verify_kept_gap.py FILE"""

import json
import sys

import numpy as np


def bounds_of(impulse, low, high):
    """The range of a response to inputs in ranges: impulse by tick, signal and input."""
    signs = np.maximum(impulse, 0), np.minimum(impulse, 0)
    ends = ((low, high), (high, low))
    return np.array([sum(np.einsum("tsi,ti->s", h, w) for h, w in zip(signs, end)) for end in ends])


def verify(proof):
    """Returns the bounds of the growth per event at the certified dwell and at the refractory time."""
    scale = {name: np.array(space["scale"]) for name, space in proof["spaces"].items()}
    scaled = lambda entry: np.linalg.solve(scale[entry["to"]], np.array(entry["matrix"]) @ scale[entry["from"]])
    maps = {entry["name"]: scaled(entry) for entry in proof["maps"]}
    along, rest, ticks, blend = np.array(proof["along"]), np.array(proof["rest"]), proof["ticks"], proof["blend_ticks"]
    n, start, newton = len(along), np.append(along, 1.0), scale["FadingGap"][-2, -2]
    # The signals p and q of the force and of the hand, and the reference that an alarm holds.
    pairs = [(maps[name + "_0"][0], maps[name + "_1"][0]) for name in ("force", "hand")]
    signals = [row for soft, stiff in pairs for row in (soft, stiff - soft)]
    signals = np.array([*signals, maps["alarm_0"][n], maps["alarm_1"][n]])
    inputs = np.hstack([maps["of_force"], maps["of_reference"]])

    # The tissue's stiffness is a share of its range; the loop at two shares is the nominal one.
    shares, impulses, free, reach, sizes = (0.0, 0.5), [], [], np.zeros(n), np.zeros((n, 2))
    for share in shares:
        a = (1 - share) * maps["teleoperation_0"] + share * maps["teleoperation_1"]
        powers = [np.eye(n + 1)]
        for _ in range(1, ticks):
            powers.append(a @ powers[-1])
        rows = signals @ np.array(powers)
        impulses.append(rows @ inputs)
        spread = np.abs(rows[:, :, :n]) @ rest[:n]
        free.append(np.stack([rows @ start - spread, rows @ start + spread], axis=1))
    for power in powers:
        reach = np.maximum(reach, np.abs(power @ start)[:n] + np.abs(power[:n, :n]) @ rest[:n])
        sizes += np.abs(power @ inputs)[:n]
    ranges, tracked = np.zeros((2, 2, ticks, 2)), []
    for tick in range(ticks):
        both = [free[k][tick] + bounds_of(impulses[k][:tick][::-1], *ranges[k, :, :tick]) for k in range(2)]
        low, high = np.maximum(both[0][0], both[1][0]), np.minimum(both[0][1], both[1][1])
        tracked.append(np.maximum(np.abs(low), np.abs(high)))
        tracked[-1][0] = max(abs(low[0] + min(low[1], 0)), abs(high[0] + max(high[1], 0)))
        weight = (lambda u: u * u * (3 - 2 * u))(min((tick + 1) / blend, 1.0))
        for k, share in enumerate(shares):
            products = lambda factors, at: [f * end for f in factors for end in (low[at], high[at])]
            force, hand = products((-share, weight - share), 1), products((-share, 1 - share), 3)
            away, faded = products((weight - 1,), 0), (1 - weight) * rest[n] * newton
            ranges[k, :, tick, 0] = min(force) + min(away) - faded, max(force) + max(away) + faded
            ranges[k, :, tick, 1] = min(hand), max(hand)
    # The bounds have settled, and motions without a gap decay.
    tracked = np.array(tracked)
    assert np.allclose(tracked[ticks // 2], tracked[-1], rtol=1e-3, atol=1e-9)
    assert np.max(np.abs(np.linalg.eigvals(np.abs(impulses[1][:, [1, 3]]).sum(axis=0) / 2))) < 1
    # What a freeze leaves of the states at an alarm.
    states = np.append(reach + sizes @ np.abs(ranges[1]).max(axis=(0, 1)), 1.0)
    at_alarm = np.maximum(np.abs(maps["alarm_0"]) @ states, np.abs(maps["alarm_1"]) @ states)
    at_alarm[: n + 1] = [*states[:n], tracked[:, 4:].max()]
    at_alarm[n + 1 :] = np.minimum(at_alarm[n + 1 :], tracked[:, 0].max() / newton)
    growth = np.zeros(2)
    for held in range(proof["held_ticks"][0], proof["held_ticks"][1] + 1):
        frozen = np.linalg.matrix_power(maps["frozen"], held)
        for release in (maps["release_0"] @ frozen, maps["release_1"] @ frozen):
            left = release - np.outer(np.append(along, [0, 0]), np.eye(len(at_alarm))[n])
            assert np.all(np.abs(left[: n + 1]) @ at_alarm <= max(proof["growth"]) * rest), held
            for k, dwell in enumerate(proof["dwell_ticks"]):
                begin = np.array([*at_alarm[:n], tracked[blend + dwell - 1 :, 4:].max(), *at_alarm[n + 1 :]])
                growth[k] = max(growth[k], np.abs(release[n + 1]) @ begin)
    assert np.all(growth < 1) and np.allclose(growth, proof["growth"], rtol=1e-5), growth
    return growth


if __name__ == "__main__":
    with open(sys.argv[1], encoding="utf-8") as file:
        print("growth per event:", verify(json.load(file)["certificates"]["kept_gap"]))
