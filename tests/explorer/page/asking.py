"""Ask the page for windows, points and motions, computed as for its map and panels."""

import numpy as np

#: Ask the page, and return typed arrays with their types.
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
    """A problem that the page reports, with its hint."""


def ask(page, what, **request):
    """Return the page's result: head and arrays of a window or a motion, or the numbers of a point.

    Raises
    ------
    Refused
        If the page reports a problem.
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
