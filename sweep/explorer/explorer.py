"""An explorer that runs: a server in a thread, until it is closed."""

import html
import threading
import webbrowser
from types import TracebackType
from typing import Any, Self

from sweep.explorer.answers import Answers
from sweep.explorer.server import Server
from sweep.explorer.subject import Subject, subject_of


class Explorer:
    """The page of an explorer, answered by threads of this process until `close`; `sweep.explore` makes one.

    In a notebook it shows itself. It is a context manager too.

    Parameters
    ----------
    subject : Subject
        What is explored; it is closed with the server.
    port : int
        0 for any that is free.
    """

    def __init__(self, subject: Subject, port: int = 0) -> None:
        self._subject = subject
        try:
            self._server = Server(Answers(subject.spec, subject.stored), port, framed=True)
        except BaseException:
            subject.close()
            raise
        self._thread = threading.Thread(target=self._server.serve_forever, name="explorer", daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """The address of the page, with the token that lets its reader in."""
        return self._server.url

    def open_browser(self) -> None:
        """Open the page in the browser of this system, without waiting for it."""
        # some browsers return only when they are closed
        threading.Thread(target=webbrowser.open, args=(self.url,), daemon=True).start()

    def close(self) -> None:
        """End the server; the page of it answers no more. Once is enough, and more does no harm."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
        self._subject.close()

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
    given : SweepSpec, xarray.Dataset, str or Path, optional
        A spec, the name of a preset or a TOML file; an atlas or its file; all presets if not given.
    port : int
        Where the server listens, on this machine alone; any that is free if not given.
    open_browser : bool
        Whether to open the page in the browser too; a notebook shows it by itself.
    **changes
        Words that change the spec; an atlas takes none.

    Returns
    -------
    Explorer
        ``explorer.url`` is the address of the page; it is answered until ``explorer.close()``.

    Raises
    ------
    RequestError
        If there is no such spec or file, its cells are no plane, or the port cannot be used.
    """
    explorer = Explorer(subject_of(given, changes), port)
    if open_browser:
        explorer.open_browser()
    return explorer
