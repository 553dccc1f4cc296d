"""Drawing, filming and exporting the file of a motion, for `plot` and `export`."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from sweep.commands.terminal import say
from sweep.errors import RequestError, counted, shown

if TYPE_CHECKING:
    import xarray as xr

#: File name extensions of films.
FILMS = (".gif", ".mp4")


def plot_motion(
    paths: Sequence[Path],
    words: Sequence[str],
    output: Path,
    *,
    dpi: int | None,
    film_options: Mapping[str, object],
    others: Mapping[str, object],
) -> None:
    """Draw the motion in a file, or film it if the output is a film.

    Parameters
    ----------
    paths : sequence of Path
        The files that were given; one contains a motion.
    words : sequence of str
        The words ``NAME=VALUE``.
    output : Path
    dpi : int, optional
    film_options, others : mapping of str to anything
        Options of a film, and options of the figures of atlases; None or False if not given.

    Raises
    ------
    RequestError
        If more files, or options or words that the figure or film does not take, are given.
    """
    if len(paths) > 1:
        raise RequestError(
            f"The figure of a motion shows one motion and no atlas; got {' '.join(map(str, paths))}.",
            "Draw each with its own command.",
        )
    _check_words(words)
    if unused := [name for name, value in others.items() if value not in (None, False)]:
        raise RequestError(
            "The figure of a motion takes --dpi; its film takes --speed, --fps, --size and --camera; got "
            f"{' '.join(unused)}.",
            f"Leave {' and '.join(unused)} out.",
        )
    if output.suffix.lower() in FILMS:
        _film(paths[0], output, dpi, film_options)
        return
    if unused := [f"--{name}" for name, value in film_options.items() if value is not None]:
        raise RequestError(
            f"Only a film has a speed, fps, a size and a camera; got {' '.join(unused)} for {output}.",
            f"Write -o {output.stem}.gif, or leave {' and '.join(unused)} out.",
        )
    from sweep.figures import plots

    with _motion_in(paths[0]) as dataset:
        plots.save(plots.motion_figure(dataset), output, dpi)


def _film(path: Path, output: Path, dpi: int | None, options: Mapping[str, object]) -> None:
    from sweep.commands.simulate import read_film, save_film
    from sweep.files.paths import check_target
    from sweep.motion.sampling import check_filmed, kind_of

    if dpi is not None:
        raise RequestError(
            f"A film has a size in pixels, not dots per inch; got --dpi {dpi}.",
            "Write --size 1280x720, for instance.",
        )
    film = read_film(output, **options)
    assert film is not None
    # like a figure, a film may be replaced
    check_target(output, True)
    with _motion_in(path) as dataset:
        check_filmed(kind_of(dataset), f"Draw it: -o {output.stem}.png.")
        save_film(dataset, output, film)


def export_motion(path: Path, words: Sequence[str] | None, target: Path, kind: str, overwrite: bool) -> None:
    """Export the motion in a file to another format, and report what was written.

    Raises
    ------
    RequestError
        If words are given, or the target cannot be written.
    """
    from sweep.files.export import export
    from sweep.files.paths import check_apart

    _check_words(words or [])
    check_apart(target, path)
    with _motion_in(path) as dataset:
        written, *_ = export(dataset, target, kind, overwrite=overwrite)
        count = dataset.sizes.get("elapsed_time", 1)
    say(f"{written}: {counted(count, 'sample')}")


def _check_words(words: Sequence[str]) -> None:
    if words:
        raise RequestError(
            "NAME=VALUE selects a part of an atlas; a motion is always drawn or exported as a whole; got "
            f"{shown(' '.join(words))}.",
            "Leave it out.",
        )


@contextmanager
def _motion_in(path: Path) -> "Iterator[xr.Dataset]":
    """Open the file of a motion, and refuse it if anything is missing."""
    from sweep.files.reading import opened_motion
    from sweep.motion.sampling import check_motion

    with opened_motion(path) as dataset:
        try:
            check_motion(dataset)
        except RequestError as error:
            raise error.at(f"{path}: {error.where}" if error.where else str(path)) from None
        yield dataset
