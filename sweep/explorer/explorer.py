"""The subject of an explorer (presets, a spec or an atlas), and the running explorer: a server in a thread."""

import html
import secrets
import tempfile
import threading
import webbrowser
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from os.path import isfile
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from sweep.atomic import publish_bytes
from sweep.errors import RequestError
from sweep.explorer.answers import Answers
from sweep.explorer.server import Server
from sweep.explorer.stored import Stored
from sweep.explorer.system import is_system
from sweep.request.spec import SweepSpec

#: Programs here are confined (snap): their browsers have their own folder of temporary files and cannot read those of
#: others.
_CONFINED = Path("/snap")

#: File extensions of atlases.
_ATLASES = (".nc", ".nc4", ".cdf")


class Subject:
    """A spec, and the atlas that was made from it, if any; without a spec, only the presets.

    `close` closes the atlas's file.
    """

    def __init__(self, spec: SweepSpec | None = None, stored: Stored | None = None) -> None:
        self.spec, self.stored = spec, stored
        self._open = ExitStack()

    @classmethod
    def of_file(cls, path: Path) -> "Subject":
        """Return the atlas in a file, which stays open.

        Raises
        ------
        RequestError
        """
        from sweep.atlas.dataset import spec_of
        from sweep.files.reading import opened

        with ExitStack() as stack:
            dataset = stack.enter_context(opened(path, indexed=False))
            spec = spec_of(dataset)
            found = cls(spec, Stored(dataset, spec, path.name))
            found._open = stack.pop_all()
        return found

    @classmethod
    def of_dataset(cls, dataset: Any) -> "Subject":
        """Return an atlas in memory, or a selection from one, as a subject.

        Raises
        ------
        RequestError
        """
        from sweep.atlas.dataset import spec_of
        from sweep.atlas.selection import as_atlas, check_numbers, require_atlas

        require_atlas(dataset)
        check_numbers(dataset)
        atlas, source = as_atlas(dataset), dataset.encoding.get("source")
        spec = spec_of(atlas)
        return cls(spec, Stored(atlas, spec, Path(source).name if source else "atlas"))

    def close(self) -> None:
        """Close the file after the requests that are reading it have ended."""
        if self.stored is not None:
            self.stored.close()
        self._open.close()


def subject_of(given: Any, changes: Mapping[str, Any]) -> Subject:
    """Return the subject of an explorer; see `sweep.explorer.explorer.explore`."""
    is_file = _is_atlas(given)
    if is_file or hasattr(given, "data_vars"):
        if changes:
            raise RequestError(
                f"The cells of an atlas cannot be changed; got {', '.join(changes)}.",
                hint="Change words on the page, or give a preset or a .toml file.",
                where=next(iter(changes)),
            )
        return Subject.of_file(Path(given)) if is_file else Subject.of_dataset(given)
    if given is None and not changes:
        return Subject()
    return _subject_of_spec(SweepSpec.read("rolling" if given is None else given, **changes))


def _subject_of_spec(spec: SweepSpec) -> Subject:
    """Return a spec as a subject; raise an error if its map cannot be computed interactively."""
    if spec.model.exact is None and not is_system(spec):
        raise RequestError(
            f"The model {spec.model.name} has no exact reduction: its cells are integrated in time, which takes too "
            "long for an interactive map.",
            hint="Compute an atlas with eulerdisk run first, as in eulerdisk run toy -o toy.nc, and explore its file.",
            where="model",
        )
    if len(spec.model.parameters) == 1:
        raise RequestError(
            f"The system {spec.model.name} has one state and no parameter; a map needs two of them.",
            hint="Give the system a parameter, or draw an atlas with eulerdisk plot.",
            where="model",
        )
    if spec.is_list:
        raise RequestError(
            "A list of starts does not span a plane; a map needs two parameters with ranges.",
            hint="Give ranges instead, or a preset: eulerdisk explore rolling.",
            where="starts",
        )
    return Subject(spec)


