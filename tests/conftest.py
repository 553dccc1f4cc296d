"""What every test relies on: the same examples in CI, the same terminal everywhere, no window."""

import os

from hypothesis import settings

# Compiling the first kernel takes seconds; hypothesis would count them against the one example that met it.
settings.register_profile("home", deadline=None)
settings.register_profile("ci", deadline=None, derandomize=True, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") == "true" else "home")

os.environ["MPLBACKEND"] = "agg"

# Tests read what the commands print: no colours, and lines as wide as any message.
for name in ("FORCE_COLOR", "PY_COLORS", "GITHUB_ACTIONS"):
    os.environ.pop(name, None)
os.environ.update(NO_COLOR="1", TERM="dumb", COLUMNS="200")
