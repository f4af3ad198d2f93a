"""The names of the package, their descriptions, and their views in notebooks."""

import inspect

import pytest

import trocar
from trocar import _typed, results


def test_the_top_has_at_most_forty_names():
    assert len(dir(trocar)) <= 40
    assert set(trocar.__all__) <= set(dir(trocar))
    assert all(hasattr(trocar, name) for name in dir(trocar))
    assert isinstance(trocar.Command, type) and issubclass(trocar.warnings.OscillatingWarning, trocar.warnings.TrocarWarning)


@pytest.mark.parametrize("kind", [*(getattr(results, name) for name in results.__all__), *(getattr(trocar, name) for name in trocar.__all__)])
def test_every_public_class_and_property_is_described(kind):
    if not inspect.isclass(kind) or issubclass(kind, dict):
        return
    assert inspect.getdoc(kind), kind
    for name, member in vars(kind).items():
        if not name.startswith("_") and (callable(member) or isinstance(member, property) or inspect.isdatadescriptor(member)):
            is_field = name in getattr(kind, "__dataclass_fields__", {}) or inspect.ismemberdescriptor(member)
            assert is_field or inspect.getdoc(getattr(kind, name)), f"{kind.__name__}.{name}"


def keys(kind):
    return set(kind.__required_keys__) | set(kind.__optional_keys__)


@pytest.mark.parametrize("name", ["paper/augmented", "passivity/long-delay-waves", "hand/perceiving"])
@pytest.mark.filterwarnings("ignore::trocar.warnings.TrocarWarning")
def test_the_types_of_metrics_are_those_of_a_run(name):
    run = trocar.run(name)
    assert set(run.metrics) == keys(_typed.Metrics)
    for given, kind in [(run.events, _typed.Event), (run.ruptures, _typed.Rupture), (run.metrics["alarms"], _typed.Alarm)]:
        assert all(set(one) == keys(kind) for one in given)
    assert set(run.metrics["ports"]) == keys(_typed.PortMetrics) and set(run.metrics["mode_times"]) == keys(_typed.ModeTimes)
    assert run.metrics["link"] is None or set(run.metrics["link"]) == keys(_typed.LinkMetrics)
    assert set(run.metrics["outcome"]) <= keys(_typed.Outcome)


def test_notebooks_show_tables():
    scenario = trocar.Scenario.load("paper/classical", **{"scaling.force": 0.5})
    assert "<td style='text-align:left'>scaling.force</td>" in scenario._repr_html_() and "0.5" in scenario._repr_html_()
    detector = trocar.Detector(0.001, contact_m=0.012)
    assert "estimator.contact_m" in detector._repr_html_() and "0.001 s" in detector._repr_html_()
    for shown in (trocar.compare(), trocar.patients(3), trocar.state_space(scenario, "slave"), trocar.margins(scenario)):
        assert shown._repr_html_().startswith("<table>"), shown


@pytest.mark.parametrize(
    ("call", "text"),
    [
        (lambda: trocar.Scenario.load("paper/classical", **{"scaling.forse": 1}), "--> changes:1:"),
        (lambda: trocar.Scenario.load("paper/classical", **{"zzz.zzz": 1}), r"`trocar.keys\(\)` lists"),
        (lambda: trocar.Scenario.load("nowhere"), r"`trocar.shipped\(\)` lists"),
        (lambda: trocar.sweep("paper/classical", {"scaling.force": [1.0]}, metrics=["zzzzzz"]), r"`trocar.metrics\(\)`"),
        (lambda: trocar.run("builtin:sweeps/small.toml"), r"`trocar.sweep\(\"builtin:sweeps/small.toml\"\)`"),
        (lambda: trocar.sweep("paper/classical", {"scaling.force": [1.0]}, set={"population.arm": "people"}), r"trocar.patients\(200, scenario\)"),
    ],
)
def test_errors_speak_python(call, text):
    with pytest.raises(ValueError, match=text) as caught:
        call()
    assert "`trocar " not in str(caught.value) and "--set" not in str(caught.value)
