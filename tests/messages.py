"""Messages by their facts: names, numbers, units and commands, not the sentences around them."""

import re
from contextlib import contextmanager

import pytest

from sweep.errors import RequestError


def _pattern(fact):
    """Return a pattern that finds a fact as a whole word: 1 is not in 10, nor tilt in tilt_rate."""
    return (r"(?<![\w.-])" if fact[0].isalnum() else r"(?<!\w)") + re.escape(fact) + r"(?!\.?\w)"


def missing(message, facts):
    """Return the facts that a message does not contain as whole words."""
    return [fact for fact in facts if not re.search(_pattern(fact), message)]


def assert_facts(message, *facts):
    """Assert that each fact is in a message."""
    lacking = missing(message, facts)
    assert not lacking, f"{lacking} missing in: {message}"


def assert_in_order(message, *facts):
    """Assert that the facts are in a message in this order: 2 and then 3, not 3 and then 2."""
    found = re.search(".*?".join(map(_pattern, facts)), message, re.DOTALL)
    assert found, f"{facts} are not in this order in: {message}"


def with_facts(texts, *facts):
    """Return the texts that have each fact, such as labels of a figure; a line break counts as a blank."""
    return [each for each in texts if not missing(" ".join(each.split()), facts)]


def row(text, head):
    """Return the line of a report that starts with a word, joined with its continuation lines."""
    found = re.search(rf"^{re.escape(head)} .*(?:\n {{4,}}.*)*", text, re.MULTILINE)
    assert found, f"no line begins with {head} in: {text}"
    return " ".join(found[0].split())


@contextmanager
def refused(*facts, error=RequestError):
    """Assert that the block raises an error whose message has the facts; yield what `pytest.raises` yields."""
    with pytest.raises(error) as caught:
        yield caught
    assert_facts(str(caught.value), *facts)
