"""The sides and the loop agree with python-control."""

import json

import control
import numpy as np
import pytest

import trocar

SCENARIOS = [
    {},
    {"master.coupling": "as-printed"},
    {"slave.damping": "as-printed"},
    {"simulation.control": "sampled"},
    {"arm.grip": "firm"},
]


@pytest.mark.parametrize("changes", SCENARIOS, ids=str)
@pytest.mark.parametrize("side", ["master", "slave"])
def test_the_poles_agree_with_python_control(side, changes):
    system = trocar.state_space(trocar.Scenario.load("paper/classical", **changes), side)
    ours, theirs = np.sort_complex(system.poles()), np.sort_complex(system.to_control().poles())
    # The double pole at zero of a free mass splits by the square root of the rounding error, so only other poles are
    # compared.
    free = np.abs(theirs) < 1e-4
    np.testing.assert_allclose(ours[~free], theirs[~free], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(ours[free], theirs[free], atol=1e-4)


@pytest.mark.parametrize("changes", SCENARIOS[:3], ids=str)
@pytest.mark.parametrize("side", ["master", "slave"])
def test_the_step_responses_agree_with_python_control(side, changes):
    system = trocar.state_space(trocar.Scenario.load("paper/classical", **changes), side)
    theirs = system.to_control()
    for index, name in enumerate(system.inputs):
        time_s, outputs = system.step_response(index, tick_s=1e-3, samples=500)
        response = control.step_response(theirs, time_s, input=index, squeeze=False)
        expected = response.outputs[:, 0, :]
        scale = max(1.0, np.abs(expected).max())
        assert np.abs(outputs - expected).max() < 1e-9 * scale, name
    assert theirs.input_labels == system.inputs and theirs.output_labels == system.outputs
    assert theirs.state_labels == system.states


def test_the_poles_agree_with_the_independent_computation():
    poles = np.sort_complex(trocar.state_space("paper/classical", "master").poles())
    expected = [-162.41280488, -43.71857234 - 68.79047016j, -43.71857234 + 68.79047016j, -21.02629518, -12.62462369]
    np.testing.assert_allclose(poles, expected, atol=1e-8)
    poles = np.sort_complex(trocar.state_space("paper/classical", "slave").poles())
    np.testing.assert_allclose(poles, [-109.79934886, -55.48532557 - 68.47096846j, -55.48532557 + 68.47096846j], atol=1e-8)


def test_the_static_gain_of_the_slave_is_one():
    gain = trocar.state_space("paper/classical", "slave").to_control().dcgain()
    np.testing.assert_allclose(np.ravel(gain)[0], 1.0, rtol=1e-9)


ARCHITECTURES = ["position-force", "local-force", "position-position", "four-channel"]
DELAYS = [{}, {"channel.forward_delay_s": 0.005, "channel.backward_delay_s": 0.003}, {"channel.forward_delay_s": 0.0025}]
FREQUENCIES_HZ = np.geomspace(0.1, 400.0, 60)


@pytest.mark.parametrize("delay", DELAYS, ids=str)
@pytest.mark.parametrize("kind", ARCHITECTURES)
def test_the_loop_agrees_with_python_control(kind, delay):
    scenario = trocar.Scenario.load("paper/classical", **{"controller.kind": kind}, **delay)
    gain, closed = (trocar.state_space(scenario, side) for side in ("loop-gain", "closed-loop"))
    theirs = gain.to_control()
    assert theirs.dt == gain.tick_s == scenario["simulation.tick_s"]
    omega = 2 * np.pi * FREQUENCIES_HZ
    expected = theirs(np.exp(1j * omega * gain.tick_s))
    np.testing.assert_allclose(gain.frequency_response(FREQUENCIES_HZ), expected, rtol=1e-9)
    # Positive feedback around the loop gain gives the poles of the closed loop. The delays add poles at 0, which
    # rounding spreads, so only poles well away from 0 are compared.
    ours = np.sort_complex(closed.poles())
    around = np.sort_complex(control.feedback(theirs, 1, sign=1).poles())
    ours, around = (values[np.abs(values) > 0.7] for values in (ours, around))
    np.testing.assert_allclose(ours, around, rtol=1e-9, atol=1e-9)
    responses = closed.to_control()(np.exp(1j * omega * gain.tick_s), squeeze=False)
    for output in range(3):
        np.testing.assert_allclose(closed.frequency_response(FREQUENCIES_HZ, output=output), responses[output, 0], rtol=1e-9)


@pytest.mark.parametrize("delay", DELAYS, ids=str)
@pytest.mark.parametrize("kind", ARCHITECTURES)
def test_the_margins_agree_with_python_control(kind, delay):
    scenario = trocar.Scenario.load("paper/classical", **{"controller.kind": kind}, **delay)
    margins = trocar.stability(scenario, x="scaling.force=0.9:1:2", y="scaling.position=0.9:1:2").report["margins"]
    theirs = trocar.state_space(scenario, "loop-gain").to_control()
    at = lambda hertz: theirs(np.exp(2j * np.pi * hertz * theirs.dt))  # noqa: E731
    if margins["gain"] is not None:
        # The loop gain times the margin is 1.
        assert abs(margins["gain"] * at(margins["gain_frequency_hz"]) - 1) < 1e-9
    if margins["phase_rad"] is not None:
        gain = at(margins["phase_frequency_hz"])
        assert abs(abs(gain) - 1) < 1e-9
        assert abs(abs(np.angle(gain)) - margins["phase_rad"]) < 1e-9


FEW = {"x": "scaling.force=0.1:10:5", "y": "tissue.stiffness_n_per_m=10:2000:5"}


@pytest.mark.parametrize("changes", [{}, {"master.force_integral_gain": 3.0, "scaling.force": 2.0}], ids=str)
def test_the_damping_that_a_hand_needs_agrees_with_the_two_port(changes):
    tissue = {"tissue.stiffness_n_per_m": 200.0, "tissue.damping_n_s_per_m": 5.0}
    scenario = trocar.Scenario.load("paper/classical", **tissue, **changes)
    report = trocar.stability(scenario, tissue=(50.0, 600.0), **FEW).report
    bounded = report["ports"]["bounded"]
    tick_s, mass_kg, damping, scale = 1e-3, 0.245, 4.1, changes.get("scaling.force", 1.0)
    s = 2j * np.pi * 0.1 * 2500 ** (np.arange(400) / 399)
    slave = trocar.state_space(scenario, "slave")
    column = slave.inputs.index("reference_m") if "reference_m" in slave.inputs else 0
    follow = np.array([(slave.C[0] @ np.linalg.solve(f * np.eye(len(slave.A)) - slave.A, slave.B[:, column])) for f in s])
    hold = (1 - np.exp(-s * tick_s)) / (s * tick_s)
    own = (mass_kg * s + damping) / (1 + changes.get("master.force_integral_gain", 12.0) / s)
    low, high = bounded["stiffness_n_per_m"]
    # The felt impedance is linear in the stiffness, so the worst case is at one end of the range.
    felt = [own + scale * follow * hold**2 * (report["damping_n_s_per_m"] + k / s) for k in (low, high)]
    needed = np.maximum(0, -np.min(np.real(felt), axis=0))
    assert bounded["needed_hand_damping_n_s_per_m"] == pytest.approx(needed.max(), rel=1e-9)
    assert bounded["frequency_hz"] == pytest.approx(s[needed.argmax()].imag / (2 * np.pi), rel=1e-9)


def test_the_smallest_limit_of_a_population_is_where_its_loop_becomes_unstable():
    people = {"population.arm": "people", "population.size": 20}
    scenario = trocar.Scenario.load("passivity/late-wall", **people)
    population = trocar.stability(scenario, **FEW).report["population"]
    found = population["smallest_found"]
    arm = {"k_a": "k_a_n_per_m", "b_a": "b_a_n_s_per_m", "k_h": "k_h_n_per_m", "b_h": "b_h_n_s_per_m", "m_h": "m_h_kg"}
    values = {"k_a": 733.0, "b_a": 37.3, "k_h": 14998.0, "b_h": 178.0, "m_h": 1.88}
    changes = {f"arm.{key}": values[name] * found["arm_factors"][name] for name, key in arm.items()}
    for factor, is_stable in [(1 - 1e-5, True), (1 + 1e-5, False)]:
        stiffness = {"tissue.stiffness_n_per_m": factor * found["max_stiffness_n_per_m"]}
        closed = trocar.state_space(trocar.Scenario.load("passivity/late-wall", **changes, **stiffness), "closed-loop")
        assert (np.abs(np.linalg.eigvals(closed.A)).max() < 1) == is_stable
    quantiles = [one["value"] for one in population["limits"][2]["quantiles"]]
    assert quantiles == sorted(quantiles) and found["max_stiffness_n_per_m"] <= quantiles[0]



SCALES = [0.7, 1.0, 2.3]


def radius_at(gain, change=1.0):
    """Returns the spectral radius of the loop closed with a changed gain."""
    return np.abs(np.linalg.eigvals(gain.A + change * gain.B @ gain.C)).max()


@pytest.mark.parametrize("name", sorted(name for name in trocar.shipped() if "sweeps/" not in name))
def test_poles_and_margins_of_every_shipped_loop_agree_with_its_verdict(name, cli):
    for scale in SCALES:
        checked = cli("check", name, "--set", f"scaling.force={scale}", "--json")
        (checked,) = json.loads(checked.stdout)
        verdict = checked["loop"]
        scenario = trocar.Scenario.load(name, **{"scaling.force": scale})
        closed, gain = trocar.state_space(scenario, "closed-loop"), trocar.state_space(scenario, "loop-gain")
        radius = np.abs(np.linalg.eigvals(closed.A)).max()
        assert radius == pytest.approx(verdict["mode"]["spectral_radius"], rel=1e-9)
        assert verdict["is_linear_loop_stable"] == (radius < 1)
        margin = verdict["margins"]["gain"]
        if margin is not None:
            assert radius_at(gain, margin) == pytest.approx(1, abs=1e-9)
            assert radius_at(gain, margin * (1 + 1e-6)) > 1
            assert all(radius_at(gain, change) < 1 for change in np.linspace(1, margin, 12)[:-1])


def test_python_control_misses_crossings_at_zero_frequency(cli):
    """The manual states that python-control's gain margin of a sampled loop can be below the first gain that
    destabilises it."""
    (checked,) = json.loads(cli("check", "link/four-channel", "--json").stdout)
    ours = checked["loop"]["margins"]["gain"]
    gain = trocar.state_space("link/four-channel", "loop-gain")
    theirs = control.stability_margins(-gain.to_control())[0]
    assert radius_at(gain, 0.999 * ours) < 1 < radius_at(gain, 1.001 * ours)
    assert abs(theirs - ours) > 0.1
