"""What is explored: presets, a spec, or an atlas in memory or in a file."""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from os.path import isfile
from pathlib import Path
from typing import Any

from sweep.errors import RequestError
from sweep.explorer.stored import Stored
from sweep.request.spec import SweepSpec

#: Endings of files that are no spec files.
_ATLASES = (".nc", ".nc4", ".cdf")


class Subject:
    """A spec, and the atlas that it is the request of, if there is one; the presets alone without a spec.

    `close` closes its file.
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
        """Return an atlas in memory, or a selection from one.

        Raises
        ------
        RequestError
        """
        from sweep.atlas.dataset import spec_of
        from sweep.atlas.selection import check_flags, require_atlas, settled

        require_atlas(dataset)
        check_flags(dataset)
        atlas, source = settled(dataset), dataset.encoding.get("source")
        spec = spec_of(atlas)
        return cls(spec, Stored(atlas, spec, Path(source).name if source else "atlas"))

    def close(self) -> None:
        """Close the file; who reads it at this moment is waited for."""
        if self.stored is not None:
            self.stored.close()
        self._open.close()


def subject_of(given: Any, changes: Mapping[str, Any]) -> Subject:
    """Return what is explored; see `sweep.explorer.explorer.explore`."""
    is_file = _is_atlas(given)
    if is_file or hasattr(given, "data_vars"):
        if changes:
            raise RequestError(
                f"The cells of an atlas are what they are; got {', '.join(changes)} besides.",
                hint="Change words on the page, or give a preset or a .toml file.",
                where=next(iter(changes)),
            )
        return Subject.of_file(Path(given)) if is_file else Subject.of_dataset(given)
    if given is None and not changes:
        return Subject()
    return _subject_of_spec(SweepSpec.read("rolling" if given is None else given, **changes))


def _subject_of_spec(spec: SweepSpec) -> Subject:
    """Return a spec as what is explored; refuse one of which no map can be computed while one looks."""
    if spec.model.exact is None:
        raise RequestError(
            f"The model {spec.model.name} has no exact reduction: its cells are integrated in time, which takes too "
            "long for a map that is computed while one looks.",
            hint="Compute an atlas with eulerdisk run first, as in eulerdisk run toy -o toy.nc, and explore its file.",
            where="model",
        )
    if spec.is_list:
        raise RequestError(
            "A list of starts is no plane, and a map shows a plane of two parameters.",
            hint="Give ranges instead, or a preset: eulerdisk explore rolling.",
            where="starts",
        )
    return Subject(spec)


def subject_of_words(what: str | None, words: Sequence[str]) -> Subject:
    """Return what the words of a command line name; raises as `subject_of`."""
    from sweep.request.spec_changes import given_in, split_changes
    from sweep.request.words import model_for, pairs

    # the name of a file may have such a sign, too: hoop_alpha=1.nc; Path.is_file raises for a name that is too long
    if what is not None and "=" in what and not isfile(what):
        words, what = [what, *words], None
    if words and not _is_atlas(what):
        return _subject_of_spec(SweepSpec.from_words("rolling" if what is None else what, words))
    return subject_of(what, split_changes(words, model_for(None, given_in(pairs(words)))))


def _is_atlas(given: Any) -> bool:
    """Return whether this is the name of the file of an atlas."""
    return isinstance(given, str | Path) and Path(given).suffix in _ATLASES
