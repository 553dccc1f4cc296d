"""What the parser of the command line refuses is said in the four parts of every other refusal, with the way out."""

import pytest
import typer

from sweep.commands.usage import UsageError


@pytest.mark.parametrize(
    ("line", "what", "rule", "given", "do"),
    [
        ("rnu rolling", "unknown command", "the commands are run, plan,", "rnu", "did you mean run?"),
        ("frob", "unknown command", "warmup", "frob", "eulerdisk --help"),
        ("--vresion", "unknown option", "--version, --help", "--vresion", "did you mean --version?"),
        ("run rolling --thread 2 -o a.nc", "unknown option", "--threads", "--thread", "did you mean --threads?"),
        ("run rolling --qqq -o a.nc", "unknown option", "the options of eulerdisk run are --from,", "--qqq",
         "eulerdisk run --help"),
        ("run", "-o OUT.nc is missing", "eulerdisk run needs it", "eulerdisk run", "add -o OUT.nc."),
        ("export a.nc", "--to FORMAT is missing", "csv, parquet or zarr", "eulerdisk export a.nc", "add --to FORMAT."),
        ("info", "ATLAS.nc is missing", "A file made by eulerdisk run", "eulerdisk info", "add ATLAS.nc."),
        ("plot -o a.png", "ATLAS.nc is missing", "eulerdisk plot needs it", "plot -o a.png", "add ATLAS.nc."),
        ("compare a.nc", "REFERENCE.nc is missing", "is trusted", "compare a.nc", "add REFERENCE.nc."),
        ("run rolling -o", "requires an argument", "one value", "run rolling -o", "eulerdisk run --help"),
        ("run rolling --overwrite=3 -o a.nc", "does not take a value", "a switch has none", "--overwrite=3", "--help"),
        ("info a.nc b.nc", "extra argument", "eulerdisk info", "info a.nc b.nc", "eulerdisk info --help"),
        ("run rolling --threads two -o a.nc", "--threads: not a value", "--threads takes a whole number",
         "--threads two", "leave --threads out"),
        ("assemble a.nc.run --max-failed 101", "not a share of the cells", "<= 100", "101", "--max-failed 5"),
        ("run rolling --max-failed=x -o a.nc", "not a value", "--max-failed takes a number", "--max-failed=x",
         "leave --max-failed out"),
    ],
)  # fmt: skip
def test_a_wrong_command_line_is_told_in_four_parts(command, tmp_path, line, what, rule, given, do):
    """A missing or unknown command, argument or option ends with 2, one message, and nothing written."""
    status, out, err = command(line)
    assert (status, out, err.count("\n")) == (2, "", 1)
    told, _, rest = err.removeprefix("eulerdisk: ").partition(" Rule: ")
    ruled, _, rest = rest.partition(" Given: ")
    shown, _, way_out = rest.partition(" Do: ")
    assert what in told
    assert rule in ruled
    assert given in shown
    assert do in way_out
    assert list(tmp_path.iterdir()) == []


def test_no_command_at_all_shows_the_help(command):
    """Who asks for nothing is shown what there is."""
    status, out, err = command("")
    assert status == 2
    assert "Commands:" in out + err


def test_the_parser_s_errors_have_the_class_that_is_caught():
    """Whether typer brings its own click or uses the one installed, its errors are of one class."""
    assert UsageError.__name__ == "UsageError"
    assert issubclass(typer.BadParameter, UsageError)


def test_a_key_press_that_ends_it(command, monkeypatch):
    """Ctrl-C where nothing is kept ends with 130 and without a traceback."""

    def interrupted(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("sweep.request.words.read_file", interrupted)
    monkeypatch.setattr("sweep.request.spec.read_file", interrupted)
    status, out, err = command("run rolling -o a.nc")
    assert (status, out) == (130, "")
    assert "Traceback" not in err
