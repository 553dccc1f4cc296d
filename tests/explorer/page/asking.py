"""What tests ask the page itself: windows, points and motions, as it computes them for its map and its panels."""

import numpy as np

#: Ask the page, and return typed arrays with their kind.
ASK = """async ([what, request]) => {
    if (!window.asking) {
        const { ServerSource } = await import("eulerdisk/server_source");
        window.asking = new ServerSource();
    }
    const plain = (array) => array && { numbers: Array.from(array), isCoded: array instanceof Uint8Array };
    try {
        const found = await window.asking[what](request);
        if (what === "window") {
            const { head, value, verdict, stored } = found;
            return { head, arrays: { value: plain(value), verdict: plain(verdict), stored: plain(stored) } };
        }
        if (what !== "motion") return { found };
        const arrays = Object.entries(found.arrays).map(([name, array]) => [name, plain(array)]);
        return { head: found.head, arrays: Object.fromEntries(arrays) };
    } catch (problem) {
        return { refused: { error: problem.message, hint: problem.hint ?? "", status: problem.status ?? 0 } };
    }
}"""


class Refused(Exception):  # noqa: N818 - no error of the test
    """The page tells a problem: its words, and what to do."""


def ask(page, what, **request):
    """Return what the page computes: head and arrays of a window or a motion, or the answer of a point.

    Raises
    ------
    Refused
    """
    answer = page.evaluate(ASK, [what, request])
    if "refused" in answer:
        raise Refused(" ".join(filter(None, [answer["refused"]["error"], answer["refused"]["hint"]])))
    if "head" not in answer:
        return answer["found"]
    arrays = {
        name: np.array(each["numbers"], np.uint8 if each["isCoded"] else np.float64)
        for name, each in answer["arrays"].items()
        if each is not None
    }
    return answer["head"], arrays
