"""An explorer that runs: a server in a thread, until it is closed."""

import html
import threading
import webbrowser
from collections.abc import Sequence
from types import TracebackType
from typing import Any, Self

from sweep.explorer.answers import Answers
from sweep.explorer.server import Server
from sweep.request.spec import SweepSpec


class Explorer:
    """A server of the page, in threads of this process; a context manager.

    Parameters
    ----------
    answers : Answers
    port : int
        0 for any that is free.

    Attributes
    ----------
    url : str
        The address of the page, with the token that lets its reader in.
    """

    def __init__(self, answers: Answers, port: int = 0) -> None:
        self._server = Server(answers, port, framed=True)
        self.url = self._server.url
        self._thread = threading.Thread(target=self._server.serve_forever, name="explorer", daemon=True)
        self._thread.start()

    def close(self) -> None:
        """End the server; the page of it answers no more. Once is enough, and more does no harm."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    def wait(self) -> None:
        """Wait until the server ends."""
        # without a time limit no signal would be heard on some systems
        while self._thread.is_alive():
            self._thread.join(1.0)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, problem: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def __repr__(self) -> str:
        return f"<explorer at {self.url}>"

    def _repr_html_(self) -> str:
        """Return a frame with the page, for a notebook that runs on this machine."""
        return (
            f'<iframe src="{html.escape(self.url)}" width="100%" height="720" style="border: 0" '
            'title="eulerdisk explorer"></iframe>'
        )


def explore(given: Any = None, *, port: int = 0, open_browser: bool = False, **changes: Any) -> Explorer:
    """Open the explorer of presets, of a spec or of an atlas.

    Parameters
    ----------
    given : SweepSpec, str or Path, optional
        A spec, the name of a preset or a TOML file; all presets if not given.
    port : int
        Where the server listens, on this machine alone; any that is free if not given.
    open_browser : bool
        Whether to open the page in the browser too; a notebook shows it by itself.
    **changes
        Words that change the spec.

    Returns
    -------
    Explorer
        ``explorer.url`` is the address of the page; it is answered until ``explorer.close()``.

    Raises
    ------
    RequestError
        If there is no such spec, or the port is taken.
    """
    spec = None if given is None and not changes else SweepSpec.read(given or "rolling", **changes)
    explorer = Explorer(Answers(spec), port)
    if open_browser:
        threading.Thread(target=webbrowser.open, args=(explorer.url,), daemon=True).start()
    return explorer


def explorer_of_words(what: str | None, words: Sequence[str], *, port: int, open_browser: bool) -> Explorer:
    """Return the explorer that a command line asks for; raises as `explore` does."""
    from sweep.request.spec_changes import given_in, split_changes
    from sweep.request.words import model_for, pairs

    if what is None or "=" in what:
        words, what = ([what, *words] if what else words), None
    changes = split_changes(words, model_for(None, given_in(pairs(words))))
    return explore(what, port=port, open_browser=open_browser, **changes)
