"""The sides as python-control sees them."""

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
def test_poles_agree(side, changes):
    system = trocar.state_space(trocar.Scenario.load("paper/classical", **changes), side)
    ours, theirs = np.sort_complex(system.poles()), np.sort_complex(system.to_control().poles())
    # The double zero of a free mass splits by the root of the rounding error; only its pair is compared there.
    free = np.abs(theirs) < 1e-4
    np.testing.assert_allclose(ours[~free], theirs[~free], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(ours[free], theirs[free], atol=1e-4)


@pytest.mark.parametrize("changes", SCENARIOS[:3], ids=str)
@pytest.mark.parametrize("side", ["master", "slave"])
def test_step_responses_agree(side, changes):
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


def test_the_poles_are_those_of_the_independent_computation():
    poles = np.sort_complex(trocar.state_space("paper/classical", "master").poles())
    expected = [-162.41280488, -43.71857234 - 68.79047016j, -43.71857234 + 68.79047016j, -21.02629518, -12.62462369]
    np.testing.assert_allclose(poles, expected, atol=1e-8)
    poles = np.sort_complex(trocar.state_space("paper/classical", "slave").poles())
    np.testing.assert_allclose(poles, [-109.79934886, -55.48532557 - 68.47096846j, -55.48532557 + 68.47096846j], atol=1e-8)


def test_the_static_gain_of_the_slave_is_one():
    gain = trocar.state_space("paper/classical", "slave").to_control().dcgain()
    np.testing.assert_allclose(np.ravel(gain)[0], 1.0, rtol=1e-9)
