"""The certificate of events is verified by the manual's script and by an independent solver."""

import json
import runpy

import numpy as np
import pytest
import trocar
from conftest import REPOSITORY

CONCEPTS = REPOSITORY / "docs" / "src" / "concepts"
SCRIPT = CONCEPTS / "verify_certificate.py"

# A spring and damper replace the recorded force, which closes no loop.
TISSUE = ["--set", "tissue.stiffness_n_per_m=200", "--set", "tissue.damping_n_s_per_m=5"]
SCENARIO = "strategies/snap"


@pytest.fixture(scope="module")
def path(cli, tmp_path_factory):
    """Returns the path of certificate.json of the shipped scenario."""
    folder = tmp_path_factory.mktemp("certificate")
    small = ["--x", "scaling.force=0.1:10:4", "--y", "tissue.stiffness_n_per_m=10:2000:4"]
    done = cli("stability", SCENARIO, *small, "--quiet", "--out", folder)
    assert done.returncode == 0, done.stderr
    return folder / "snap" / "certificate.json"


@pytest.fixture(scope="module")
def written(path):
    """Returns the content of the file."""
    return json.loads(path.read_text())


@pytest.fixture(scope="module")
def verify():
    """Returns the manual's function that verifies the content of a file."""
    return runpy.run_path(str(SCRIPT))["verify"]


def test_python_verifies_the_file_and_refuses_another_scenario(path, written, tmp_path):
    verified = trocar.verify_certificate(path, SCENARIO)
    assert set(verified) == set(written["certificates"])
    assert all(count > 50 for count in verified.values())
    with pytest.raises(ValueError, match="is not the scenario's"):
        trocar.verify_certificate(path, trocar.Scenario.load(SCENARIO, **{"scaling.force": 2.0}))
    written = json.loads(path.read_text())
    del written["certificates"]["statement"]["inequalities"][3]
    forged = tmp_path / "forged.json"
    forged.write_text(json.dumps(written))
    with pytest.raises(ValueError, match="is not the scenario's"):
        trocar.verify_certificate(forged, SCENARIO)


def test_the_script_verifies_the_conditions_that_trocar_verifies(verify, path, written):
    verified = verify(written)
    assert {name: count for name, (count, _) in verified.items()} == trocar.verify_certificate(path, SCENARIO)
    assert set(verified) == {"shortest_dwell", "growth_at_refractory", "statement"}
    assert all(worst > 0 for _, worst in verified.values())


def delete(certificate):
    del certificate["inequalities"][4]


def keep_one(certificate):
    del certificate["inequalities"][1:]


def weaken(certificate):
    certificate["inequalities"][0]["terms"][0]["factor"] *= 1.01


def shorten(certificate):
    next(one for one in certificate["inequalities"] if one["powers"])["powers"][0] += 1


def replace_map(certificate):
    next(one for one in certificate["maps"] if one["name"] == "teleoperation_1")["matrix"][0][0] *= 1.05


def replace_function(certificate):
    certificate["functions"][0]["p"] = (-np.array(certificate["functions"][0]["p"])).tolist()


def claim_less(certificate):
    certificate["choice"]["contraction"] *= 0.9


@pytest.mark.parametrize(
    "forge", [delete, keep_one, weaken, shorten, replace_map, replace_function, claim_less], ids=lambda forge: forge.__name__
)
def test_the_script_refuses_a_forged_certificate(verify, written, forge):
    forged = json.loads(json.dumps(written))
    forge(forged["certificates"]["statement"])
    with pytest.raises(AssertionError):
        verify(forged)


def test_the_script_refuses_another_scenario_and_another_tissue(verify, written):
    with pytest.raises(AssertionError):
        verify(written, "strategies/designed")
    with pytest.raises(AssertionError):
        verify(written | {"stiffness_n_per_m": [0.0, 1e9]})
    with pytest.raises(AssertionError):
        verify(written | {"damping_n_s_per_m": [0.0, 0.0]})


def test_states_have_names_and_units(written):
    states = written["certificates"]["shortest_dwell"]["spaces"]["Frozen"]["states"]
    names = [(state["name"], state["unit"]) for state in states]
    assert names[:4] == [("x_h", "m"), ("v_h", "m/s"), ("x_a", "m"), ("v_a", "m/s")]
    assert names[-2:] == [("held_reference", "m"), ("force_fed_back", "N")]


def best_margin(certificate):
    """Returns the largest common margin of the inequalities of a certificate file, computed by cvxpy."""
    cvxpy = pytest.importorskip("cvxpy")
    scale = {name: np.array(space["scale"]) for name, space in certificate["spaces"].items()}
    functions = [cvxpy.Variable((len(scale[f["space"]]),) * 2, symmetric=True) for f in certificate["functions"]]
    maps = [np.linalg.solve(scale[m["to"]], np.array(m["matrix"]) @ scale[m["from"]]) for m in certificate["maps"]]
    margin = cvxpy.Variable()
    conditions = []
    for inequality in certificate["inequalities"]:
        first, last = inequality["powers"] or (0, 0)
        for power in sorted({first, first + (last - first) // 10, (first + last) // 2, last}):
            total = 0
            for term in inequality["terms"]:
                chain = np.eye(len(scale[inequality["rows"]]))
                for factor in reversed(term["maps"]):
                    step = maps[factor["map"]]
                    chain = (np.linalg.matrix_power(step, power) if factor["is_power"] else step) @ chain
                total = total + term["factor"] * chain.T @ functions[term["function"]] @ chain
            weight = 1.0 if inequality["name"] == "entering" else 0.01
            conditions.append((total + total.T) / 2 >> weight * margin * np.eye(total.shape[0]))
    rows = sum(function.shape[0] for function in functions)
    conditions += [sum(cvxpy.trace(function) for function in functions) == rows, margin <= 1]
    problem = cvxpy.Problem(cvxpy.Maximize(margin), conditions)
    problem.solve(solver="CLARABEL")
    return margin.value


CASES = [
    ((), "50:600", 11),
    ((), "50:1000", 41),
    ((), "50:2000", 315),
    (("scaling.force=2",), "50:600", 42),
    (("scaling.force=4",), "50:600", 172),
]


@pytest.mark.parametrize(("settings", "tissue", "limit_ms"), CASES, ids=str)
def test_an_independent_solver_agrees_on_the_dwell(cli, tmp_path, settings, tissue, limit_ms):
    small = ["--x", "scaling.position=0.9:1:2", "--y", "tissue.stiffness_n_per_m=100:200:2", "--tissue", tissue]
    changes = [word for setting in settings for word in ("--set", setting)]
    done = cli("stability", "paper/augmented", *TISSUE, *small, *changes, "--quiet", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    written = json.loads((tmp_path / "augmented" / "certificate.json").read_text())
    certificate = written["certificates"]["shortest_dwell"]
    assert 1e3 * written["tick_s"] * certificate["choice"]["dwell_ticks"] <= limit_ms
    # The other solver also finds the same conditions feasible.
    assert best_margin(certificate) > 1e-4
