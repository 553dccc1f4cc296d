"""Hold back questions to the page's workers until a test releases them."""

#: Hold back questions of one kind (piece, cells or call) to workers; `letGo()` sends them.
HOLD = """what => {
    const send = Worker.prototype.postMessage;
    const holds = (message) => message.what === what;
    window.held = [];
    Worker.prototype.postMessage = function (message, ...more) {
        if (holds(message)) window.held.push(() => send.call(this, message, ...more));
        else send.call(this, message, ...more);
    };
    window.letGo = () => {
        Worker.prototype.postMessage = send;
        window.held.splice(0).forEach((each) => each());
    };
}"""


def wait_for_held(page, count):
    """Wait until this many questions are held back."""
    while page.evaluate("held.length") < count:
        page.wait_for_timeout(50)
