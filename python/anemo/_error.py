"""The package's own exceptions."""


class Error(Exception):
    """What is wrong, where, and what would be right: the sentence of the command line.

    `code` is the exit code that the command would have had: 1 the work failed, 2 an argument or a
    file is wrong, 3 a run that tripped, 4 one that ended early.
    """

    def __init__(self, sentence: str, code: int = 1) -> None:
        super().__init__(sentence)
        self.code = code


class Interrupted(KeyboardInterrupt):
    """A run that was interrupted; `table` is what it has recorded."""

    def __init__(self, table: object = None) -> None:
        super().__init__("interrupted")
        self.table = table
