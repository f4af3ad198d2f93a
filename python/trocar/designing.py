"""Designs: the settings that are best for a group of patients."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from . import _core
from ._arrays import whole
from ._progress import Progress
from ._settings import document, dotted, settings, value
from ._stored import Stored
from .documents import Documented
from .ranges import check_varied, written
from .scenario import Scenario
from .warnings import warn

if TYPE_CHECKING:
    import pandas

# The sections whose keys have tables as values.
_OF_KEYS = ("free", "patients")


class Design(Documented, Stored):
    """The designs on the front, returned by :func:`design`. ``print`` shows its tables.

    Attributes
    ----------
    report : dict
        The content of the command line's ``design.json``.
    files : dict of str to str
        The text of the scenario files by name: ``front/01.toml`` and so on, and ``designed.toml`` for the knee.

    >>> import trocar
    >>> found = trocar.design({
    ...     "base": "layers/skin-augmented",
    ...     "free": {"augmentation.min_hold_s": trocar.Range(0.05, 0.5)},
    ...     "objectives": {"excess": {"minimise": "rupture_excess_advance_m"}},
    ...     "validation": {"patients": 2, "seeds": 2}, "search": {"candidates": 4, "generations": 1},
    ... })
    >>> found, found.to_dataframe().shape
    (Design('design', 1 on the front of excess), (1, 3))
    """

    def __init__(self, report: dict[str, Any], contents: dict[str, Any], files: dict[str, str]) -> None:
        self.report = report
        self.files = files
        self._contents = contents

    _keys = {"design", "document", "files"}

    def _kept(self) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        return {}, {"design": self.report, "document": self._contents, "files": self.files}

    @classmethod
    def _of_kept(cls, arrays: dict[str, NDArray[Any]], about: dict[str, Any]) -> Design:
        return cls(about["design"], about["document"], about["files"])

    @property
    def designs(self) -> list[dict[str, Any]]:
        """The designs in the order of the first objective: ``name``, ``is_knee``, ``settings``, and the objectives and
        constraints in the search (``training``) and on other patients (``validation``), in SI units with 95 %
        intervals."""
        return list(self.report["designs"])

    @property
    def scenario(self) -> Scenario | None:
        """The scenario of the knee, the design with the smallest distance to the ideal point; ``None`` if no design
        meets the constraints."""
        return self._scenario("designed.toml") if "designed.toml" in self.files else None

    def __getitem__(self, name: str) -> Scenario:
        """Returns the scenario of a design on the front, such as ``"01"``."""
        if f"front/{name}.toml" not in self.files:
            raise KeyError(f"no design {name!r}; the designs are {', '.join(one['name'] for one in self.designs) or 'none'}")
        return self._scenario(f"front/{name}.toml")

    # Without this, Python would iterate over the designs by integer keys.
    __iter__: None = None

    def _scenario(self, file: str) -> Scenario:
        return Scenario.from_toml(self.files[file])

    def to_dataframe(self) -> pandas.DataFrame:
        """Returns a pandas DataFrame with a row per design: the settings, and the objectives and constraints on other
        patients, in SI units."""
        import pandas

        names = [goal["name"] for goal in (*self.report["objectives"], *self.report["constraints"])]
        rows = [
            {
                "design": one["name"],
                "is_knee": one["is_knee"],
                **one["settings"],
                **{name: estimate and estimate["value"] for name, estimate in zip(names, one["validation"])},
            }
            for one in self.designs
        ]
        return pandas.DataFrame(rows).set_index("design") if rows else pandas.DataFrame(rows)

    def __repr__(self) -> str:
        objectives = ", ".join(goal["name"] for goal in self.report["objectives"])
        return f"Design({self.report['name']!r}, {len(self.designs)} on the front of {objectives})"


def design(
    file: str | os.PathLike[str] | Mapping[str, Any],
    *,
    search: str | os.PathLike[str] | None = None,
    threads: int = 0,
    progress: bool = False,
    **changes: Any,
) -> Design:
    """Finds the settings that are best for a group of patients, and judges them on other patients.

    Parameters
    ----------
    file
        A design file, or its keys as a dictionary: ``base``, ``persons``, ``patients``, ``free``, ``objectives``,
        ``constraints``, and so on. The values of ``free`` and ``patients`` are lists, :class:`Range` without points,
        or tables as in the file.
    search
        A file that keeps the search after every generation. The same design continues from it.
    threads
        Number of threads, up to 1024; 0 is one per processor.
    progress
        True to show the number of runs.
    **changes
        Keys of the base scenario to change, as for :meth:`Scenario.replace`.

    Raises
    ------
    ScenarioError
        For a design file or a scenario that cannot be read or is invalid. It is a ``ValueError``.
    ValueError
        For numbers out of range, and for a ``search`` that is not the search of this design.
    OSError
        If ``search`` cannot be read or written.
    TypeError
        If an argument does not have the type above.

    >>> import trocar
    >>> found = trocar.design({
    ...     "base": "layers/skin-augmented",
    ...     "patients": {"operator.movement_s": trocar.Range(4.0, 8.0)},
    ...     "free": {"augmentation.min_hold_s": trocar.Range(0.05, 0.5), "augmentation.reengage": ["ramp", "snap"]},
    ...     "objectives": {"excess": {"minimise": "rupture_excess_advance_m"}},
    ...     "training": {"patients": 4}, "validation": {"patients": 4, "seeds": 2},
    ...     "search": {"candidates": 4, "generations": 2},
    ... })
    >>> found.scenario is not None and found.scenario["augmentation.reengage"] in ("ramp", "snap")
    True
    """
    threads = whole("threads", threads)
    changed, recordings = settings(changes)
    if isinstance(file, Mapping):
        source, more = _text(file)
        recordings = [*recordings, *more]
    else:
        source = os.fspath(file)
    if recordings:
        raise ValueError("recording.file is a path here: write the samples into a file")
    kept = None if search is None else os.fspath(search)
    with Progress("units", progress) as bar:
        report, contents, files = _core.design(source, isinstance(file, Mapping), changed, kept, threads, bar.tell_of)
    warn(contents["warnings"])
    return Design(report, contents, dict(files))


def _text(design: Mapping[str, Any]) -> tuple[str, list[_core.Recording]]:
    """Returns a design as the text of its file, and the recordings in memory that it names."""
    lines = []
    for section in _OF_KEYS:
        check_varied(section, design.get(section, {}))
        for key, given in design.get(section, {}).items():
            path = f"{section}.{dotted(key)}"
            lines.append(f"{path} = {value(path, written(given))}\n")
    rest, recordings = document({key: given for key, given in design.items() if key not in _OF_KEYS})
    return rest + "".join(lines), recordings
