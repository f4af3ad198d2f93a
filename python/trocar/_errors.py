"""Exceptions."""

from __future__ import annotations


class ScenarioError(ValueError):
    """An invalid scenario or setting.

    The text has the message, the underlined line and the remedy.

    Attributes
    ----------
    message : str
        The problem, with the value and the allowed range.
    remedy : str or None
        The remedy.
    file : str or None
        The source: a path, ``builtin:`` and a name, ``changes`` for a changed key, or the name of a text.
    line, column : int or None
        The position in the source, counted from 1.

    >>> import trocar
    >>> try:
    ...     trocar.Scenario({"base": "paper/classical", "scaling.force": -1.0})
    ... except trocar.ScenarioError as error:
    ...     error.message, error.line, error.column
    ('scaling.force is -1.0, must be a number, at least 0 and at most 1000', 2, 17)
    """

    def __init__(
        self,
        text: str,
        message: str | None = None,
        remedy: str | None = None,
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
    ) -> None:
        super().__init__(text)
        self.message = text if message is None else message
        self.remedy = remedy
        self.file = file
        self.line = line
        self.column = column

    def __reduce__(self) -> tuple[object, ...]:
        parts = (str(self), self.message, self.remedy, self.file, self.line, self.column)
        return (type(self), parts)
