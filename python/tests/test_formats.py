"""Recordings in file formats of other programs: the same samples, the same alarms, and errors for damaged files."""

from __future__ import annotations

import json
import random
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import openpyxl
import pyarrow
import pyarrow.parquet
import pytest
import scipy.io
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from mcap_ros2.writer import Writer as RosWriter
from nptdms import ChannelObject, TdmsWriter

import trocar

Cli = Callable[..., subprocess.CompletedProcess[str]]

ROWS = 3000

#: The names of the signals in a file, for column 0 of two columns and for a plain column.
Names = dict[str, str]


def samples() -> dict[str, np.ndarray]:
    """Returns an insertion at 10 mm/s into 300 N/m with a rupture at 1.5 s and noise."""
    noise = np.random.default_rng(1).normal(0.0, 0.01, ROWS)
    time = np.arange(ROWS) * 1e-3
    force = np.where(time < 1.5, 3.0 * time, 3.0 * (time - 1.425)) + noise
    return {"t": time, "x": 10.0 * time, "f": force}


def write_csv(path: Path, data: dict[str, np.ndarray]) -> Names:
    rows = "\n".join(",".join(map(repr, map(float, row))) for row in zip(*data.values()))
    path.write_text("t,x,f\n" + rows + "\n")
    return {"t": "t", "x": "x", "f": "f"}


def write_german(path: Path, data: dict[str, np.ndarray]) -> Names:
    rows = "\n".join(";".join(repr(float(value)).replace(".", ",") for value in row) for row in zip(*data.values()))
    path.write_text("% Prüfstand\n% t;x;f\n% s;mm;N\n" + rows + "\n", encoding="utf-16")
    return {"t": "t", "x": "x", "f": "f"}


def write_savetxt(path: Path, data: dict[str, np.ndarray]) -> Names:
    np.savetxt(path, np.column_stack(list(data.values())), fmt="%.17g", header="t x f")
    return {"t": "t", "x": "x", "f": "f"}


def write_mat(path: Path, data: dict[str, np.ndarray], **options: Any) -> Names:
    both = np.column_stack([data["f"], data["x"]])
    signals = np.zeros(2, dtype=[("values", object), ("label", object)])
    signals[0] = (both, "force and position")
    signals[1] = (np.zeros((ROWS, 1), dtype=np.int16), "counts")
    content = {"note": "text", "cells": np.array([1.0, "a"], dtype=object), "scope": {"time": data["t"], "signals": signals}}
    scipy.io.savemat(path, content, **options)
    return {"t": "scope.time", "x": "scope.signals[0].values[:,1]", "f": "scope.signals[0].values[:,0]"}


def write_mat_compressed(path: Path, data: dict[str, np.ndarray]) -> Names:
    return write_mat(path, data, do_compression=True)


def write_parquet(path: Path, data: dict[str, np.ndarray], compression: str = "snappy") -> Names:
    columns = {**data, "note": ["a"] * ROWS}
    pyarrow.parquet.write_table(pyarrow.table(columns), path, compression=compression, row_group_size=1000)
    return {"t": "t", "x": "x", "f": "f"}


def write_parquet_gzip(path: Path, data: dict[str, np.ndarray]) -> Names:
    return write_parquet(path, data, compression="gzip")


def write_tdms(path: Path, data: dict[str, np.ndarray]) -> Names:
    with TdmsWriter(path) as writer:
        for part in np.array_split(np.arange(ROWS), 5):
            channels = [ChannelObject("rig", name, data[name][part], properties={"unit_string": unit})
                        for name, unit in [("t", "s"), ("x", "mm"), ("f", "N")]]
            writer.write_segment(channels)
    return {"t": "/rig/t", "x": "/rig/x", "f": "f"}


def write_h5(path: Path, data: dict[str, np.ndarray]) -> Names:
    with h5py.File(path, "w") as file:
        rig = file.create_group("rig")
        rig.create_dataset("t", data=data["t"], compression="gzip", chunks=(500,), shuffle=True)
        rig.create_dataset("both", data=np.column_stack([data["f"], data["x"]]))
        rig["t"].attrs["units"] = "s"
        table = np.zeros(ROWS, dtype=[("n", "i4"), ("f", "f8")])
        table["f"] = data["f"]
        rig.create_dataset("table", data=table)
        rig["loop"] = file["/"]
    return {"t": "/rig/t", "x": "rig/both[:,1]", "f": "/rig/table.f"}


