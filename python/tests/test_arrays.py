"""Any value given as an array is accepted or refused with a reason, and never crashes the process."""

import re

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import trocar

COUNT = 60


def good(count=COUNT):
    time = np.arange(count) * 1e-3
    position = 0.01 + 0.02 * time
    return {"time": time, "position": position, "velocity": np.full(count, 0.02), "force": 100.0 * position}


def detect(samples):
    return trocar.detect(samples["time"], samples["position"], samples["velocity"], samples["force"])


EXPECTED = detect(good())["residual_n"]

# Arrays of any type, shape, byte order and content, and values that are not arrays.
ANY_ARRAY = hnp.arrays(
    dtype=st.one_of(
        hnp.floating_dtypes(endianness="?"),
        hnp.integer_dtypes(endianness="?"),
        hnp.unsigned_integer_dtypes(endianness="?"),
        hnp.boolean_dtypes(),
        hnp.complex_number_dtypes(),
        hnp.datetime64_dtypes(),
        hnp.timedelta64_dtypes(),
        hnp.unicode_string_dtypes(),
        hnp.byte_string_dtypes(),
    ),
    shape=st.one_of(st.just((COUNT,)), hnp.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=COUNT)),
)
ANYTHING = st.one_of(
    ANY_ARRAY,
    st.none(),
    st.text(max_size=5),
    st.floats(),
    st.lists(st.one_of(st.floats(), st.none(), st.text(max_size=2), st.lists(st.floats(), max_size=2)), max_size=COUNT),
    st.builds(object),
)
QUANTITIES = st.sampled_from(["time", "position", "velocity", "force"])


def strided(array, step):
    spread = np.zeros(len(array) * abs(step), dtype=array.dtype)
    spread[::step] = array
    return spread[::step]


