"""Studies with a document each: the strategies against a rupture, and the figures of the paper."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from . import _core
from ._arrays import whole
from ._frames import flat_rows
from ._progress import Progress
from ._reported import Reported
from ._settings import settings as lines
from .warnings import warn
from .scenario import Scenario

if TYPE_CHECKING:
    import pandas


class Strategies(Reported):
    """The strategies against a rupture, returned by :func:`strategies`. ``print`` shows its tables.

    Attributes
    ----------
    report : dict
        The content of the command line's ``strategies.json``.

    >>> import trocar
    >>> study = trocar.strategies(seeds=2)
    >>> study
    Strategies('skin-augmented', 1 patient, attentive, distracted, practised)
    >>> round(1e3 * study["freeze-clutch"]["mean_excess_m"], 1) < round(1e3 * study["none"]["mean_excess_m"], 1)
    True
    """

    _name = "strategies"

    @property
    def rows(self) -> list[dict[str, Any]]:
        """The results of each strategy, in SI units; undefined values are ``None``."""
        return list(self.report["study"]["rows"])

    @property
    def patients(self) -> int:
        """The number of patients."""
        return int(self.report["study"]["patients"])

    def __getitem__(self, strategy: str) -> dict[str, Any]:
        """Returns the results of a strategy, such as ``"freeze-decay"``."""
        for row in self.rows:
            if row["strategy"] == strategy:
                return dict(row)
        raise KeyError(f"no strategy {strategy!r}; the strategies are {', '.join(row['strategy'] for row in self.rows)}")

    # Without this, Python would iterate over the study by integer keys.
    __iter__: None = None

    def to_dataframe(self) -> pandas.DataFrame:
        """Returns a pandas DataFrame with a row per strategy, in SI units. :func:`trocar.sweep` over the patients with a
        scenario ``strategies/…`` as its base gives the values of each run."""
        import pandas

        return pandas.DataFrame(flat_rows(self.rows)).set_index("strategy")

    def __repr__(self) -> str:
        people = "patient" if self.patients == 1 else "patients"
        return f"Strategies({self.report['study']['name']!r}, {self.patients} {people}, {', '.join(self.report['study']['persons'])})"


def strategies(
    scenario: Scenario | str | os.PathLike[str] = "layers/skin-augmented",
    *,
    persons: str | Sequence[str] = (),
    patients: int = 200,
    seeds: int = 10,
    threads: int = 0,
    progress: bool = False,
    **changes: Any,
) -> Strategies:
    """Compares the strategies against a rupture, with a person who reacts to what the hand feels.

    Parameters
    ----------
    scenario
        A scenario or a path; or a sweep file whose points are the patients, such as
        ``"builtin:sweeps/patients.toml"``.
    persons
        The persons ``attentive``, ``distracted`` and ``practised``, which are the default; or the groups ``adult``,
        ``child`` and ``expert``, from which each patient gets another member.
    patients
        The number of patients: the first points of a sweep file, or members drawn from each group of people. A scenario
        with persons has one patient.
    seeds
        The number of seeds of each patient and person, from 2 to 100000.
    threads
        Number of threads, up to 1024; 0 is one per processor.
    progress
        True to show the number of runs.
    **changes
        Keys to change in all cases, as for :meth:`Scenario.replace`.

    Raises
    ------
    ScenarioError
        For a scenario that cannot be read or is invalid. It is a ``ValueError``.
    ValueError
        For an unknown person, and for numbers out of range.
    TypeError
        If an argument does not have the type above.

    >>> import trocar
    >>> study = trocar.strategies("builtin:sweeps/patients.toml", patients=2, seeds=2, persons="attentive")
    >>> study.patients, study.document.title
    (2, 'patients')
    """
    wanted = [persons] if isinstance(persons, str) else list(persons)
    patients, seeds, threads = whole("patients", patients, 1), whole("seeds", seeds, 2), whole("threads", threads)
    changed, recordings = lines(changes)
    if recordings:
        raise ValueError("recording.file is a path here: put samples into a Scenario, and pass it as scenario")
    if isinstance(scenario, Scenario) or not _core.is_sweep(os.fspath(scenario)):
        studied = scenario if isinstance(scenario, Scenario) else Scenario.load(scenario)
        given: Any = studied._core
    else:
        given = os.fspath(scenario)
    with Progress("runs", progress) as bar:
        report, contents = _core.strategies(
            given, changed, wanted, patients, seeds, threads, lambda done: bar.tell(done, max(done, 1))
        )
    warn(contents["warnings"])
    return Strategies(report, contents)


class Paper(Reported):
    """The reproduced figures of the paper, returned by :func:`paper`. ``print`` shows its tables.

    ``paper.document.figures["figure_13"].plot()`` draws a figure.

    Attributes
    ----------
    report : dict
        The content of the command line's JSON file: for each figure, what the paper shows, what this project shows,
        the differences and the statements.

    >>> import trocar
    >>> trocar.paper().document.figures["figure_13"].plot()  # doctest: +SKIP
    <Figure size 800x600 with 4 Axes>
    """

    _name = "paper"

    def __repr__(self) -> str:
        return f"Paper({len(self.document.figures)} figures)"


def paper(*, threads: int = 0) -> Paper:
    """Reproduces the figures and the statements of the paper.

    Parameters
    ----------
    threads
        Number of threads, up to 1024; 0 is one per processor.

    Returns
    -------
    Paper
        The figures, and the paper's statements with the results.

    >>> import trocar
    >>> paper = trocar.paper()
    >>> paper.document.figures["figure_13"].plot()
    <Figure size ...>
    """
    report, contents = _core.paper(whole("threads", threads))
    return Paper(report, contents)