def subject_of_words(what: str | None, words: Sequence[str]) -> Subject:
    """Return the subject that the words of a command line name; raises as `subject_of`."""
    from sweep.request.words import changes_in

    # the name of a file may also contain this sign: hoop_alpha=1.nc; Path.is_file raises an error for a name that is
    # too long
    if what is not None and "=" in what and not isfile(what):
        words, what = [what, *words], None
    if words and not _is_atlas(what):
        return _subject_of_spec(SweepSpec.from_words("rolling" if what is None else what, words))
    return subject_of(what, changes_in(words))


def _is_atlas(given: Any) -> bool:
    """Return whether this is the file name of an atlas."""
    return isinstance(given, str | Path) and Path(given).suffix in _ATLASES


class Explorer:
    """The page of an explorer, served by threads of this process until `close`; `sweep.explore` creates it.

    It shows itself in a notebook, and is also a context manager.

    Parameters
    ----------
    subject : Subject
        What is explored; closed together with the server.
    port : int
        Port of the server; 0 for any free one.
    """

    def __init__(self, subject: Subject, port: int = 0) -> None:
        self._subject = subject
        self._door: Path | None = None
        try:
            self._server = Server(Answers(subject.spec, subject.stored), port, framed=True)
        except BaseException:
            subject.close()
            raise
        self._thread = threading.Thread(target=self._server.serve_forever, name="explorer", daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """The address of the page, including the token that grants access."""
        return self._server.url

    def open_browser(self) -> None:
        """Open the page in the default browser, without waiting for it.

        All users of a machine can see the arguments of its programs, so the browser gets a file that redirects to the
        page and that only this user can read. A confined browser (snap) gets the address itself.
        """
        if self._door is None and not _CONFINED.is_dir():
            self._door = _door_to(self.url)
        address = self.url if self._door is None else self._door.as_uri()
        # some browsers return only when they are closed
        threading.Thread(target=webbrowser.open, args=(address,), daemon=True).start()

    def close(self) -> None:
        """End the server, so that the page is no longer answered. Repeated calls have no effect."""
        if self._door is not None:
            self._door.unlink(missing_ok=True)
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
        self._subject.close()

    def wait(self) -> None:
        """Wait until the server ends."""
        # without a time limit, signals are not delivered on some systems
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
        """Return a frame with the page, for a notebook on this machine."""
        return (
            f'<iframe src="{html.escape(self.url)}" width="100%" height="720" style="border: 0" '
            'title="eulerdisk explorer"></iframe>'
        )


def _door_to(url: str) -> Path:
    """Write a file that redirects a browser to an address, and that only this user can read."""
    path = Path(tempfile.gettempdir(), f"eulerdisk-{secrets.token_hex(8)}.html").absolute()
    text = f'<!DOCTYPE html><meta http-equiv="refresh" content="0; url={html.escape(url)}">\n'
    publish_bytes(path, text.encode(), mode=0o600)
    return path


def explore(given: Any = None, *, port: int = 0, open_browser: bool = False, **changes: Any) -> Explorer:
    """Open the explorer for presets, a spec or an atlas.

    Parameters
    ----------
    given : SweepSpec, xarray.Dataset, str or Path, optional
        A spec, the name of a preset, a file of a spec (TOML) or of a system (``.py``), an atlas or its file. By
        default, the presets of the thin disk without losses.
    port : int
        Port of the server, which only this machine can reach; by default any free one.
    open_browser : bool
        Whether to also open the page in the browser; a notebook shows it anyway.
    **changes
        Words that change the spec; not allowed with an atlas.

    Returns
    -------
    Explorer
        ``explorer.url`` is the address of the page, which is served until ``explorer.close()``.

    Raises
    ------
    RequestError
        If there is no such spec or file, its cells do not span a plane, or the port cannot be used.
    """
    explorer = Explorer(subject_of(given, changes), port)
    if open_browser:
        explorer.open_browser()
    return explorer
