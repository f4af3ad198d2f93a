"""The schema of every kind of file agrees with files that commands write."""

from __future__ import annotations

import copy
import json
import math
import re
import subprocess
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest

SCENARIO = """
name = "x"
base = "layers/skin-augmented"
[simulation]
duration_s = 2.5
"""
# A certificate of short events takes less time.
SPRING = """
name = "spring"
base = "paper/augmented"
tissue.stiffness_n_per_m = 200
augmentation.min_hold_s = 0.02
augmentation.max_hold_s = 0.05
"""
SWEEP = """
name = "s"
base = "x.toml"
metrics = ["max_excess_advance_m", "false_alarms"]
focus = ["max_excess_advance_m"]
[design]
kind = "sobol"
points = 8
[axes]
scaling.force = { from = 0.5, to = 2.0 }
"""
DESIGN = """
name = "d"
base = "x.toml"
[patients]
operator.movement_s = { from = 4.0, to = 6.0 }
[free]
augmentation.min_hold_s = { from = 0.1, to = 0.4 }
augmentation.reengage = ["ramp", "snap"]
[objectives.overshoot]
minimise = "max_slave_overshoot_m"
[objectives.contrast]
maximise = "min_felt_contrast"
quantile = 0.1
[constraints.force]
metric = "max_tissue_force_n"
at_most = 9.0
[training]
patients = 4
[validation]
patients = 3
seeds = 1
[search]
candidates = 4
generations = 2
"""
AXES = "--x scaling.force=0.1:4:4 --y channel.delay_s=0:0.1:3"

# The kind of a file, the command that writes it, its path, and the kinds and paths of further files.
PRINTED: list[tuple[str, str, str, dict[str, str]]] = [
    ("run", "run x.toml", "out/x/summary.json", {"files": "out/x/manifest.json"}),
    ("run", "run layers/epidural --set channel.delay_s=0.2 --set scaling.force=1000", "out/epidural/summary.json", {}),
    ("run", "run link/long-delay", "out/long-delay/summary.json", {}),
    ("comparison", "compare", "out/compare/comparison.json", {"files": "out/compare/manifest.json"}),
    ("comparison", "compare x.toml layers/epidural --seeds 2", "out/compare/comparison.json", {}),
    ("comparison", "strategies --schemes x.toml", "out/strategies/comparison.json", {}),
    ("strategies", "strategies x.toml --seeds 2", "out/strategies/strategies.json", {}),
    ("detection", "detect a/two.csv --no-figures", "out/two/detection.json", {}),
    ("detection", "detect a/two.csv --no-figures --rupture-s 0.5 --rupture-s 1", "out/two/detection.json", {}),
    ("detections", "detect a --no-figures", "out/detect/detections.json", {}),
    ("calibration", "calibrate paper/augmented", "out/augmented/calibration.json", {}),
    (
        "identification",
        "identify machine.csv --time t --master m --slave s --force f --no-figures",
        "out/machine/identification.json",
        {},
    ),
    ("roc", "roc x.toml --seeds 2 --thresholds 3", "out/roc/roc.json", {}),
    ("sweep", "sweep s.toml", "out/s/summary.json", {"manifest": "out/s/manifest.json"}),
    ("design", "design d.toml --no-figures", "out/d/design.json", {}),
    ("stability", f"stability {AXES}", "out/depth-classical/stability.json", {}),
    (
        "stability",
        f"stability spring.toml {AXES} --z-width 0:10:3 --arms 8 --simulate --absolute channel.delay_s=0:0.05:3 "
        "--hand 1:50 --tissue 50:400 --event-limits",
        "out/spring/stability.json",
        {"certificate": "out/spring/certificate.json"},
    ),
]

# The outputs of commands that do not print a file.
OTHERS = [
    ("paper", "paper --quiet", "out/paper/paper.json"),
    ("signals", "detect --list a/two.csv --json", None),
    ("check", "check x.toml s.toml d.toml link/long-delay paper/augmented --json", None),
    ("scenarios", "scenarios --json", None),
]

OPTIONAL = {
    "also", "further_estimate", "is_jitter_unlimited", "jitter_s", "jitter_ticks", "missed", "schemes", "seeds",
    "source", "spaces", "warnings",
}  # fmt: skip
# The objects whose keys are names or settings.
NAMES = {"certificates", "files", "parameters", "spaces", "settings", "sensitivities", "missed"}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    texts = {"x.toml": SCENARIO, "spring.toml": SPRING, "s.toml": SWEEP, "d.toml": DESIGN}
    for name, text in texts.items():
        (tmp_path / name).write_text(text)

    # A slave that follows its master with a delay, against a spring.
    def place(t: float) -> float:
        return 0.01 * math.sin(9 * t)

    rows = ["t,m,s,f"]
    for t in (k * 1e-3 for k in range(600)):
        slave = place(t - 0.01)
        rows.append(f"{t:.3f},{place(t):.7f},{slave:.7f},{300 * max(slave, 0):.5f}")
    (tmp_path / "machine.csv").write_text("\n".join(rows) + "\n")
    rows = ["time_s,position_m,force_n"]
    for t in (k * 1e-3 for k in range(1500)):
        since = 1.0 if t > 1 else 0.0
        rows.append(f"{t:.3f},{1e-2 * t:.6f},{3 * (t - 0.95 * since):.4f}")
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "two.csv").write_text("\n".join(rows) + "\n")
    (tmp_path / "a" / "bad.csv").write_text("time_s,position_m,force_n\n0,0,0\n0.001,soft,0\n")
    return tmp_path


