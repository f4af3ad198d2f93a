"""Patients: scenarios that are drawn from distributions."""

from __future__ import annotations

import os
from collections.abc import Iterator, KeysView, Mapping
from typing import TYPE_CHECKING, Any, overload

import numpy as np
from numpy.typing import NDArray

from . import _core
from ._arrays import whole
from ._frames import freeze, stream
from ._html import table
from .scenario import Scenario

if TYPE_CHECKING:
    import pandas

# The keys that the tissues of a population change.
_TISSUE = {"stiffness": "tissue.stiffness_n_per_m", "damping": "tissue.damping_n_s_per_m"}


class Patients:
    """Patients, returned by :func:`patients`: a table with a row per patient, and a scenario for each.

    Iterating yields the scenarios, ``patients[0]`` is that of the first patient, and ``patients["patient"]`` is a
    column. :func:`trocar.sweep` accepts patients in place of a scenario. polars, pyarrow, pandas and DuckDB read them
    as a table.

    Attributes
    ----------
    scenario : Scenario
        The scenario that the patients share.
    columns : dict of str to array
        ``patient``, the number from 1, and a column per drawn key, each with the shape ``(patients,)``.

    >>> import trocar
    >>> patients = trocar.patients(3)
    >>> patients
    Patients(3 of 'skin-augmented', 8 drawn keys)
    >>> [round(scenario["tissue.layer.skin.thickness_m"], 4) for scenario in patients]
    [0.0022, 0.0015, 0.0018]
    """

    def __init__(self, scenario: Scenario, drawn: Mapping[str, Any]) -> None:
        self.scenario = scenario
        arrays = {key: np.asarray(column) for key, column in drawn.items()}
        count = len(next(iter(arrays.values()), ()))
        self.columns: dict[str, NDArray[Any]] = {"patient": np.arange(1, count + 1, dtype=np.int64), **arrays}
        freeze(self.columns)

    @property
    def drawn(self) -> list[str]:
        """The drawn keys."""
        return [name for name in self.columns if name != "patient"]

    def __len__(self) -> int:
        return len(self.columns["patient"])

    def __iter__(self) -> Iterator[Scenario]:
        return (self[index] for index in range(len(self)))

    @overload
    def __getitem__(self, which: int) -> Scenario: ...
    @overload
    def __getitem__(self, which: str) -> NDArray[Any]: ...
    def __getitem__(self, which: int | str) -> Scenario | NDArray[Any]:
        if isinstance(which, str):
            if which not in self.columns:
                raise KeyError(f"no column {which!r}; the columns are {', '.join(self.columns)}")
            return self.columns[which]
        if not -len(self) <= which < len(self):
            raise IndexError(f"there is no patient [{which}] of {len(self)}; the first is [0]")
        index = range(len(self))[which]
        values = {key: self.columns[key][index].item() for key in self.drawn}
        return self.scenario.replace(**values, name=f"{self.scenario.name}-patient-{index + 1}")

    def keys(self) -> KeysView[str]:
        """Returns the names of the columns."""
        return self.columns.keys()

    def __arrow_c_stream__(self, requested_schema: object = None) -> Any:
        """Returns the columns for a library that reads Arrow."""
        return stream(self.columns)

    def to_dataframe(self) -> pandas.DataFrame:
        """Returns the columns as a pandas DataFrame, indexed by ``patient``."""
        import pandas

        return pandas.DataFrame(self.columns).set_index("patient")

    def __repr__(self) -> str:
        return f"Patients({len(self)} of {self.scenario.name!r}, {len(self.drawn)} drawn keys)"

    def _repr_html_(self) -> str:
        shown = [[str(column[row]) if column.dtype.kind in "iU" else f"{column[row]:.4g}" for column in self.columns.values()] for row in range(min(len(self), 10))]
        return table(list(self.columns), shown, f"{len(self)} patients of {self.scenario.name}")


def patients(count: int = 200, source: Scenario | str | os.PathLike[str] = "builtin:sweeps/patients.toml", **changes: Any) -> Patients:
    """Returns patients: a scenario for each, with values that are drawn from distributions.

    Parameters
    ----------
    count
        The number of patients. The first patients are the same for every number, unless the file has a Latin
        hypercube.
    source
        A sweep file, whose points are the patients; the default is the shipped one, which varies the layers, the
        motion, the grip and the noise of ``layers/skin-augmented``. Or a scenario with a ``[population]``, whose arms,
        tissues and delays are drawn.
    **changes
        Keys to change for all patients, as for :meth:`Scenario.replace`.

    Raises
    ------
    ScenarioError
        For a file or scenario that cannot be read or is invalid. It is a ``ValueError``.
    ValueError
        For a ``count`` below 1 or above the number of points of the file, a scenario whose ``[population]`` draws
        nothing, and a population of tissues around a tissue that is not a spring and damper.
    TypeError
        If ``count`` is not an integer, or the source is neither a scenario nor a path.

    >>> import trocar
    >>> sweep = trocar.sweep(trocar.patients(4), {"scaling.force": [0.5, 1.0]}, metrics=["detected_ruptures"])
    >>> sweep["patient"], len(sweep)
    (array([1, 1, 2, 2, 3, 3, 4, 4]), 8)
    """
    count = whole("count", count, 1)
    if not isinstance(source, Scenario) and _core.is_sweep(os.fspath(source)):
        base, shared, columns = _core.sweep_points(os.fspath(source), count)
        settings = [f"{key}={value}" for key, value in shared]
        scenario = Scenario._of(Scenario.load(base)._core.replace(settings, []))
        return Patients(scenario.replace(**changes) if changes else scenario, columns)
    scenario = source if isinstance(source, Scenario) else Scenario.load(source)
    scenario = scenario.replace(**changes) if changes else scenario
    columns = _core.population(scenario._core, count)
    if not columns:
        raise ValueError(
            f"the [population] of {scenario.name} draws nothing: set population.arm, population.tissue or population.delay, "
            "or give a sweep file, such as builtin:sweeps/patients.toml"
        )
    for factor, key in _TISSUE.items():
        if factor in columns:
            if scenario["tissue.kind"] != "kelvin-voigt":
                raise ValueError(
                    f"the population draws tissues around a spring and damper, and {scenario.name} has the tissue "
                    f"{scenario['tissue.kind']}: set population.tissue = \"none\", or draw its keys in a sweep file"
                )
            columns[key] = columns.pop(factor) * scenario[key]
    return Patients(scenario, columns)
