"""Files appear whole: files opened for writing are new, and one module does all opening, renaming and removing."""

import ast
import os
from pathlib import Path

import pytest

from sweep import atomic
from sweep.errors import StorageError
from sweep.files.publish import published, published_folder

CHECKOUT = Path(__file__).parents[1]
TOKEN = "0123456789abcdef"

#: System functions that write, rename or link.
SYSTEM = {
    f"{module}.{name}"
    for module, names in {
        "os": ("open", "rename", "renames", "replace", "link", "symlink", "truncate", "mkfifo", "mknod"),
        "shutil": ("copy", "copy2", "copyfile", "copytree", "move"),
        "tempfile": ("mkstemp", "mkdtemp", "TemporaryFile", "NamedTemporaryFile", "TemporaryDirectory"),
    }.items()
    for name in names
}
#: Flags of `os.open` that write or create.
WRITING_FLAGS = {"O_WRONLY", "O_RDWR", "O_CREAT", "O_TRUNC", "O_APPEND"}
#: System functions that remove.
REMOVING = {"os.unlink", "os.remove", "os.rmdir", "os.removedirs", "shutil.rmtree"}
#: Methods that write to or rename a path, on any object.
METHODS = {"write_text", "write_bytes", "touch", "rename", "symlink_to", "hardlink_to", "mkfifo"}
#: Methods that remove a path.
REMOVING_METHODS = {"unlink", "rmdir"}
#: Library functions that write to a given name.
LIBRARIES = {"to_netcdf", "to_csv", "to_zarr", "to_parquet", "ParquetWriter", "savefig", "savez", "save_all"}
#: The variable of a ``with published(...) as`` statement: a temporary name that may be written to.
TEMPORARY = "unfinished"

#: The only module that opens and renames, and those that remove only what they have created.
WRITER = "sweep/atomic.py"
REMOVERS = {
    WRITER,
    "sweep/files/publish.py",
    "sweep/runs/run_directory.py",
    "sweep/runs/run.py",
    "sweep/runs/folder.py",
    "sweep/explorer/explorer.py",
}


#: False positives: renamed variables; the atlas file, which two libraries open under the temporary name given to
#: `AtlasWriter`; the device that replaces a closed stream.
EXCEPTIONS = {
    "sweep/accessor.py .rename",
    "sweep/accessor.py verdict.rename",
    "sweep/model/disk/contact.py slips.rename",
    # Into memory.
    "sweep/figures/sheet.py self.savefig",
    "sweep/files/atlas_writer.py netCDF4.Dataset",
    "sweep/files/raw_chunks.py h5py.File",
    "sweep/commands/process.py os.open",
}


def called(node):
    """Return the dotted name of a call's function, as far as it has one."""
    parts = []
    at = node.func
    while isinstance(at, ast.Attribute):
        parts.append(at.attr)
        at = at.value
    return ".".join(reversed([*parts, at.id if isinstance(at, ast.Name) else ""]))


def opens_for_writing(node):
    """Return whether a call of `open` has a mode that writes or that cannot be read off."""
    place = 1 if isinstance(node.func, ast.Name) else 0
    mode = [*node.args[place : place + 1], *(each.value for each in node.keywords if each.arg == "mode")]
    return bool(mode) and not (isinstance(mode[0], ast.Constant) and set(mode[0].value) <= set("rbt"))


def reads_only(node):
    """Return whether a call of `os.open` has only literal flags, none of which writes."""
    named = [each for each in ast.walk(node.args[1]) if isinstance(each, ast.Name)]
    flags = {each.attr for each in ast.walk(node.args[1]) if isinstance(each, ast.Attribute)}
    return all(each.id == "os" for each in named) and "O_RDONLY" in flags and not flags & WRITING_FLAGS


def reads_dataset(node):
    """Return whether a call that opens a netCDF or HDF5 file has a literal mode that only reads."""
    mode = [*node.args[1:2], *(each.value for each in node.keywords if each.arg == "mode")]
    return all(isinstance(each, ast.Constant) and each.value == "r" for each in mode)


def writes(text):
    """Yield (line, name, whether it removes) of every call in a source that does not write to a temporary name."""
    for node in ast.walk(ast.parse(text)):
        if not isinstance(node, ast.Call):
            continue
        name = called(node)
        last = name.rpartition(".")[2]
        target = node.func.value if isinstance(node.func, ast.Attribute) else None
        targets = [each.id for each in (target, *node.args) if isinstance(each, ast.Name)]
        if name in REMOVING or last in REMOVING_METHODS:
            yield node.lineno, name, True
        elif TEMPORARY in targets or (name == "os.open" and reads_only(node)):
            continue
        elif (
            name in SYSTEM
            or last in METHODS | LIBRARIES
            or (last == "open" and opens_for_writing(node))
            or (last in ("Dataset", "File") and name != "xr.Dataset" and not reads_dataset(node))
        ):
            yield node.lineno, name, False