def write_mat73(path: Path, data: dict[str, np.ndarray]) -> Names:
    """Writes the layout of MATLAB: column-major arrays, structure arrays as references."""
    with h5py.File(path, "w", userblock_size=512) as file:
        refs, scope = file.create_group("#refs#"), file.create_group("scope")
        scope.attrs["MATLAB_class"] = np.bytes_("struct")
        scope["time"] = data["t"][np.newaxis, :]
        refs["a"] = np.vstack([data["f"], data["x"]])
        refs["b"] = np.zeros((1, ROWS))
        signals = scope.create_group("signals")
        references = np.array([[refs["a"].ref], [refs["b"].ref]], dtype=h5py.ref_dtype)
        signals.create_dataset("values", data=references, dtype=h5py.ref_dtype)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + b"\0" * 8 + b"\0\2IM")
    return {"t": "scope.time", "x": "scope.signals[0].values[:,1]", "f": "scope.signals[0].values[:,0]"}


def write_xlsx(path: Path, data: dict[str, np.ndarray]) -> Names:
    book = openpyxl.Workbook()
    book.active.title = "Notes"
    sheet = book.create_sheet("Trial 1")
    sheet.append(["by hand"])
    sheet.append(["t", "x", "f", "note"])
    sheet.append(["s", "mm", "N", None])
    for row in zip(*data.values()):
        sheet.append([*map(float, row), "ok"])
    book.save(path)
    return {"t": "Trial 1!A", "x": "Trial 1!B", "f": "f"}


