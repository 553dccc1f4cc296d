"""Messages by their facts: the names, numbers, units and commands in them, not the sentences around these."""

import re
from contextlib import contextmanager

import pytest

from sweep.errors import RequestError


def _pattern(fact):
    """Return what finds a fact as a word of its own: 1 is not in 10, nor tilt in tilt_rate."""
    return (r"(?<![\w.-])" if fact[0].isalnum() else r"(?<!\w)") + re.escape(fact) + r"(?!\.?\w)"


def missing(message, facts):
    """Return the facts that are not in a message as words of their own."""
    return [fact for fact in facts if not re.search(_pattern(fact), message)]


def assert_facts(message, *facts):
    """Assert that each fact is in a message."""
    lacking = missing(message, facts)
    assert not lacking, f"{lacking} missing in: {message}"


def assert_in_order(message, *facts):
    """Assert that each fact is in a message behind the one before: 2 and then 3 allowed, not 3 and then 2."""
    found = re.search(".*?".join(map(_pattern, facts)), message, re.DOTALL)
    assert found, f"{facts} are not in this order in: {message}"


def with_facts(texts, *facts):
    """Return those of some texts, as of the labels of a figure, that have each fact; a line break is a blank."""
    return [each for each in texts if not missing(" ".join(each.split()), facts)]


def row(text, head):
    """Return the line of a report that begins with a word, and those that go on with it, as one line."""
    found = re.search(rf"^{re.escape(head)} .*(?:\n {{4,}}.*)*", text, re.MULTILINE)
    assert found, f"no line begins with {head} in: {text}"
    return " ".join(found[0].split())


@contextmanager
def refused(*facts, error=RequestError):
    """Assert that the block ends with an error whose message has the facts; give what `pytest.raises` gives."""
    with pytest.raises(error) as caught:
        yield caught
    assert_facts(str(caught.value), *facts)
