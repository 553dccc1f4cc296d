"""Turns and ends of work: one thread at a time calls kernels, and what no client waits for any more ends.

A page that asks anew closes the connection of what it asked before: work ends where its client has gone.
"""

import threading

#: Kernels use all processors by themselves: the threads that answer requests call them one after another.
KERNELS = threading.RLock()


class ClientGoneError(Exception):
    """No client waits for the answer any more."""
