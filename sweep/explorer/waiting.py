"""One thread at a time calls kernels, and work ends when its client has gone.

When a page makes a new request, it closes the connection of the previous one, which ends the work for it.
"""

import threading

#: Held while calling kernels, which use all processors: the threads that answer requests take turns.
KERNELS = threading.RLock()


class ClientGoneError(Exception):
    """The client no longer waits for the answer."""
