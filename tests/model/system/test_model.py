"""The compile cost of a system."""

from messages import refused

from sweep.model.system.model import MOST_SECONDS, model_of
from sweep.request.system_file import read_system


def text_of(states, endings, measures):
    """Return a system with the given numbers of states, endings and maxima; each rate has two products."""
    begun = ", ".join(f"x{k}=0.{k + 1}" for k in range(states))
    rates = ", ".join(f"x{(k + 1) % states}*x{(k + 2) % states} - {k + 1}.5*x{k}**2" for k in range(states))
    ends = ", ".join(f'"e{k}": "x{k % states} > {k + 2}"' for k in range(endings))
    tops = ", ".join(f'"m{k}": "max x{k % states}*{k + 1}"' for k in range(measures))
    return f'@system(duration="10", ends={{{ends}}}, measures={{{tops}}})\ndef many({begun}):\n    return {rates}\n'


def test_a_system_that_would_compile_for_minutes_is_refused():
    """The message counts states, endings, maxima and operations; a slightly smaller system is accepted."""
    assert 5.0 < model_of(read_system(text_of(3, 2, 2))).integrate.seconds < 15.0
    seconds = [model_of(read_system(text_of(8, count, count))).integrate.seconds for count in (0, 10, 20)]
    assert seconds == sorted(seconds)
    assert seconds[-1] <= MOST_SECONDS
    with refused("many", "32 states", "30 conditions", "30 greatest values", "operations", "60 s"):
        model_of(read_system(text_of(32, 30, 30)))