#: A stamped message of ROS 2 nested in another message.
DEFINITION = """\
std_msgs/Header header
string name
geometry_msgs/Vector3 force
float64[] joints
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""


def write_ros2(path: Path, data: dict[str, np.ndarray]) -> Names:
    start = 1_700_000_000_123_456_789
    with path.open("wb") as file:
        writer = RosWriter(file, compression=CompressionType.NONE)
        schema = writer.register_msgdef("rig_msgs/msg/Sample", DEFINITION)
        other = writer.register_msgdef("rig_msgs/msg/Note", "string text")
        for row, (t, x, f) in enumerate(zip(*data.values())):
            stamp = start + round(1e9 * t)
            message = {
                "header": {"stamp": {"sec": stamp // 10**9, "nanosec": stamp % 10**9}, "frame_id": "n" * (row % 5)},
                "name": "needle", "force": {"x": f, "y": 0.0, "z": 0.0}, "joints": [0.0, x],
            }
            writer.write_message("/rig/sample", schema, message, log_time=stamp, publish_time=stamp)
            if row % 500 == 0:
                writer.write_message("/rig/note", other, {"text": "ok"}, log_time=stamp, publish_time=stamp)
        writer.finish()
    return {"t": "/rig/sample.header.stamp", "x": "/rig/sample.joints[1]", "f": "force.x"}


def write_json(path: Path, data: dict[str, np.ndarray]) -> Names:
    with path.open("wb") as file:
        writer = McapWriter(file, compression=CompressionType.NONE)
        writer.start()
        schema = writer.register_schema("Sample", "jsonschema", b'{"type": "object"}')
        channel = writer.register_channel("/rig", "json", schema)
        for t, x, f in zip(*data.values()):
            message = json.dumps({"t": float(t), "needle": {"x": float(x), "f": [float(f)]}, "note": "ok"})
            writer.add_message(channel, round(1e9 * t), message.encode(), round(1e9 * t))
        writer.finish()
    return {"t": "/rig.t", "x": "/rig.needle.x", "f": "needle.f[0]"}


WRITERS: dict[str, Callable[[Path, dict[str, np.ndarray]], Names]] = {
    "plain.csv": write_csv,
    "german.csv": write_german,
    "spaces.txt": write_savetxt,
    "v5.mat": write_mat,
    "v7.mat": write_mat_compressed,
    "snappy.parquet": write_parquet,
    "gzip.parquet": write_parquet_gzip,
    "rig.tdms": write_tdms,
    "ros2.mcap": write_ros2,
    "json.mcap": write_json,
    "rig.h5": write_h5,
    "v73.mat": write_mat73,
    "book.xlsx": write_xlsx,
}


@pytest.fixture(scope="session")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Names]]:
    folder = tmp_path_factory.mktemp("files")
    data = samples()
    return {name: (folder / name, write(folder / name, data)) for name, write in WRITERS.items()}


def columns(names: Names) -> dict[str, str]:
    return {"time": names["t"], "position": names["x"] + ":mm", "force": names["f"]}


@pytest.mark.parametrize("name", WRITERS)
def test_every_format_gives_the_same_samples(files: dict[str, tuple[Path, Names]], name: str) -> None:
    path, names = files[name]
    read = trocar.read_recording(path, **columns(names))
    data = samples()
    if name.endswith(".xlsx"):
        # Spreadsheets store 16 digits.
        data = {key: np.array([float(f"{value:.16g}") for value in values]) for key, values in data.items()}
    # ROS stamps are whole nanoseconds.
    assert np.array_equal(read["time"], 1e-9 * np.round(1e9 * data["t"]) if name == "ros2.mcap" else data["t"])
    assert np.array_equal(read["position"], data["x"] * 1e-3)
    assert np.array_equal(read["force"], data["f"])
    assert read["velocity"] is None


@pytest.mark.parametrize("name", WRITERS)
def test_the_command_line_detects_the_same_alarms(
    files: dict[str, tuple[Path, Names]], name: str, cli: Cli, tmp_path: Path
) -> None:
    path, names = files[name]
    flags = [word for flag, column in columns(names).items() for word in (f"--{flag}", column)]
    done = cli("detect", path, *flags, "--rupture-s", 1.5, "--no-figures", "--json", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    alarms = json.loads(done.stdout)["alarms"]
    direct = trocar.detect(**trocar.read_recording(files["plain.csv"][0], **columns({"t": "t", "x": "x", "f": "f"})))
    assert [alarm["sample"] for alarm in alarms] == direct.alarms.tolist()
    assert len(alarms) >= 1


@pytest.mark.parametrize("name", WRITERS)
def test_list_signals_names_the_signals(files: dict[str, tuple[Path, Names]], name: str, cli: Cli) -> None:
    path, names = files[name]
    listed = trocar.list_signals(path)
    by_name = {signal["name"]: signal for signal in listed["signals"]}
    assert by_name[names["t"]]["samples"] == ROWS
    done = cli("detect", path, "--list", "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == listed
    done = cli("detect", path, "--list")
    assert f"trocar detect {path}" in done.stdout and names["t"] in done.stdout


def test_an_exported_simulation_can_be_imported(cli: Cli, tmp_path: Path) -> None:
    done = cli("run", "paper/classical", "--quiet", "--format", "csv,mat,parquet", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    folder = tmp_path / "classical"
    table = np.genfromtxt(folder / "trace.csv", delimiter=",", names=True)
    matlab = scipy.io.loadmat(folder / "trace.mat")
    parquet = pyarrow.parquet.read_table(folder / "trace.parquet")
    assert list(table.dtype.names) == parquet.column_names
    for name in table.dtype.names:
        assert matlab[name].shape == (len(table), 1)
        assert np.array_equal(matlab[name].ravel(), table[name])
        assert np.array_equal(parquet[name].to_numpy(), table[name])


def test_unique_roles_serve_as_columns_with_a_warning(cli: Cli, files: dict[str, tuple[Path, Names]], tmp_path: Path) -> None:
    done = cli("detect", files["rig.tdms"][0], "--no-figures", "--quiet", "--json", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    [warning, *_] = json.loads(done.stdout)["warnings"]
    assert warning["code"] == "guessed-columns"
    assert warning["message"] == "the columns are guessed: --time /rig/t:s --position /rig/x:mm --force /rig/f:N"
    done = cli("detect", files["v5.mat"][0], "--no-figures", "--out", tmp_path)
    assert done.returncode == 2
    assert "no signal 'position_m' (--position or recording.columns.position_m)" in done.stderr
    assert "--list" in done.stderr


def test_roc_writes_the_operating_characteristic_of_a_file(cli: Cli, files: dict[str, tuple[Path, Names]], tmp_path: Path) -> None:
    path, names = files["v7.mat"]
    flags = [word for flag, column in columns(names).items() for word in (f"--{flag}", column)]
    done = cli("roc", path, *flags, "--rupture-s", 1.5, "--seeds", 2, "--quiet", "--out", tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "roc" / "roc.csv").is_file()


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("v5.mat", {"force": "scope.signals[0].values"}, "is 3000 x 2, not one signal; give its column, counted from 0"),
        ("v5.mat", {"force": "scope.signals[7].values"}, "no signal 'scope.signals[7].values' (force or"),
        ("rig.tdms", {"force": "g"}, "the file has /rig/t, /rig/x, /rig/f"),
        ("rig.h5", {"position": "/rig/boht[:,1]"}, "did you mean '/rig/both[:,"),
        ("book.xlsx", {"force": "Trial 1!D"}, "no signal 'Trial 1!D'"),
    ],
)
def test_a_wrong_name_is_reported_with_the_available_names(
    files: dict[str, tuple[Path, Names]], name: str, change: dict[str, str], message: str
) -> None:
    path, names = files[name]
    with pytest.raises(ValueError) as refused:
        trocar.read_recording(path, **{**columns(names), **change})
    assert message in str(refused.value)


def test_different_lengths_and_undefined_samples_are_reported(tmp_path: Path) -> None:
    data = samples()
    data["f"][7] = np.nan
    path = tmp_path / "nan.mat"
    write_mat(path, data)
    names = {"time": "scope.time", "position": "scope.signals[0].values[:,1]", "force": "scope.signals[0].values[:,0]"}
    with pytest.raises(ValueError, match=r"sample 7, column 'scope.signals\[0\].values\[:,0\]': holds no finite number"):
        trocar.read_recording(path, **names)
    scipy.io.savemat(path, {"t": data["t"], "x": data["x"], "f": np.zeros(5), "g": data["x"]})
    with pytest.raises(ValueError, match="has 5 samples, and the time 't' has 3000; give signals of one clock: .* t, x, g"):
        trocar.read_recording(path, time="t", position="x", force="f")
    pyarrow.parquet.write_table(pyarrow.table({"t": [0.0, 1.0, 2.0], "x": [0, 1, 2], "f": [1.0, None, 2.0]}), path)
    with pytest.raises(ValueError, match="sample 1, column 'f': holds no finite number"):
        trocar.read_recording(path, time="t", position="x", force="f")
    pyarrow.parquet.write_table(pyarrow.table({"t": [0.0, 1.0], "x": [0, 1], "f": [1.0, 2.0]}), path, compression="zstd")
    assert trocar.read_recording(path, time="t", position="x", force="f")["force"].tolist() == [1.0, 2.0]
    with path.open("wb") as file:
        writer = McapWriter(file)
        writer.start()
        channel = writer.register_channel("/rig", "protobuf", writer.register_schema("Sample", "protobuf", b""))
        writer.add_message(channel, 0, b"", 0)
        writer.finish()
    with pytest.raises(ValueError, match="its messages are in 'protobuf' .*; those of ROS .* and JSON are read"):
        trocar.read_recording(path, time="t", position="x", force="f")
    with path.open("wb") as file:
        writer = McapWriter(file, compression=CompressionType.NONE)
        writer.start()
        channel = writer.register_channel("/rig", "protobuf", writer.register_schema("Sample", "protobuf", b""))
        writer.add_message(channel, 0, b"", 0)
        writer.finish()
    with pytest.raises(ValueError, match="the topic /rig cannot be read: its messages are in 'protobuf'"):
        trocar.read_recording(path, time="t", position="x", force="f")
    book = openpyxl.Workbook()
    for row in [["t", "x", "f"], [0, 1, 2], [1, "soft", 3]]:
        book.active.append(row)
    book.save(tmp_path / "text.xlsx")
    with pytest.raises(ValueError, match="row 3, column 'x': 'soft' is not a number"):
        trocar.read_recording(tmp_path / "text.xlsx", time="t", position="x", force="f")


def damaged(content: bytes, seed: int) -> Iterator[bytes]:
    """Yields contents with flipped bytes, many of them in the first kilobyte, and truncated contents."""
    dice = random.Random(seed)
    for _ in range(60):
        changed = bytearray(content)
        for _ in range(dice.choice([1, 3, 20])):
            place = dice.randrange(min(len(content), dice.choice([200, 2000, len(content)])))
            changed[place] = dice.choice([0, 1, 0x7F, 0x80, 0xFF, dice.randrange(256)])
        yield bytes(changed)
    for _ in range(15):
        yield content[: dice.randrange(len(content))]


@pytest.mark.parametrize("name", WRITERS)
def test_a_damaged_file_is_an_error_and_not_a_panic(files: dict[str, tuple[Path, Names]], name: str, tmp_path: Path) -> None:
    path, names = files[name]
    target = tmp_path / name
    for content in damaged(path.read_bytes(), len(name)):
        target.write_bytes(content)
        for read in (lambda: trocar.list_signals(target), lambda: trocar.read_recording(target, **columns(names))):
            try:
                read()
            except ValueError as error:
                assert str(target) in str(error)


@pytest.mark.parametrize("name", [name for name in WRITERS if not name.endswith(("csv", "txt"))])
def test_a_truncated_file_ends_the_command_with_2(files: dict[str, tuple[Path, Names]], name: str, cli: Cli, tmp_path: Path) -> None:
    path, names = files[name]
    content = path.read_bytes()
    (tmp_path / name).write_bytes(content[: len(content) // 2])
    flags = [word for flag, column in columns(names).items() for word in (f"--{flag}", column)]
    done = cli("detect", tmp_path / name, *flags, "--no-figures", "--out", tmp_path / "out")
    assert done.returncode == 2, done.stderr
    assert name in done.stderr and "panicked" not in done.stderr
