"""What can be wrong with a request, said so that the reader can put it right."""

from typing import Self


class RequestError(Exception):
    """A request that cannot be carried out; nothing has been touched.

    The text always has the same four parts, led by the place that they speak of.

    Parameters
    ----------
    what : str
        What is wrong.
    rule : str
        The rule that was broken.
    given : str
        What was given, as it was given.
    do : str
        What to do about it.
    where : str, optional
        The key, cell or file.
    """

    #: Exit status of a command that ends with this error.
    status = 2

    def __init__(self, what: str, rule: str, given: str, do: str, where: str | None = None) -> None:
        # All parts in args: an exception is pickled by its args, and workers send errors between processes.
        super().__init__(what, rule, given, do, where)
        self.what = what
        self.rule = rule
        self.given = given
        self.do = do
        self.where = where

    def __str__(self) -> str:
        """Return the four parts as one message."""
        place = f"{self.where}: " if self.where else ""
        what, do = (text if text.endswith("?") else f"{text}." for text in (self.what, self.do))
        return f"{place}{what} Rule: {self.rule}. Given: {self.given}. Do: {do}"

    def at(self, where: str, given: str | None = None) -> Self:
        """Return the same error placed at `where`, with the words that the user gave there."""
        return type(self)(self.what, self.rule, given or self.given, self.do, where)


class StorageError(RequestError):
    """The file system does not take what was computed: no room, a quota, a limit, a defect. What is whole is kept."""

    status = 3


class FailedBlocksError(RequestError):
    """Other machines could not compute some of the blocks; what is whole is kept."""

    status = 1


class StoppedError(Exception):
    """A run ended between two blocks because it was asked to; its finished blocks are kept.

    Parameters
    ----------
    folder : str
        Where the blocks are.
    done, blocks : int
        Finished blocks, and blocks in all.
    """

    def __init__(self, folder: str, done: int, blocks: int) -> None:
        super().__init__(folder, done, blocks)
        self.folder = folder
        self.done = done
        self.blocks = blocks


def shown(raw: object) -> str:
    """Return what a request gave, as it was given, short enough for a message."""
    text = raw if isinstance(raw, str) else repr(raw)
    return text if len(text) <= 80 else f"{text[:60]} ... {text[-15:]}"