def test_one_module_writes():
    """All files of `sweep` are created, renamed and replaced in one module, or written to a name it provides.

    Other ways of writing risk planted links, predictable names or half-written files, which that module prevents. Only
    the rooms that created a file remove it.
    """
    found = []
    for path in sorted((CHECKOUT / "sweep").rglob("*.py")):
        place = str(path.relative_to(CHECKOUT))
        for line, name, removes in writes(path.read_text(encoding="utf-8")):
            if place not in (REMOVERS if removes else {WRITER}) and f"{place} {name}" not in EXCEPTIONS:
                found.append(f"{place}:{line} {name}")
    assert found == []


def test_the_search_finds_what_writes():
    """Each way of writing is found; reading, and writing to a temporary name, is not."""
    for line in [
        "open(path, 'w')",
        "open(path, mode=how)",
        "os.open(path, flags)",
        "os.open(path, os.O_WRONLY | os.O_EXCL)",
        "path.write_text('x')",
        "path.open('w')",
        "figure.savefig(path)",
        "os.replace(a, b)",
        "shutil.rmtree(path)",
        "path.unlink()",
        "netCDF4.Dataset(path, 'a')",
        "h5py.File(path, mode)",
    ]:
        assert len(list(writes(line))) == 1
        assert not list(
            writes(
                "open(path, 'rb'); os.open(path, os.O_RDONLY); unfinished.write_text('x'); drawn.savefig(unfinished)"
            )
        )


@pytest.fixture
def victim(tmp_path, monkeypatch):
    """Return a file that must not change, with a link to it under the next temporary name."""
    path = tmp_path / "victim"
    path.write_text("mine")
    monkeypatch.setattr(atomic.secrets, "token_hex", lambda _: TOKEN)
    (tmp_path / f".eulerdisk-{TOKEN}.tmp").symlink_to(path)
    return path


def test_a_planted_link_is_not_followed(tmp_path, victim):
    """Even if someone guesses the name, a link with that name is an error, and its target is unchanged."""
    with pytest.raises(FileExistsError):
        atomic.publish_bytes(tmp_path / "a", b"new")
    with pytest.raises(StorageError, match="File exists"), published(tmp_path / "a") as unfinished:
        unfinished.write_text("new")
    with pytest.raises(StorageError, match="File exists"), published_folder(tmp_path / "a"):
        pass
    with pytest.raises(OSError, match="symbolic links"):
        atomic.open_or_create(tmp_path / f".eulerdisk-{TOKEN}.tmp")
    assert victim.read_text() == "mine"
    assert sorted(path.name for path in tmp_path.iterdir()) == [f".eulerdisk-{TOKEN}.tmp", "victim"]


def test_names_cannot_be_guessed(tmp_path):
    """Temporary names share nothing except the marks of this program."""
    names = {atomic.create_temporary(tmp_path).name for _ in range(20)}
    assert len(names) == 20
    assert all(atomic.TEMPORARY.fullmatch(name) for name in names)
    assert str(os.getpid()) not in "".join(name[11:27] for name in names if len(str(os.getpid())) > 3)


def test_a_trial_leaves_nothing(tmp_path):
    """A trial of a name fails as publishing would, and leaves nothing in either case."""
    for name in ("a.nc", " a ", "y" * 255):
        atomic.try_publishing(tmp_path / name)
    (tmp_path / "other").mkdir()
    atomic.try_publishing(tmp_path / "a.nc", source=tmp_path / "other")
    with pytest.raises(OSError, match="No such file"):
        atomic.try_publishing(tmp_path / "missing" / "a.nc")
    assert [path.name for path in tmp_path.rglob("*")] == ["other"]


def test_a_folder_replaces_a_folder(tmp_path):
    """A published folder replaces a folder, or a link to one without changing its target; on error nothing changes."""
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "a").touch()
    (tmp_path / "link").symlink_to("old")
    with published_folder(tmp_path / "link") as unfinished:
        (unfinished / "b").touch()
    with pytest.raises(ValueError, match="a defect"), published_folder(tmp_path / "old") as unfinished:
        raise ValueError("a defect")
    assert sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*")) == [
        "link",
        "link/b",
        "old",
        "old/a",
    ]
    with published_folder(tmp_path / "old"):
        pass
    assert list((tmp_path / "old").iterdir()) == []
