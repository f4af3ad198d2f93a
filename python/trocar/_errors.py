"""What goes wrong."""

from __future__ import annotations


class ScenarioError(ValueError):
    """A scenario or a setting that cannot be used as written.

    As text it is what the command line prints: the message, the line underlined, the remedy.

    Attributes
    ----------
    message : str
        What is wrong, with the number and what is allowed.
    remedy : str or None
        What to do about it.
    file : str or None
        Where it stands: a path, ``builtin:`` and a name, ``--set`` for a changed key, or the name of a text.
    line, column : int or None
        Its place there, from 1, as an editor counts.
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
