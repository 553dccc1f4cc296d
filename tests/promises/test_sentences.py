"""No sentence of the program is taken apart again: errors, reports and tables are data until they are shown.

The test follows sentences within a function: from a field, a method or an attribute that contains one, through names,
to a method of texts or a pattern that takes it apart. Text of a person (words, TOML, expressions) is not among them.
"""

import ast
from pathlib import Path

import sweep

SWEEP = Path(sweep.__file__).parent

#: Fields of records, attributes of atlases, and functions that contain or return sentences.
SENTENCES = {
    "message", "hint", "reason", "rule", "meaning", "remark", "description", "long_name", "headline", "title",
    "summary", "references", "plot_label", "history", "ambiguous", "spell", "in_words", "lost_in_words",
    "open_in_words", "explain", "describe", "caption", "limit_text", "unstable_if", "plain_text", "words_given",
}  # fmt: skip

#: Methods of texts and functions of `re` that take a text apart.
CUTS = {
    "split", "rsplit", "splitlines", "partition", "rpartition", "replace", "removeprefix", "removesuffix", "strip",
    "rstrip", "lstrip", "lower", "upper", "capitalize", "startswith", "endswith", "index", "find", "translate",
    "match", "fullmatch", "search", "sub", "findall", "finditer",
}  # fmt: skip

#: Place -> why it takes a sentence apart.
ALLOWED = {
    "commands/report.py describe": "indents the lines of the history",
    "commands/summary.py summary": "lists the lines of the history, which CF separates so",
    **dict.fromkeys(
        ("model/system/model.py subject", "motion/system_path.py motion_of_system"),
        "the title is the first line of a person's file",
    ),
    **dict.fromkeys(
        ("request/values.py rule_in", "request/values.py converted"),
        "a rule is a chain of comparisons in SI, whose limits are converted to the given unit",
    ),
    "request/values.py at_word": "the checks of models write values in SI into their messages",
    "request/system_source.py at": "puts a sentence behind the word that it is about",
}  # fmt: skip


def _is_sentence(node, names):
    """Return whether an expression is a sentence; `names` are the variables that contain one."""
    match node:
        case ast.Name(id=name):
            return name in names
        case ast.Attribute(value=record, attr="text"):
            return _is_sentence(record, names)
        case ast.Attribute(attr=name) | ast.Subscript(slice=ast.Constant(value=str(name))):
            return name in SENTENCES
        case ast.Call(func=ast.Attribute(attr="get"), args=[ast.Constant(value=key), *_]):
            return key in SENTENCES
        case ast.Call(func=ast.Attribute(value=text, attr=name)):
            return name in SENTENCES or (name in CUTS and _is_sentence(text, names))
        case ast.Call(func=ast.Name(id=name), args=given):
            return name in SENTENCES or (name == "str" and any(_is_sentence(each, names) for each in given))
        case ast.Subscript(value=text):
            return _is_sentence(text, names)
        case ast.BinOp(left=one, right=other) | ast.IfExp(body=one, orelse=other):
            return _is_sentence(one, names) or _is_sentence(other, names)
        case ast.Tuple(elts=parts):
            return any(_is_sentence(each, names) for each in parts)
    return False


def _is_cut(node, names):
    """Return whether an expression takes a sentence apart."""
    match node:
        case ast.Call(func=ast.Attribute(value=text, attr=name), args=given) if name in CUTS:
            return any(_is_sentence(each, names) for each in (text, *given))
        case ast.Subscript(value=text, slice=ast.Slice()):
            return _is_sentence(text, names)
    return False


def _own_nodes(scope):
    """Yield the nodes of a module or a function, except those of the functions in it."""
    for node in ast.iter_child_nodes(scope):
        if not isinstance(node, ast.FunctionDef):
            yield node
            yield from _own_nodes(node)


def cut_sentences(source):
    """Return the functions of a source text that take a sentence apart; "" is the module."""
    tree, found = ast.parse(source), set()
    for scope in [tree, *(node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))]:
        nodes, names = list(_own_nodes(scope)), set()
        for node in nodes:
            if isinstance(node, ast.Assign | ast.NamedExpr) and _is_sentence(node.value, names):
                targets = node.targets if isinstance(node, ast.Assign) else [node.target]
                names |= {
                    each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)
                }
        if any(_is_cut(node, names) for node in nodes):
            found.add(getattr(scope, "name", ""))
    return found


def test_no_sentence_is_taken_apart():
    """Each place that does is allowed by name and has a reason; a place that no longer does is not allowed."""
    found = {
        f"{path.relative_to(SWEEP).as_posix()} {function}"
        for path in SWEEP.rglob("*.py")
        for function in cut_sentences(path.read_text("utf-8"))
    }
    assert found == ALLOWED.keys()


def test_the_next_place_is_found():
    """Planted faults are found, each in another way of taking a sentence apart; the parsing of a request is not."""
    faults = (
        'return error.message.partition("; got ")[0]',
        'problem, hint = error.message, error.hint\n    return problem.removesuffix(".")',
        'return re.sub("^repeated .*", "", explain(atlas, {}).text)',
        'return dataset.attrs["history"].splitlines()[0]',
        'return shlex.split(plain_text(dataset.attrs.get("history", "")).partition(" ")[2])',
        'return replace(row, long_name=row.long_name.replace("the disk", "the body"))',
        'return (motion := model.headline(spec))[: motion.index(":")]',
    )
    for fault in faults:
        assert cut_sentences(f"def fault(error, dataset, row, model, spec):\n    {fault}\n") == {"fault"}, (
            fault
        )
    assert cut_sentences('def parse(raw):\n    return raw.partition("=")\n') == set()
