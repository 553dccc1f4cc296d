"""The request that a command line makes: a preset or a file with changes, or what a finished atlas was made from."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sweep.errors import RequestError

if TYPE_CHECKING:
    from sweep.request.spec import SweepSpec


def read_request(spec: str | None, words: Sequence[str], source: Path | None) -> "SweepSpec":
    """Return the spec that is asked for.

    Parameters
    ----------
    spec : str or None
        A preset or a file; with `source` the first change, if there is one.
    words : sequence of str
        Changes, ``NAME=VALUE``.
    source : Path or None
        An atlas whose run is to be repeated.

    Raises
    ------
    RequestError
        If neither is given, or both are, or what is given is no request.
    """
    from sweep.request.spec import SweepSpec
    from sweep.request.words import split_words
    from sweep.schema import PARAMETERS, SETTINGS, WORDS

    if source is None:
        if spec is None:
            raise RequestError(
                "nothing to run",
                "a run has a SPEC, or --from with an atlas",
                "neither",
                "name a preset, as in eulerdisk run rolling -o rolling.nc",
            )
        return SweepSpec.from_words(spec, words)
    if spec is not None and "=" not in spec:
        raise RequestError(
            "two specs",
            "a run has a SPEC or --from, not both",
            f"{spec} and --from {source}",
            "leave one out",
            spec,
        )
    changes = split_words([spec, *words] if spec else words, (*PARAMETERS, *SETTINGS, *WORDS))
    return _spec_of_file(source).replace(**changes)


def _spec_of_file(path: Path) -> "SweepSpec":
    from sweep.atlas.dataset import spec_of
    from sweep.engine.compiled import kernel_hash
    from sweep.files.reading import opened

    with opened(path) as dataset:
        if dataset.attrs.get("kernel_hash") != kernel_hash():
            print(
                f"eulerdisk: {path} was made by other kernels than these: the digits may differ, "
                "eulerdisk compare says whether they matter",
                file=sys.stderr,
            )
        return spec_of(dataset)