def validator(cli: Any, kind: str) -> jsonschema.Draft202012Validator:
    return jsonschema.Draft202012Validator(json.loads(cli("schema", kind).stdout))


def objects(value: Any, place: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Yields the places of the objects of a value; of a list, those of its first entry."""
    if isinstance(value, dict):
        yield place
        for key, part in value.items():
            yield from objects(part, (*place, key))
    elif isinstance(value, list) and value:
        yield from objects(value[0], (*place, 0))


def changed(content: Any, place: tuple[str | int, ...]) -> tuple[Any, dict[str, Any]]:
    """Returns a copy, and its object at a place."""
    whole = part = copy.deepcopy(content)
    for key in place:
        part = part[key]
    return whole, part


def check(schema: jsonschema.Draft202012Validator, content: Any) -> None:
    """Checks that a file has the keys of its schema, and that the schema rejects an unknown and a missing key."""
    assert [error.message[:300] for error in schema.iter_errors(content)] == []
    for place in objects(content):
        more, part = changed(content, place)
        part["unknown"] = {"unknown": {}}
        assert not schema.is_valid(more), f"an unknown key at {place}"
        if NAMES.intersection(place):
            continue
        for key in set(part) - OPTIONAL - {"unknown"}:
            less, part_of_less = changed(content, place)
            del part_of_less[key]
            assert not schema.is_valid(less), f"{place} without {key}"


@pytest.mark.parametrize(("kind", "command", "file", "further"), PRINTED, ids=[case[1] for case in PRINTED])
def test_a_file_has_the_keys_of_its_schema_and_json_prints_the_same_bytes(
    cli: Any, folder: Path, kind: str, command: str, file: str, further: dict[str, str]
) -> None:
    printed = cli(*command.split(), "--json", cwd=folder).stdout
    assert printed == (folder / file).read_text()
    check(validator(cli, kind), json.loads(printed))
    for kind, path in further.items():
        check(validator(cli, kind), json.loads((folder / path).read_text()))


@pytest.mark.parametrize(("kind", "command", "file"), OTHERS, ids=[case[1] for case in OTHERS])
def test_other_files_and_outputs_have_the_keys_of_their_schema(
    cli: Any, folder: Path, kind: str, command: str, file: str | None
) -> None:
    ended = cli(*command.split(), cwd=folder)
    assert ended.returncode == 0, ended.stderr
    check(validator(cli, kind), json.loads((folder / file).read_text() if file else ended.stdout))


def test_the_summary_of_a_link_has_the_keys_of_its_schema(cli: Any, binary: Path, folder: Path) -> None:
    def start(*side: str) -> subprocess.Popen[str]:
        command = [str(binary), "link", *side, "x.toml", "--json"]
        return subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)

    slave = start("slave", "--listen", "127.0.0.1:0")
    assert slave.stderr
    address = next(word[:-1] for word in slave.stderr.readline().split() if word.endswith(";"))
    for side, process in {"master": start("master", "--to", address), "slave": slave}.items():
        printed = process.communicate()[0]
        assert printed == (folder / "out" / "x" / side / "summary.json").read_text()
        check(validator(cli, "link"), json.loads(printed))


def test_scenario_sweep_and_design_files_have_the_keys_of_their_schema(cli: Any, folder: Path) -> None:
    for kind, file in {"scenario": "x.toml", "sweep-file": "s.toml", "design-file": "d.toml"}.items():
        content = tomllib.loads((folder / file).read_text())
        schema = validator(cli, kind)
        assert schema.is_valid(content)
        assert not schema.is_valid(content | {"unknown": 1})
    assert cli("schema").stdout == cli("schema", "scenario").stdout


def described(schema: Any, place: str) -> None:
    """Checks that every property has a description, a type with a description, or a single value."""
    if isinstance(schema, list):
        for part in schema:
            described(part, place)
    if not isinstance(schema, dict):
        return
    for key, part in schema.get("properties", {}).items():
        is_described = bool({"description", "$ref", "const"}.intersection(part)) or "$ref" in part["anyOf"][0]
        assert is_described, f"{place}: {key} has no description"
    for key, part in schema.items():
        described(part, f"{place}/{key}")


def test_every_kind_is_tested_and_every_key_has_a_meaning(cli: Any) -> None:
    listed = re.findall(r"^ +- ([a-z-]+):", cli("schema", "--help").stdout, re.MULTILINE)
    further = {kind for case in PRINTED for kind in case[3]}
    tested = {case[0] for case in PRINTED} | further | {case[0] for case in OTHERS}
    assert set(listed) == tested | {"link", "scenario", "sweep-file", "design-file"}
    completions = cli("completions", "bash").stdout
    for kind in listed:
        assert kind in completions
        schema = json.loads(cli("schema", kind).stdout)
        assert schema["title"] == f"trocar {kind}"
        # The keys of an axis are the same everywhere, and the manual explains them.
        if kind not in ("sweep-file", "design-file"):
            described(schema, kind)
