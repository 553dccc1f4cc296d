"""The time that a file says it was made."""

import os
import time

from sweep.errors import RequestError


def created() -> str:
    """Return the time that an atlas says it was made, ISO 8601 in UTC: now, or $SOURCE_DATE_EPOCH.

    Raises
    ------
    RequestError
        If that is no time.
    """
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    try:
        return time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(None if epoch is None else int(epoch)))
    except (ValueError, OverflowError, OSError) as problem:
        name = "SOURCE_DATE_EPOCH"
        raise RequestError(
            "not a time", f"{name} is a number of seconds since 1970", repr(epoch), f"unset {name}", name
        ) from problem