@settings(max_examples=400, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(QUANTITIES, ANYTHING)
def test_any_array_is_accepted_or_refused(quantity, values):
    samples = {**good(), quantity: values}
    try:
        found = detect(samples)
    except (ValueError, TypeError) as error:
        assert str(error)
    else:
        assert all(len(column) == len(found["time_s"]) for column in found.columns.values())
        assert np.isfinite(found["position_m"]).all()


@settings(max_examples=200, deadline=None)
@given(QUANTITIES, ANYTHING)
def test_a_detector_accepts_or_refuses_any_array(quantity, values):
    samples = {**good(), quantity: values}
    detector = trocar.Detector(1e-3)
    try:
        detector.steps(samples["position"], samples["velocity"], samples["force"])
    except (ValueError, TypeError) as error:
        assert str(error)
        assert detector.samples == 0
    else:
        assert detector.samples == len(np.asarray(samples["position"]))


@settings(max_examples=200, deadline=None)
@given(st.lists(st.one_of(st.floats(), st.integers(), st.none(), st.text(max_size=3), st.complex_numbers()), min_size=3, max_size=3))
def test_a_detector_accepts_or_refuses_any_sample(sample):
    detector = trocar.Detector(1e-3)
    try:
        step = detector.step(*sample)
    except (ValueError, TypeError, OverflowError) as error:
        assert str(error)
        assert detector.samples == 0
    else:
        assert np.isfinite(step.residual_n)


@settings(max_examples=60, deadline=None)
@given(
    st.sampled_from([-3, -1, 1, 2, 7]),
    st.booleans(),
    st.sampled_from(["=f8", ">f8", "<f8"]),
)
def test_the_memory_layout_does_not_change_the_result(step, writeable, dtype):
    samples = {name: strided(values.astype(dtype), step) for name, values in good().items()}
    for values in samples.values():
        values.flags.writeable = writeable
    np.testing.assert_array_equal(detect(samples)["residual_n"], EXPECTED)


def test_table_columns_and_lists_are_accepted():
    table = np.stack(list(good().values()), axis=1)
    columns = dict(zip(good(), table.T))
    assert not columns["time"].flags.c_contiguous
    np.testing.assert_array_equal(detect(columns)["residual_n"], EXPECTED)
    np.testing.assert_array_equal(detect({name: list(values) for name, values in good().items()})["residual_n"], EXPECTED)


def test_arguments_are_not_changed():
    samples = good()
    before = {name: values.copy() for name, values in samples.items()}
    detect(samples)
    for name, values in samples.items():
        np.testing.assert_array_equal(values, before[name])


@pytest.mark.parametrize(
    ("quantity", "change", "reason"),
    [
        ("force", lambda values: values[:-1], "force_n has 59 samples and time_s has 60"),
        ("force", lambda values: values.reshape(6, 10), r"force has the shape \(6, 10\), must be one-dimensional"),
        ("force", lambda values: values.astype(complex), "force has the dtype complex128"),
        ("force", lambda values: values.astype(str), "force has the dtype <U"),
        ("force", lambda values: values > 1.0, "force has the dtype bool"),
        ("force", lambda values: np.where(values > values[7], np.nan, values), r"force_n\[8\] is NaN"),
        ("position", lambda values: np.where(values > values[7], np.inf, values), r"position_m\[8\] is inf"),
        ("position", lambda values: 1e9 * values, "at most 1e6 m"),
        ("time", lambda values: values[::-1], r"time_s\[1\] is .* must be later"),
        ("time", lambda values: np.zeros_like(values), r"time_s\[1\] is 0.0 s, must be later"),
        ("time", lambda values: np.append(values[:-1], 1.0), r"before time_s\[59\], the limit is"),
        ("force", lambda values: np.ma.masked_greater(values, 1.001), "masked"),
    ],
)
def test_errors_name_the_sample(quantity, change, reason):
    samples = good()
    samples[quantity] = change(samples[quantity])
    with pytest.raises((ValueError, TypeError), match=reason):
        detect(samples)


def test_integers_and_halves_are_converted():
    samples = good()
    samples["force"] = np.arange(COUNT, dtype=np.int16)
    of_integers = detect(samples)["residual_n"]
    samples["force"] = samples["force"].astype(np.float16)
    np.testing.assert_array_equal(detect(samples)["residual_n"], of_integers)


def test_a_bad_sample_leaves_a_detector_unchanged():
    one, other = trocar.Detector(1e-3), trocar.Detector(1e-3)
    for index, (position, velocity, force) in enumerate(zip(*[good()[name] for name in ("position", "velocity", "force")])):
        if index == 30:
            for wrong in (np.nan, np.inf, 1e7):
                with pytest.raises(ValueError, match="force is"):
                    one.step(position, velocity, wrong)
        assert one.step(position, velocity, force).residual_n == other.step(position, velocity, force).residual_n


def test_single_samples_arrays_and_recordings_give_the_same_results(recording):
    columns = [recording[name] for name in ("position_m", "velocity_m_per_s", "force_n")]
    whole = trocar.detect(recording["time_s"], *columns, contact_m=0.012)
    settings = {"contact_m": 0.012}
    # The interval of the recording is the median of its time differences.
    interval_s = float(np.sort(np.diff(recording["time_s"]))[(len(recording["time_s"]) - 2) // 2])
    at_once = trocar.Detector(interval_s, **settings)
    parts = [at_once.steps(*[column[part] for column in columns]) for part in (slice(0, 6000), slice(6000, None))]
    one_by_one = trocar.Detector(interval_s, **settings)
    steps = [one_by_one.step(*sample) for sample in zip(*columns)]
    for name in ("residual_n", "decision", "distance", "stiffness_n_per_m", "damping_n_s_per_m"):
        joined = np.concatenate([columns[name] for columns, _ in parts])
        np.testing.assert_array_equal(joined, whole[name], err_msg=name)
        np.testing.assert_array_equal([getattr(step, name) for step in steps], whole[name], err_msg=name)
    alarms = [index for index, step in enumerate(steps) if step.alarm]
    assert alarms == list(whole.alarms) == [*parts[0][1], *(parts[1][1] + 6000)]
    assert len(alarms) == 2
    assert repr(steps[alarms[0]]).startswith("Step(alarm=True")


def test_a_detector_reports_invalid_arguments():
    with pytest.raises(ValueError, match="velocity is missing"):
        trocar.Detector(1e-3).step(0.0, None, 0.0)
    with pytest.raises(ValueError, match="estimates the velocity"):
        trocar.Detector(1e-3, velocity="filtered").step(0.0, 1.0, 0.0)
    for interval_s in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match=re.escape("interval_s is")):
            trocar.Detector(interval_s)
    with pytest.raises(trocar.ScenarioError, match="detector.threshold"):
        trocar.Detector(1e-3, **{"detector.threshold": -1.0})


def test_alarms_index_the_given_samples_even_if_they_are_uneven():
    data = trocar.record()
    time = data["time_s"].copy()
    time[1:-1] += np.random.default_rng(1).uniform(-3e-4, 3e-4, len(time) - 2)
    found = trocar.detect(time, data["position_m"], data["velocity_m_per_s"], data["force_n"], contact_m=0.012)
    assert len(found.alarms) >= 2
    assert not np.array_equal(found["time_s"], time[: len(found["time_s"])])
    assert (time[found.alarms] <= found.alarms_s).all() and (found.alarms_s < time[found.alarms + 1]).all()
    assert found.to_dataframe()["alarm"].sum() == len(found.alarm_rows) == len(found.alarms)


@pytest.mark.parametrize("missing", [slice(100, 101), slice(3000, 3002), slice(8000, 8001)])
def test_alarms_index_the_given_samples_if_some_are_missing(missing):
    data = trocar.record(2)
    whole = trocar.detect(data, contact_m=0.012)
    kept = np.ones(len(data["time_s"]), dtype=bool)
    kept[missing] = False
    found = trocar.detect({name: column[kept] for name, column in data.items()}, contact_m=0.012)
    # A row is at the time of a sample, up to rounding; the alarm belongs to that sample.
    assert np.abs(data["time_s"][kept][found.alarms] - found.alarms_s).max() < 1e-9
    assert np.abs(found.alarms_s - whole.alarms_s).max() < 0.01
