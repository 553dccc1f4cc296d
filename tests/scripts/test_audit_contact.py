"""The arguments of scripts/audit_contact.py; its long forms are run by hand."""

import audit_contact


def test_it_says_which_parts_there_are(capsys):
    """With --help it prints its text and succeeds."""
    assert audit_contact.main(["--help"]) == 0
    assert capsys.readouterr() == (f"{audit_contact.__doc__}\n", "")


def test_other_words_are_refused(capsys):
    """Without arguments, or with unknown ones, it prints its text as a message and ends with status 2."""
    for words in ("", "x", "random x", "random -5", "random 0", "grazing 1 2 3", "rolling 0", "rolling 1 2"):
        assert audit_contact.main(words.split()) == 2, words
        assert capsys.readouterr() == ("", f"{audit_contact.__doc__}\n"), words


def test_the_first_word_names_the_part(monkeypatch):
    """A preset, random or grazing starts, with the numbers that follow; the status is the part's."""
    for name in ("preset", "random"):
        monkeypatch.setattr(audit_contact, f"audit_{name}", lambda *given, name=name: (name, *given))
    assert audit_contact.main(["circling", "100"]) == ("preset", "circling", 100)
    assert audit_contact.main(["random", "400", "0"]) == ("random", "random", 400, 0)
    assert audit_contact.main(["grazing"]) == ("random", "grazing")
